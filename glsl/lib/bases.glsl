// Searching one basis after the other. Wants lib/slab.glsl, slots, state, nearest, args.{capacity, first, slab}.
Slab slab;
uint from;
bool fresh;

// The k-th basis of the dispatch is the one to search.
void take_basis(uint k) {
    slab = slab_of(args.slab + k);
    from = (P(state).at[args.round].rounds & 1u) * args.capacity;
    fresh = args.first + k == 0;
}

Aabb box_of(uint i) {
    uint slot = P(slots).at[from + i];
    return LOAD_BOX(slab, slot);
}

void found(uint i, uint key) { P(nearest).at[i] = fresh ? key : min(key, P(nearest).at[i]); }
