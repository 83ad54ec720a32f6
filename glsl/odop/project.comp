// One invocation ITEMS clusters: their boxes in args.count bases, from the corners of all their triangles, and their
// slots. Before the first round it also finds the cost of each triangle, by the least of its areas in any basis.
// Reads triangles, order, next, bases, slabs, state. Keeps: the same bits as uniting the boxes of a cluster's parts.
#include "lib/box.glsl"
#include "lib/leaf.glsl"
#include "lib/within.glsl"
#include "lib/slab.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

// Bases at once: enough to make up for loading the corners.
const uint BLOCK = 4;

vec3 unit_of(vec3 corner) {
    precise vec3 p = corner * args.scale - args.anchor;
    return settled(p);
}

void main() {
    uint count = P(state).at[args.round].clusters, rounds = P(state).at[args.round].rounds;
    uint from = (rounds & 1u) * args.capacity;
    for (uint block = 0; block < args.count; block += BLOCK) {
        Frame frames[BLOCK];
        Slab slabs[BLOCK];
        [[unroll]] for (uint k = 0; k < BLOCK; ++k) {
            // The last ones may come twice.
            uint b = min(block + k, args.count - 1);
            Basis basis = P(bases).at[args.first + b];
            frames[k] = Frame(basis.x, basis.y, basis.z);
            slabs[k] = slab_of(args.slab + b);
        }
        bool first = args.first + block == 0;
        FOR_ITEMS(i, count) {
            Aabb boxes[BLOCK];
            [[unroll]] for (uint k = 0; k < BLOCK; ++k) boxes[k] = NOWHERE;
            uint rank = words_of(P(clusters).at[from + i].p[0]).y;
            do {
                Corners t = LOAD_CORNERS(triangles, P(order).at[rank]);
                vec3 a = unit_of(t.a), b = unit_of(t.b), c = unit_of(t.c);
                [[unroll]] for (uint k = 0; k < BLOCK; ++k) {
                    take_in(boxes[k], within(frames[k], a));
                    take_in(boxes[k], within(frames[k], b));
                    take_in(boxes[k], within(frames[k], c));
                }
                rank = rounds > 0 ? P(next).at[rank] : INVALID;
            } while (rank != INVALID);
            float least = 3.4028235e38;
            [[unroll]] for (uint k = 0; k < BLOCK; ++k) {
                Aabb box = Aabb(settled(boxes[k].lo), settled(boxes[k].hi));
                STORE_BOX(slabs[k], i, box)
                least = least_of(half_area(box), least);
            }
            if (first) P(slots).at[from + i] = i;
            if (rounds == 0) {
                Cluster cluster = LOAD_Cluster(clusters, from + i);
                precise float cost = args.triangle_cost * least;
                if (!first) cost = least_of(cost, cluster.cost.x);
                cluster.cost = vec3(cost);
                STORE_Cluster(clusters, from + i, cluster)
            }
        }
    }
}
