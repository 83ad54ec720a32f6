// Persistent threads, speculative while-while [AILA09]: as many invocations as the device runs at once walk until no
// ray is left, each result as in trace/single. Reads rays, nodes, triangles; counts in next, zero before, the rays
// that are taken.
// A subgroup whose live rays have become few takes rays for all its idle lanes by one atomic. An invocation at a leaf
// puts it off and descends on, until every lane has a leaf to meet or is done. Waits for no other subgroup, and no
// lane leaves a loop in which its subgroup votes before the others do.
// Differs: rays are taken one a lane, as the authors' later kernels do, not from a batch that a warp keeps.
#include "lib/walk.glsl"

layout(constant_id = SPEC_FEW) const uint FEW = 0;

bool is_leaf(uint node) { return node >= LEAF_BIT && node != INVALID; }

void main() {
    uint lanes = subgroupBallotBitCount(subgroupBallot(true));
    bool left = true;  // whether there may be rays that nobody has taken
    uint ray = INVALID;
    uint node = INVALID;  // where to go on
    uint leaf = INVALID;  // put off
    Setup s;
    Nearest nearest;
    Tests tests;
    while (left || subgroupAny(ray != INVALID)) {
        if (left) {
            uvec4 idle = subgroupBallot(ray == INVALID);
            uint wanted = subgroupBallotBitCount(idle), first = 0;
            // No hand-over: the sum gives each subgroup rays of its own.
            if (subgroupElect()) first = atomicAdd(P(next).at[0], wanted);
            first = subgroupBroadcastFirst(first);
            left = first + wanted < args.count;
            uint mine = first + subgroupBallotExclusiveBitCount(idle);
            if (ray == INVALID && mine < args.count) {
                ray = ray_at(mine);
                s = prepare(LOAD_Ray(rays, ray));
                nearest = none_yet(s);
                tests = Tests(0, 0, 0, 0);
                steps = Steps(0, 0, 0, 0);
                top = 0;
                node = s.valid ? args.root : INVALID;
            }
        }
        uint enough = left ? max(1, lanes * FEW / 8) : 1, live;
        do {
            do {
                if (node < LEAF_BIT) node = descend(node, s, nearest, tests);
                if (leaf == INVALID && is_leaf(node)) {
                    leaf = node;
                    node = pop_within(nearest.limit);
                }
            } while (subgroupAny(leaf == INVALID && node < LEAF_BIT));
            if (leaf != INVALID) {
                if (meet_triangles(leaf, s, nearest, tests)) node = INVALID;
                leaf = INVALID;
            }
            live = subgroupBallotBitCount(subgroupBallot(node != INVALID));
        } while (live >= enough);
        if (ray != INVALID && node == INVALID) {
            Hit hit = hit_of(s, nearest);
            STORE_Hit(hits, ray, hit)
            if (COUNT != 0) STORE_Tests(tests, ray, tests)
            if (STEPS != 0) STORE_Steps(steps, ray, steps)
            ray = INVALID;
        }
    }
}
