// One subgroup a packet of consecutive rays that walk the tree together, each ray's result as in trace/single.
// Reads rays, nodes, triangles. For coherent rays where gathering a node for each ray is dear (software drivers):
// a node is fetched once a packet and visited if any ray hits it.
#include "lib/ray.glsl"
#include "lib/node.glsl"
#include "lib/hit.glsl"
#include "lib/packet.glsl"
#include "lib/steps.glsl"

layout(constant_id = SPEC_STACK) const uint STACK = 64;

void main() {
    uint index = first_ray(1);
    bool in_range = index < args.count;
    uint ray = ray_at(min(index, args.count - 1));
    Setup s = prepare(LOAD_Ray(rays, ray));
    bool active_ray = in_range && s.valid;
    Nearest nearest = none_yet(s);
    if (!active_ray) nearest.limit = uintBitsToFloat(0xff800000u);
    Tests tests = Tests(0, 0, 0, 0);
    steps = Steps(0, 0, 0, 0);

    // Without the t where a child is entered: to keep it costs a packet more than it saves.
    uint stack[STACK];
    uint top = 0;
    uint node = args.root;
    while (node != INVALID) {
        if (node < LEAF_BIT) {
            Node n = shared_node(node);
            if (in_frame(n)) turn(s, n.frame);
            ivec4 keys = meet_children(s, n, nearest.limit);
            if (COUNT != 0 && active_ray) count_boxes(tests, n);
            // Rays that meet none of the children are carried along.
            if (STEPS != 0 && active_ray) count_node(any(lessThan(keys, ivec4(MISSED))));
            // The child that some ray meets first goes first.
            [[unroll]] for (int k = 0; k < WIDTH; ++k) keys[k] = subgroupMin(keys[k]);
            keys = sorted(keys);
            if (keys.w < MISSED) stack[top++] = child_of(n, keys.w);
            if (keys.z < MISSED) stack[top++] = child_of(n, keys.z);
            if (keys.y < MISSED) stack[top++] = child_of(n, keys.y);
            if (keys.x < MISSED) node = child_of(n, keys.x);
            else node = top == 0 ? INVALID : stack[--top];
        } else {
            uint place = leaf_first(node);
            uint end = place + leaf_count(node);
            for (; place < end; ++place) {
                bool wanted = active_ray && (ANY == 0 || nearest.triangle == INVALID);
                if (COUNT != 0 && wanted) tests.triangles += 1;
                if (STEPS != 0 && active_ray) count_triangle(wanted);
                PackedTriangle triangle = shared_triangle(place);
                if (wanted) meet_triangle(s, triangle, nearest);
            }
            if (ANY != 0) {
                if (nearest.triangle != INVALID) nearest.limit = uintBitsToFloat(0xff800000u);
                if (subgroupAll(!active_ray || nearest.triangle != INVALID)) break;
            }
            node = top == 0 ? INVALID : stack[--top];
        }
        node = subgroupBroadcastFirst(node);
    }
    if (in_range) {
        Hit hit = hit_of(s, nearest);
        STORE_Hit(hits, ray, hit)
        if (COUNT != 0) STORE_Tests(tests, ray, tests)
        if (STEPS != 0) STORE_Steps(steps, ray, steps)
    }
}
