// Clusters of one triangle. Wants lib/box.glsl, the buffer triangles and args.{scale, anchor, triangle_cost}.
#include "lib/triangle.glsl"

// Box of a triangle, unit space.
Aabb leaf_box(uint triangle) {
    Corners t = LOAD_CORNERS(triangles, triangle);
    // Not min and max: of −0 and +0 they take either, and −0 makes another tree.
    vec3 least = least_of(t.a, least_of(t.b, t.c)), greatest = greatest_of(t.a, greatest_of(t.b, t.c));
    precise vec3 lo = least * args.scale - args.anchor;
    precise vec3 hi = greatest * args.scale - args.anchor;
    return Aabb(lo, hi);
}

Cluster leaf_cluster(uint rank, Aabb box) {
    precise float cost = args.triangle_cost * half_area(box);
    return Cluster(LEAF_BIT | rank, rank, 1, cost);
}
