// One invocation ITEMS rays, a workgroup apart, each as in trace/single. Reads rays, nodes, triangles.
// An invocation that is done with a ray takes its next one while its neighbours go on with theirs, and where fewer
// than half the lanes still descend, those at a leaf don't wait for them [AILA09]: rays that have little in common
// leave fewer lanes idle so; those that have much would lose step.
#include "lib/walk.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

void main() {
    uint next = first_ray(ITEMS);
    uint end = min(next + ITEMS * WG, args.count);
    uint ray = INVALID;
    Setup s;
    Nearest nearest;
    Tests tests;
    uint node;
    for (;;) {
        if (ray == INVALID) {
            if (next >= end) break;
            ray = ray_at(next);
            next += WG;
            s = prepare(LOAD_Ray(rays, ray));
            nearest = none_yet(s);
            tests = Tests(0, 0, 0, 0);
            steps = Steps(0, 0, 0, 0);
            top = 0;
            node = s.valid ? args.root : INVALID;
        }
        while (node < LEAF_BIT) {
            node = descend(node, s, nearest, tests);
            if (2 * subgroupBallotBitCount(subgroupBallot(node < LEAF_BIT)) < gl_SubgroupSize) break;
        }
        if (node >= LEAF_BIT && node != INVALID) node = meet_leaf(node, s, nearest, tests);
        if (node == INVALID) {
            Hit hit = hit_of(s, nearest);
            STORE_Hit(hits, ray, hit)
            if (COUNT != 0) STORE_Tests(tests, ray, tests)
            if (STEPS != 0) STORE_Steps(steps, ray, steps)
            ray = INVALID;
        }
    }
}
