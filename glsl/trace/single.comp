// One invocation a ray: its nearest hit, or with ANY whether there is one. Reads rays, nodes, triangles.
// While-while [Aila09], nearer child first; a popped node is not tested again: keeping its t costs more than it saves.
// The stack holds one entry a level at most, and STACK is no less than the tree is deep.
#include "lib/ray.glsl"
#include "lib/hit.glsl"

layout(constant_id = SPEC_STACK) const uint STACK = 64;

void main() {
    uint ray = ray_index();
    if (ray >= args.count) return;
    Setup s = prepare(P(rays).at[ray]);
    Nearest nearest = Nearest(s.t_max, INVALID, vec2(0.0));
    Tests tests = Tests(0, 0);

    // Which word of a box each ray meets first: loading by index saves a minimum and a maximum an axis.
    uvec3 near_word = uvec3(s.inverse.x < 0.0 ? 3 : 0, s.inverse.y < 0.0 ? 4 : 1, s.inverse.z < 0.0 ? 5 : 2);
    uvec3 far_word = uvec3(3, 5, 7) - near_word;

    uint stack[STACK];
    uint top = 0;
    uint node = s.valid ? args.root : INVALID;
    while (node != INVALID) {
        while (node < LEAF_BIT) {
            uint at = node * 16;
            vec3 n0 = vec3(P(nodes).at[at + near_word.x], P(nodes).at[at + near_word.y], P(nodes).at[at + near_word.z]);
            vec3 f0 = vec3(P(nodes).at[at + far_word.x], P(nodes).at[at + far_word.y], P(nodes).at[at + far_word.z]);
            vec3 n1 = vec3(P(nodes).at[at + near_word.x + 6], P(nodes).at[at + near_word.y + 6], P(nodes).at[at + near_word.z + 6]);
            vec3 f1 = vec3(P(nodes).at[at + far_word.x + 6], P(nodes).at[at + far_word.y + 6], P(nodes).at[at + far_word.z + 6]);
            n0 = n0 * s.inverse + s.near;
            f0 = f0 * s.inverse + s.far;
            n1 = n1 * s.inverse + s.near;
            f1 = f1 * s.inverse + s.far;
            float enter0 = greatest_of(greatest_of(n0.x, n0.y), greatest_of(n0.z, s.t_min));
            float leave0 = least_of(least_of(f0.x, f0.y), least_of(f0.z, nearest.t));
            float enter1 = greatest_of(greatest_of(n1.x, n1.y), greatest_of(n1.z, s.t_min));
            float leave1 = least_of(least_of(f1.x, f1.y), least_of(f1.z, nearest.t));
            bool hit0 = enter0 <= leave0, hit1 = enter1 <= leave1;
            uint left = floatBitsToUint(P(nodes).at[at + 12]), right = floatBitsToUint(P(nodes).at[at + 13]);
            if (COUNT != 0) tests.boxes += 2;
            if (hit0 && hit1) {
                bool swap = enter1 < enter0;
                stack[top++] = swap ? left : right;
                node = swap ? right : left;
            } else if (hit0 || hit1) {
                node = hit0 ? left : right;
            } else {
                node = top == 0 ? INVALID : stack[--top];
            }
        }
        if (node == INVALID) break;
        uint place = leaf_first(node);
        uint end = place + leaf_count(node);
        if (COUNT != 0 && ANY == 0) tests.triangles += end - place;
        bool done = false;
        for (; place < end && !done; ++place) {
            if (COUNT != 0 && ANY != 0) tests.triangles += 1;
            done = test_triangle(s, place, nearest);
        }
        node = top == 0 || done ? INVALID : stack[--top];
    }
    P(hits).at[ray] = hit_of(s, nearest);
    if (COUNT != 0) P(tests).at[ray] = tests;
}
