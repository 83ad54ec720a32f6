// The least key of cluster i's pairs, all boxes loaded from the half that starts at from. Wants lib/pair.glsl.
uint least_key(uint i, uint count, uint from) {
    Aabb own = P(bounds).at[from + i];
    uint key = INVALID;
    for (uint d = 1; d <= RADIUS; ++d) {
        if (i + d < count) key = min(key, pair_key(own, P(bounds).at[from + i + d], i, d));
        if (i >= d) key = min(key, pair_key(P(bounds).at[from + i - d], own, i - d, d));
    }
    return key;
}
