// A round of PLOC. Wants lib/pair.glsl and the buffer nearest; with MERGE also lib/scan.glsl, what lib/merge.glsl wants,
// and the buffers bounds, clusters, nodes.

// Whether cluster i, whose least pair is key, is the second of a pair that names each other.
bool dies(uint i, uint key) {
    uint j = partner_of(i, key);
    return j < i && P(nearest).at[j] == key;
}

#ifdef MERGE
#include "lib/merge.glsl"

// Clusters row..row + WG, below count, of the half that starts at from, to the half that starts at to; place is that of
// the first and becomes that of the next row's. All invocations must call it.
void merge_row(uint row, uint count, uint from, uint to, inout uint place) {
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
    if (!alive) return;
    Aabb box = LOAD_Aabb(bounds, from + i);
    Cluster cluster = LOAD_Cluster(clusters, from + i);
    if (mutual) {
        Aabb box_a = box;
        Cluster a = cluster, b = LOAD_Cluster(clusters, from + j);
        RawNode node;
        merge(box_a, a, LOAD_Aabb(bounds, from + j), b, box, cluster, node);
        STORE_RawNode(nodes, cluster.node, node)
    }
    STORE_Aabb(bounds, to + at, box)
    STORE_Cluster(clusters, to + at, cluster)
}
#endif
