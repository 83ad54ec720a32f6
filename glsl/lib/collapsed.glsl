// Which raw nodes the packed tree keeps: those that are neither absorbed by the node above, nor collapsed, nor below
// one that is collapsed. Wants links and args.max_leaf.
bool is_kept(uint node) {
    RawLink here = LOAD_RawLink(links, node);
    if ((here.count & ABSORBED_BIT) != 0) return false;
    // Only nodes of at most max_leaf triangles can be collapsed, so the way up ends early.
    while ((here.count & ~ABSORBED_BIT) <= args.max_leaf) {  // larger where COLLAPSED_BIT is set
        if (here.parent == INVALID) return true;
        here = LOAD_RawLink(links, here.parent);
    }
    return (here.count & COLLAPSED_BIT) == 0;
}
