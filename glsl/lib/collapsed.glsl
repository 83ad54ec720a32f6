// Which raw nodes the packed tree keeps. A node goes where it, or a node above it, is collapsed into a leaf.
bool is_collapsed(uint node) { return (P(nodes).at[node].count & COLLAPSED_BIT) != 0; }

bool is_kept(uint node) {
    // Only nodes of at most max_leaf triangles can be collapsed, so the way up ends early.
    uint count = P(nodes).at[node].count;
    while (count <= args.max_leaf) {
        node = P(nodes).at[node].parent;
        if (node == INVALID) return true;
        count = P(nodes).at[node].count;  // larger than any leaf where COLLAPSED_BIT is set
    }
    return (count & COLLAPSED_BIT) == 0;
}
