// One invocation ITEMS Morton ranks: each leaf climbs the radix tree over the codes as far as it is the second to arrive,
// and merges what it and the first one bring. Writes nodes, cuts, root; hands boxes and clusters over through nodes and
// climbers. Reads triangles, order, keys, low_keys. Keeps: nobody waits, no barrier; node p splits between ranks p and
// p + 1, so the tree is the same whatever the timing.
#include "lib/box.glsl"
#include "lib/climb.glsl"
#include "lib/leaf.glsl"
#include "lib/merge.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

// How far the codes of ranks i and i + 1 are apart: the higher their first bit that differs, the greater. Equal codes
// go on with the rank's own bits, so that even a thousand of them make a tree of ten levels.
uvec3 apart(uint i) {
    uint low = args.wide != 0 ? P(low_keys).at[i] ^ P(low_keys).at[i + 1] : 0u;
    return uvec3(P(keys).at[i] ^ P(keys).at[i + 1], low, i ^ (i + 1));
}

bool nearer(uvec3 a, uvec3 b) {
    return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
}

// Whether the node above ranks first..last has them on its right: it splits before the first or behind the last, where
// the codes are less apart [APETREI14].
bool is_right(uint first, uint last) {
    return last == args.count - 1 || first > 0 && nearer(apart(first - 1), apart(last));
}

void store_child_box(uint node, uint side, Aabb box) {
    P(nodes).at[node].p[3 * side] = Aabb_pair0(box);
    P(nodes).at[node].p[3 * side + 1] = Aabb_pair1(box);
    P(nodes).at[node].p[3 * side + 2] = Aabb_pair2(box);
}

Aabb load_child_box(uint node, uint side) {
    return Aabb_of(P(nodes).at[node].p[3 * side], P(nodes).at[node].p[3 * side + 1], P(nodes).at[node].p[3 * side + 2]);
}

void climb(uint rank) {
    Aabb box = leaf_box(P(order).at[rank]);
    Cluster cluster = leaf_cluster(rank, box);
    uint levels = 0;
    while (cluster.count < args.count) {
        uint first = cluster.rank, last = first + cluster.count - 1;
        uint side = uint(is_right(first, last));
        uint node = side != 0 ? first - 1 : last;
        store_child_box(node, side, box);
        STORE_Climber(climbers, 2 * node + side, Climber(cluster.node, cluster.count, cluster.cost, levels))
        // Hand-over: the first to arrive leaves its side's box and climber; the second has read its 1, so that both are
        // visible to it. The first stores and loads nothing here any more.
        if (arrive(node) == 0) return;
        Climber other = LOAD_Climber(climbers, 2 * node + 1 - side);
        Aabb other_box = load_child_box(node, 1 - side);
        uint other_first = side != 0 ? first - other.count : last + 1;
        Cluster from = Cluster(other.node, other_first, other.count, other.cost);
        levels = max(levels, other.levels) + 1;
        RawNode merged_node;
        Aabb merged_box = merged(box, other_box);
        float area = half_area(merged_box);
        Cluster merged_cluster;
        if (side != 0) {
            merge(other_box, from, box, cluster, area, merged_cluster, merged_node);
        } else {
            merge(box, cluster, other_box, from, area, merged_cluster, merged_node);
        }
        // Both boxes are there already.
        P(nodes).at[node].p[6] = RawNode_pair6(merged_node);
        box = merged_box;
        cluster = merged_cluster;
    }
    P(root).at[0] = RawRoot(root_reference(cluster), levels, 0, cluster.cost.x, box);
}

void main() {
    FOR_ITEMS(i, args.count) climb(i);
}
