// One workgroup: the rounds that remain once few clusters do, and the root. Reads and writes everything; what invocations
// hand to each other lies in shared buffers.
#define MERGE
#define AREA(box, key) half_area(box)
#include "lib/handover.glsl"
#include "lib/pair.glsl"
#include "lib/scan.glsl"
#include "lib/round.glsl"

uint from;
Aabb box_of(uint i) { return LOAD_Aabb(bounds, from + i); }

#include "lib/search.glsl"

void main() {
    uint me = gl_LocalInvocationID.x;
    uint count = P(state).at[args.round].clusters;
    if (count > TAIL_CLUSTERS) return;  // more rounds must come first
    uint rounds = P(state).at[args.round].rounds;
    uint stalled = 0;
    while (count > 1 && stalled == 0) {
        from = (rounds & 1u) * args.capacity;
        uint to = args.capacity - from;
        for (uint i = me; i < count; i += WG) P(nearest).at[i] = least_key(i, count);
        // Hand-over of nearest: a cluster asks its partner's. All come here, for count and stalled are the same in all.
        hand_over_in_workgroup();
        uint total = 0;
        for (uint row = 0; row < count; row += WG) merge_row(row, count, from, to, total);
        // Hand-over of bounds, clusters and cuts to the next round or the root's invocation; nearest may be overwritten.
        hand_over_in_workgroup();
        stalled = uint(total >= count);  // the same in every invocation: total is
        count = total;
        ++rounds;
    }
    if (me == 0) {
        uint last = (rounds & 1u) * args.capacity;
        Cluster cluster = LOAD_Cluster(clusters, last);
        uint node = stalled != 0 ? cluster.node : root_reference(cluster);
        P(root).at[0] = RawRoot(node, rounds, stalled, cluster.cost.x, LOAD_Aabb(bounds, last));
    }
}
