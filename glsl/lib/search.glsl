// The least key of cluster i's pairs, all boxes loaded from the half that starts at from. Wants lib/pair.glsl.
uint least_key(uint i, uint count, uint from) {
    Aabb own = LOAD_Aabb(bounds, from + i);
    uint key = INVALID;
    for (uint d = 1; d <= RADIUS; ++d) {
        if (i + d < count) key = min(key, pair_key(own, LOAD_Aabb(bounds, from + i + d), i, d));
        if (i >= d) key = min(key, pair_key(LOAD_Aabb(bounds, from + i - d), own, i - d, d));
    }
    return key;
}
