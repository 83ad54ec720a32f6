// A round of PLOC. Wants lib/pair.glsl and the buffer nearest; with MERGE also lib/scan.glsl, what lib/merge.glsl wants,
// the buffers bounds, clusters, nodes, and AREA(box, key): the half area of the cluster of a common box and a key.

// Whether cluster i, whose least pair is key, is the second of a pair that names each other.
bool dies(uint i, uint key) {
    uint j = partner_of(i, key);
    return j < i && P(nearest).at[j] == key;
}

#ifdef MERGE
#include "lib/merge.glsl"

// What became of a cluster.
struct Moved {
    uint i;        // its place before the round; at least count: there was none
    uint partner;  // the place of the cluster that it merged with, or INVALID
    uint place;    // of clusters that live on, those before it: its place after the round if it does
};

// Clusters row..row + WG, below count, of the half that starts at from, to the half that starts at to; place is that of
// the first and becomes that of the next row's. All invocations must call it.
Moved merge_row(uint row, uint count, uint from, uint to, inout uint place) {
    uint i = row + lane();
    uint key = 0, j = 0;
    bool mutual = false;
    if (i < count) {
        key = P(nearest).at[i];
        j = partner_of(i, key);
        mutual = P(nearest).at[j] == key;
    }
    bool alive = i < count && !(mutual && j < i);
    uint total;
    uint at = place + row_scan(alive, total);
    place += total;
    Moved moved = Moved(i, mutual ? j : INVALID, at);
    if (!alive) return moved;
    Aabb box = LOAD_Aabb(bounds, from + i);
    Cluster cluster = LOAD_Cluster(clusters, from + i);
    if (mutual) {
        Aabb box_a = box;
        Cluster a = cluster, b = LOAD_Cluster(clusters, from + j);
        RawNode node;
        Aabb box_b = LOAD_Aabb(bounds, from + j);
        box = merged(box_a, box_b);
        merge(box_a, a, box_b, b, AREA(box, key), cluster, node);
        STORE_RawNode(nodes, cluster.node, node)
    }
    STORE_Aabb(bounds, to + at, box)
    STORE_Cluster(clusters, to + at, cluster)
    return moved;
}
#endif
