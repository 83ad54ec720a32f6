// Which raw nodes the packed tree keeps: those that are not collapsed, nor below one that is.

// Count, with COLLAPSED_BIT, and parent of a raw node: its last pair.
#define COUNT_PARENT(b, node) words_of(P(b).at[8u * (node) + 7u])
// Its children.
#define CHILDREN(b, node) words_of(P(b).at[8u * (node) + 6u])

bool is_kept(uint node) {
    // Only nodes of at most max_leaf triangles can be collapsed, so the way up ends early.
    uvec2 here = COUNT_PARENT(nodes, node);
    while (here.x <= args.max_leaf) {  // larger where COLLAPSED_BIT is set
        if (here.y == INVALID) return true;
        here = COUNT_PARENT(nodes, here.y);
    }
    return (here.x & COLLAPSED_BIT) == 0;
}
