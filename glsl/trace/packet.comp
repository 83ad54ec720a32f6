// One subgroup a packet of consecutive rays that walk the tree together, each ray's result as in trace/single.
// Reads rays, nodes, triangles. For coherent rays where gathering a node for each ray is dear (software drivers):
// a node is fetched once a packet and visited if any ray hits it.
#include "lib/ray.glsl"
#include "lib/hit.glsl"
#include "lib/packet.glsl"

layout(constant_id = SPEC_STACK) const uint STACK = 64;

void main() {
    uint ray = ray_index();
    bool active_ray = ray < args.count;
    Setup s = prepare(LOAD_Ray(rays, min(ray, args.count - 1)));
    active_ray = active_ray && s.valid;
    Nearest nearest = Nearest(active_ray ? s.t_max : uintBitsToFloat(0xff800000u), INVALID, vec2(0.0));
    Tests tests = Tests(0, 0);
    bvec3 negative = lessThan(s.inverse, vec3(0.0));

    uint stack[STACK];
    uint top = 0;
    uint node = args.root;
    while (node != INVALID) {
        if (node < LEAF_BIT) {
            Node n = shared_node(node);
            vec3 n0 = mix(n.left_bounds.lo, n.left_bounds.hi, negative) * s.inverse + s.near;
            vec3 f0 = mix(n.left_bounds.hi, n.left_bounds.lo, negative) * s.inverse + s.far;
            vec3 n1 = mix(n.right_bounds.lo, n.right_bounds.hi, negative) * s.inverse + s.near;
            vec3 f1 = mix(n.right_bounds.hi, n.right_bounds.lo, negative) * s.inverse + s.far;
            float enter0 = greatest_of(greatest_of(n0.x, n0.y), greatest_of(n0.z, s.t_min));
            float leave0 = least_of(least_of(f0.x, f0.y), least_of(f0.z, nearest.t));
            float enter1 = greatest_of(greatest_of(n1.x, n1.y), greatest_of(n1.z, s.t_min));
            float leave1 = least_of(least_of(f1.x, f1.y), least_of(f1.z, nearest.t));
            bool hit0 = enter0 <= leave0, hit1 = enter1 <= leave1;
            if (COUNT != 0 && active_ray) tests.boxes += 2;
            bool any0 = subgroupAny(hit0), any1 = subgroupAny(hit1);
            if (any0 && any1) {
                // The child that more rays meet first.
                uint first = subgroupBallotBitCount(subgroupBallot(hit1 && (!hit0 || enter1 < enter0)));
                uint second = subgroupBallotBitCount(subgroupBallot(hit0 && (!hit1 || enter0 <= enter1)));
                bool swap = first > second;
                stack[top++] = swap ? n.left : n.right;
                node = swap ? n.right : n.left;
            } else if (any0 || any1) {
                node = any0 ? n.left : n.right;
            } else {
                node = top == 0 ? INVALID : stack[--top];
            }
        } else {
            uint place = leaf_first(node);
            uint end = place + leaf_count(node);
            for (; place < end; ++place) {
                bool wanted = active_ray && (ANY == 0 || nearest.triangle == INVALID);
                if (COUNT != 0 && wanted) tests.triangles += 1;
                PackedTriangle triangle = shared_triangle(place);
                if (wanted) meet_triangle(s, triangle, nearest);
            }
            if (ANY != 0) {
                if (nearest.triangle != INVALID) nearest.t = uintBitsToFloat(0xff800000u);
                if (subgroupAll(!active_ray || nearest.triangle != INVALID)) break;
            }
            node = top == 0 ? INVALID : stack[--top];
        }
        node = subgroupBroadcastFirst(node);
    }
    if (ray < args.count) {
        Hit hit = hit_of(s, nearest);
        STORE_Hit(hits, ray, hit)
        if (COUNT != 0) STORE_Tests(tests, ray, tests)
    }
}
