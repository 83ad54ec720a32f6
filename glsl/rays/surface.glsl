// Where a primary met the scene. Wants args.{start}, triangles, rays, hits.
#include "rays/root.glsl"
#include "lib/triangle.glsl"

// How far secondary origins lie off the triangle, as a share of the largest coordinate of its corners: a bound on what
// rounding does. With u = 2⁻²⁴ and that coordinate 1, the point a + (u e₁ + v e₂) lies within 12 u of the plane (edges
// 2 u, products 2 u, sums 3 u in each axis); tracing from it moves the ray by up to 4 u of the distance to a corner,
// 2√3 at most, hence 14 u; lifting rounds by 2 u. That is 28 u; this is 64 u, for normals of slivers are not exact. The
// hit's t does not enter: the weights keep the point within the triangle however long the primary was.
const float OFFSET = 1.0 / 262144.0;

// The surface under primary i, its normal facing the ray; false where there is none.
bool surface_of(uint i, out Surface surface) {
    Hit hit = LOAD_Hit(hits, i);
    if (hit.triangle == INVALID) return false;
    Corners t = LOAD_CORNERS(triangles, hit.triangle);
    precise vec3 e1 = t.b - t.a;
    precise vec3 e2 = t.c - t.a;
    vec3 normal;
    if (!unit(outer(levelled(e1), levelled(e2)), normal)) return false;
    vec3 direction = LOAD_Ray(rays, i).direction;
    if (inner(normal, levelled(direction)) > 0.0) normal = -normal;
    precise vec3 point = t.a + (hit.u * e1 + hit.v * e2);
    precise vec3 origin = point + normal * (OFFSET * max(largest(t.a), max(largest(t.b), largest(t.c))));
    surface = Surface(origin, normal, i, 0);
    return true;
}
