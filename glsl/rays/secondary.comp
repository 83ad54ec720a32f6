// One invocation a secondary ray: `samples` of them leave each surface, about its normal, by the cosine [Halton60]:
// r = √u, φ = 2πv, z = √(1 − u). Points are in 24-bit fixed point, turned (Cranley–Patterson) by two hashes of the
// primary's index. Reads surfaces, points, taken. Keeps: z >= 2⁻¹², so every ray leaves on the normal's side.
#include "rays/root.glsl"

// [Wellons18] lowbias32.
uint hash(uint x) {
    x = (x ^ x >> 16) * 0x7feb352du;
    x = (x ^ x >> 15) * 0x846ca68bu;
    return x ^ x >> 16;
}

float root(float x) {
    precise float y = x * inverse_root(x);
    return y;
}

// Cosine and sine of 2π · turn / 2²⁴, within 2⁻²²: the nearest quarter turn, and Taylor's polynomials within π/4.
vec2 turned(uint turn) {
    uint from = turn + 0x200000u;
    precise float x = float(int(from & 0x3fffffu) - 0x200000) * 3.7450702829239286e-7;
    precise float q = x * x;
    precise float s = x + x * q * (-0.16666667 + q * (0.0083333333 + q * (-0.00019841270 + q * 2.7557319e-6)));
    precise float c = 1.0 - q * (0.5 - q * (0.041666667 - q * (0.0013888889 - q * 0.000024801587)));
    uint quarter = from >> 22 & 3u;
    vec2 t = (quarter & 1u) != 0u ? vec2(-s, c) : vec2(c, s);
    return (quarter & 2u) != 0u ? -t : t;
}

void main() {
    uint i = invocation_index();
    uint which = i / args.samples;
    if (which >= min(P(taken).at[0], args.limit)) return;
    uint sample_index = i - which * args.samples;
    Surface surface = LOAD_Surface(surfaces, which);
    uvec2 point = words_of(P(points).at[sample_index]);
    uint u = point.x + (hash(2 * surface.primary) >> 8) & 0xffffffu;
    uint v = point.y + (hash(2 * surface.primary + 1) >> 8) & 0xffffffu;
    float r = root(float(u) * (1.0 / 16777216.0));
    float z = root(float(16777216u - u) * (1.0 / 16777216.0));
    precise vec2 disc = turned(v) * r;

    vec3 n = surface.normal;
    vec3 tangent;
    unit(abs(n.x) > abs(n.z) ? vec3(-n.y, n.x, 0.0) : vec3(0.0, -n.z, n.y), tangent);
    precise vec3 direction = tangent * disc.x + outer(n, tangent) * disc.y + n * z;
    STORE_Ray(rays, i, Ray(surface.origin, 0.0, direction, args.t_max))
}
