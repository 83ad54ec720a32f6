// One invocation ITEMS consecutive clusters: nearest[i] is the least key of the pairs of cluster i with those within
// RADIUS of it. Reads bounds, state. Keeps: at least one pair of clusters names each other (see lib/pair.glsl).
// The window of the last RADIUS clusters stays in registers and each pair is computed once: RADIUS at most 32.
#include "lib/pair.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

void main() {
    uint count = P(state).at[args.round].clusters;
    uint from = (P(state).at[args.round].rounds & 1u) * args.capacity;
    uint begin = invocation_index() * ITEMS;
    if (begin >= count) return;
    uint end = min(begin + ITEMS, count);

    // window[k] and least[k] belong to cluster j − 1 − k.
    Aabb window[RADIUS];
    uint least[RADIUS];
    [[unroll]] for (uint k = 0; k < RADIUS; ++k) {
        window[k] = FAR;
        if (begin > k) window[k] = LOAD_Aabb(bounds, from + begin - 1 - k);
        least[k] = INVALID;
    }
    for (uint j = begin; j < end + RADIUS; ++j) {
        Aabb box = FAR;
        if (j < count) box = LOAD_Aabb(bounds, from + j);
        uint mine = INVALID;
        [[unroll]] for (uint k = 0; k < RADIUS; ++k) {
            uint key = pair_key(window[k], box, j - 1 - k, k + 1);
            mine = min(mine, key);
            least[k] = min(least[k], key);
        }
        // Cluster j − RADIUS has met all its neighbours.
        if (j >= begin + RADIUS) P(nearest).at[j - RADIUS] = least[RADIUS - 1];
        // Rising, for a falling loop would not be unrolled by lavapipe, and the window would leave the registers.
        [[unroll]] for (uint k = 1; k < RADIUS; ++k) {
            window[RADIUS - k] = window[RADIUS - k - 1];
            least[RADIUS - k] = least[RADIUS - k - 1];
        }
        window[0] = box;
        least[0] = mine;
    }
}
