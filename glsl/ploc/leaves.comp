// One invocation ITEMS Morton ranks: the box of each triangle in unit space, and its cluster of one.
// Reads triangles, order.
// Keeps: no area underflows, which would be 0 on some devices and denormal on others. Coordinates within 2⁻⁴⁰ of 0
// become 0, so that all others are 2⁻⁶³ apart at least; a ray's boxes are padded by far more (lib/ray.glsl).
#include "lib/triangle.glsl"
#include "lib/pair.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

vec3 settled(vec3 p) { return mix(p, vec3(0.0), lessThan(abs(p), vec3(1.0 / 1099511627776.0))); }

void main() {
    FOR_ITEMS(i, args.count) {
        uint triangle = P(order).at[i];
        Corners t = LOAD_CORNERS(triangles, triangle);
        // Not min and max: of −0 and +0 they take either, and −0 makes another tree.
        vec3 least = least_of(t.a, least_of(t.b, t.c)), greatest = greatest_of(t.a, greatest_of(t.b, t.c));
        precise vec3 lo = least * args.scale - args.anchor;
        precise vec3 hi = greatest * args.scale - args.anchor;
        Aabb box = Aabb(settled(lo), settled(hi));
        precise float cost = args.triangle_cost * half_area(box);
        Cluster cluster = Cluster(LEAF_BIT | i, i, 1, cost);
        STORE_Aabb(bounds, i, box)
        STORE_Cluster(clusters, i, cluster)
    }
}
