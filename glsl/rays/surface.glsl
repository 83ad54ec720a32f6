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
// Tracing. To the robust test it adds nothing to speak of: the ray's line is exact, and the sign of t. The fast test's t is
// off by 8 u of e₂·(f × e₁), f from the corner a to the origin, in absolute values (src/oracle/bounds.rs): along the normal
// by 48 u L³ / 2 A at most, where all products are as large as can be and all roundings of one sign. Half of that, and
// 32 u L for rays that graze, keep it off as well. L² / 2 A is 1 to 4 for most triangles, and large for slivers, off which
// no ray should start by what shows: beyond 16 it counts as 16.
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
