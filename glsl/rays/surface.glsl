// Where a primary met the scene. Wants args.{start}, triangles, rays, hits.
#include "rays/root.glsl"
#include "lib/triangle.glsl"

// How far off the triangle secondary rays start: a bound on what rounding does to this very point. u = 2⁻²⁴, n is the unit
// normal, L the longest of the triangle's extents along the axes, A its area.
//
// The point. Of a + (U e₁ + V e₂) the edges are off by 1 u, products by 1 u, the inner sum by 1 u: 3 u (|U e₁| + |V e₂|)
// in each axis, and the outer sum by u |point|. So it lies within the sum over the axes of |n| times that of the plane,
// and the lift, a sum of about that size, is rounded by as much as the outer one. With what is of second order, and for
// the rounding of the bound itself: 4 u (|U e₁| + |V e₂|) + 2½ u |point|.
//
// Tracing. With doubles it adds nothing to speak of: the ray's line is exact, and the sign of t but for 2⁻⁵⁰ of what
// follows. In single precision (lib/hit.glsl) a sheared corner is off by 10 u L in two axes, its depth by 1 u L, products
// and sums of depths by 3 u L; along the normal, of which two components add up to √2 at most, less than 24 u L. Products of
// sheared corners, for the ray starts between them, add up to 16 L² at most for all three weights and are off by that
// times u; as the weights add up to 2 A along the normal, their sum moves depths by 16 u L² · L / 2 A. A tenth more for rays
// that graze: 32 u L + 24 u L · L² / 2 A. L² / 2 A is 1 to 4 for most triangles, and large for slivers, off which no ray
// should start by what shows: beyond 16 it counts as 16, and without doubles a ray may find such a sliver before itself.
const float U = 1.0 / 16777216.0;

// The surface under primary i, its normal facing the ray; false where there is none.
bool surface_of(uint i, out Surface surface) {
    Hit hit = LOAD_Hit(hits, i);
    if (hit.triangle == INVALID) return false;
    Corners t = LOAD_CORNERS(triangles, hit.triangle);
    precise vec3 e1 = t.b - t.a;
    precise vec3 e2 = t.c - t.a;
    vec3 across = outer(levelled(e1), levelled(e2)), normal;
    if (!unit(across, normal)) return false;
    vec3 direction = LOAD_Ray(rays, i).direction;
    if (inner(normal, levelled(direction)) > 0.0) normal = -normal;
    precise vec3 first = hit.u * e1;
    precise vec3 second = hit.v * e2;
    precise vec3 point = t.a + (first + second);

    float extent = max(largest(e1), max(largest(e2), largest(t.c - t.b)));
    vec3 l = levelled(across);
    // L² / 2 A, both of levelled edges.
    precise float over_area = level_of(across) * inverse_root(inner(l, l));
    precise float slenderness = (extent * level_of(e1)) * (extent * level_of(e2)) * over_area;
    precise vec3 off = 4.0 * (abs(first) + abs(second)) + 2.5 * abs(point);
    precise float lift = U * (inner(abs(normal), off) + extent * (32.0 + 24.0 * min(slenderness, 16.0)));
    precise vec3 origin = point + normal * lift;
    surface = Surface(origin, normal, i, 0);
    return true;
}
