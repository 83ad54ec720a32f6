// One invocation ITEMS raw nodes: each is cut so that it becomes a packed node of its own, and no leaf.
layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

void main() {
    FOR_ITEMS(i, args.count) {
        RawCut cut = LOAD_RawCut(cuts, i);
        // Two of four children to the first side; of fewer none: the node has a place in no other.
        STORE_RawCut(cuts, i, RawCut(cut.count, 2))
    }
}
