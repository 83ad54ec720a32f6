// Clusters of one triangle. Wants lib/box.glsl, the buffer triangles and args.{scale, anchor, triangle_cost}.
#include "lib/triangle.glsl"

// No area underflows, which would be 0 on some devices and denormal on others: coordinates within 2⁻⁴⁰ of 0 become 0, so
// that all others are 2⁻⁶³ apart at least; a ray's boxes are padded by far more (lib/ray.glsl).
vec3 settled(vec3 p) { return mix(p, vec3(0.0), lessThan(abs(p), vec3(1.0 / 1099511627776.0))); }

// Box of a triangle, unit space.
Aabb leaf_box(uint triangle) {
    Corners t = LOAD_CORNERS(triangles, triangle);
    // Not min and max: of −0 and +0 they take either, and −0 makes another tree.
    vec3 least = least_of(t.a, least_of(t.b, t.c)), greatest = greatest_of(t.a, greatest_of(t.b, t.c));
    precise vec3 lo = least * args.scale - args.anchor;
    precise vec3 hi = greatest * args.scale - args.anchor;
    return Aabb(settled(lo), settled(hi));
}

Cluster leaf_cluster(uint rank, Aabb box) {
    precise float cost = args.triangle_cost * half_area(box);
    return Cluster(LEAF_BIT | rank, rank, 1, vec3(cost));
}
