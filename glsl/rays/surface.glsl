// Where a primary met the scene. Wants args.{start}, triangles, rays, hits.
#include "rays/root.glsl"

// How far secondary origins lie off the triangle, as a share of the largest coordinate of its corners: a bound on what
// rounding does. With u = 2⁻²⁴ and that coordinate 1: the point a + (u e₁ + v e₂) lies within 12 u of the plane (edges
// 2 u, products 2 u, sums 3 u in each axis), and tracing from it moves the ray by up to 4 u of the farthest corner's
// distance, which is 2√3 at most: 14 u. The sum of both and the same again for the ray's slope against the plane is
// 52 u; this is 64 u. The hit's t does not enter: the weights u, v hold the point within the triangle whatever t is.
const float OFFSET = 1.0 / 262144.0;

vec3 corner(uint at) { return vec3(P(triangles).at[at], P(triangles).at[at + 1], P(triangles).at[at + 2]); }

// The surface under primary i, its normal facing the ray; false where there is none.
bool surface_of(uint i, out Surface surface) {
    uint triangle = P(hits).at[i * 4 + 1];
    if (triangle == INVALID) return false;
    vec3 a = corner(triangle * 9), b = corner(triangle * 9 + 3), c = corner(triangle * 9 + 6);
    precise vec3 e1 = b - a;
    precise vec3 e2 = c - a;
    vec3 normal;
    if (!unit(outer(levelled(e1), levelled(e2)), normal)) return false;
    vec3 direction = vec3(P(rays).at[i * 8 + 4], P(rays).at[i * 8 + 5], P(rays).at[i * 8 + 6]);
    if (inner(normal, levelled(direction)) > 0.0) normal = -normal;
    float u = uintBitsToFloat(P(hits).at[i * 4 + 2]), v = uintBitsToFloat(P(hits).at[i * 4 + 3]);
    precise vec3 point = a + (u * e1 + v * e2);
    precise vec3 origin = point + normal * (OFFSET * max(largest(a), max(largest(b), largest(c))));
    surface = Surface(origin, normal, i);
    return true;
}
