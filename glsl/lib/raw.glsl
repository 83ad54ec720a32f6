// Parts of raw nodes. Wants raw.

// The children of a raw node: its last pair.
#define CHILDREN(node) words_of(P(raw).at[node].p[6])
// The box of its first (0) or second (1) child.
#define CHILD_BOX(node, side)                                                                                         \
    Aabb_of(P(raw).at[node].p[3 * (side)], P(raw).at[node].p[3 * (side) + 1], P(raw).at[node].p[3 * (side) + 2])

bool is_leaf(uint child) { return (child & (LEAF_BIT | COLLAPSED_BIT)) != 0; }
bool is_absorbed(uint child) { return (child & (LEAF_BIT | COLLAPSED_BIT | ABSORBED_BIT)) == ABSORBED_BIT; }
