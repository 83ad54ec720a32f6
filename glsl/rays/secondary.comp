// One invocation a secondary ray: `samples` of them leave each surface, about its normal, by the cosine [Halton60]:
// r = √u, φ = 2πv, z = √(1 − u). Reads surfaces, points, taken. Keeps: z >= 2⁻¹², so every ray leaves on the normal's side.
#include "rays/points.glsl"

void main() {
    uint i = invocation_index();
    uint which = i / args.samples;
    if (which >= min(P(taken).at[0], args.limit)) return;
    uint sample_index = i - which * args.samples;
    Surface surface = LOAD_Surface(surfaces, which);
    uvec2 uv = point_of(sample_index, surface.primary);
    float r = root(float(uv.x) * (1.0 / 16777216.0));
    float z = root(float(16777216u - uv.x) * (1.0 / 16777216.0));
    precise vec2 disc = turned(uv.y) * r;

    vec3 n = surface.normal;
    vec3 tangent;
    unit(abs(n.x) > abs(n.z) ? vec3(-n.y, n.x, 0.0) : vec3(0.0, -n.z, n.y), tangent);
    precise vec3 direction = tangent * disc.x + outer(n, tangent) * disc.y + n * z;
    STORE_Ray(rays, i, Ray(surface.origin, 0.0, direction, args.t_max))
}
