// The least key of cluster i's pairs, every box loaded anew. Wants lib/pair.glsl and box_of(i), the box of cluster i.
uint least_key(uint i, uint count) {
    Aabb own = box_of(i);
    uint key = INVALID;
    for (uint d = 1; d <= RADIUS; ++d) {
        if (i + d < count) key = min(key, pair_key(own, box_of(i + d), i, d));
        if (i >= d) key = min(key, pair_key(box_of(i - d), own, i - d, d));
    }
    return key;
}
