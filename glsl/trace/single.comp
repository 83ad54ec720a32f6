// One invocation a ray: its nearest hit, or with ANY whether there is one. Reads rays, nodes, triangles.
// While-while [AILA09], nearer child first; a popped node is not tested again: keeping its t costs more than it saves.
// The stack holds one entry a level at most, and STACK is no less than the tree is deep.
#include "lib/ray.glsl"
#include "lib/hit.glsl"

layout(constant_id = SPEC_STACK) const uint STACK = 64;

void main() {
    uint ray = ray_index();
    if (ray >= args.count) return;
    Setup s = prepare(LOAD_Ray(rays, ray));
    Nearest nearest = Nearest(s.t_max, INVALID, vec2(0.0));
    Tests tests = Tests(0, 0);

    bvec3 negative = lessThan(s.inverse, vec3(0.0));

    uint stack[STACK];
    uint top = 0;
    uint node = s.valid ? args.root : INVALID;
    while (node != INVALID) {
        while (node < LEAF_BIT) {
            Node n = LOAD_Node(nodes, node);
            vec3 n0 = mix(n.left_bounds.lo, n.left_bounds.hi, negative) * s.inverse + s.near;
            vec3 f0 = mix(n.left_bounds.hi, n.left_bounds.lo, negative) * s.inverse + s.far;
            vec3 n1 = mix(n.right_bounds.lo, n.right_bounds.hi, negative) * s.inverse + s.near;
            vec3 f1 = mix(n.right_bounds.hi, n.right_bounds.lo, negative) * s.inverse + s.far;
            float enter0 = greatest_of(greatest_of(n0.x, n0.y), greatest_of(n0.z, s.t_min));
            float leave0 = least_of(least_of(f0.x, f0.y), least_of(f0.z, nearest.t));
            float enter1 = greatest_of(greatest_of(n1.x, n1.y), greatest_of(n1.z, s.t_min));
            float leave1 = least_of(least_of(f1.x, f1.y), least_of(f1.z, nearest.t));
            bool hit0 = enter0 <= leave0, hit1 = enter1 <= leave1;
            if (COUNT != 0) tests.boxes += 2;
            if (hit0 && hit1) {
                bool swap = enter1 < enter0;
                stack[top++] = swap ? n.left : n.right;
                node = swap ? n.right : n.left;
            } else if (hit0 || hit1) {
                node = hit0 ? n.left : n.right;
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
            PackedTriangle triangle = LOAD_PackedTriangle(triangles, place);
            done = meet_triangle(s, triangle, nearest);
        }
        node = top == 0 || done ? INVALID : stack[--top];
    }
    Hit hit = hit_of(s, nearest);
    STORE_Hit(hits, ray, hit)
    if (COUNT != 0) STORE_Tests(tests, ray, tests)
}
