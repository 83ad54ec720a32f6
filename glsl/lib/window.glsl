// The least keys of the pairs of consecutive clusters. The window of the last RADIUS clusters stays in registers and each
// pair is computed once: RADIUS at most 32. Wants lib/pair.glsl, box_of(i), the box of cluster i, and found(i, key),
// which takes its least key.
void search_window(uint begin, uint end, uint count) {
    // window[k] and least[k] belong to cluster j − 1 − k.
    Aabb window[RADIUS];
    uint least[RADIUS];
    [[unroll]] for (uint k = 0; k < RADIUS; ++k) {
        window[k] = FAR;
        if (begin > k) window[k] = box_of(begin - 1 - k);
        least[k] = INVALID;
    }
    for (uint j = begin; j < end + RADIUS; ++j) {
        Aabb box = FAR;
        if (j < count) box = box_of(j);
        uint mine = INVALID;
        [[unroll]] for (uint k = 0; k < RADIUS; ++k) {
            uint key = pair_key(window[k], box, j - 1 - k, k + 1);
            mine = min(mine, key);
            least[k] = min(least[k], key);
        }
        // Cluster j − RADIUS has met all its neighbours.
        if (j >= begin + RADIUS) found(j - RADIUS, least[RADIUS - 1]);
        // Rising, for a falling loop would not be unrolled by lavapipe, and the window would leave the registers.
        [[unroll]] for (uint k = 1; k < RADIUS; ++k) {
            window[RADIUS - k] = window[RADIUS - k - 1];
            least[RADIUS - k] = least[RADIUS - k - 1];
        }
        window[0] = box;
        least[0] = mine;
    }
}
