// Dealing out the pairs that merged in args.round: workgroups are as many as the round's clusters want, and of these half
// at most were merged away. Wants state, ITEMS.

// This invocation's first, and the end of its workgroup's.
uvec2 share_of_pairs() {
    uint clusters = P(state).at[args.round].clusters;
    uint count = clusters - P(state).at[args.round + 1].clusters;
    uint groups = (clusters + WG * ITEMS - 1) / (WG * ITEMS);
    uint share = (count + groups - 1) / groups;
    uint begin = min(group_index() * share, count);
    return uvec2(begin + gl_LocalInvocationID.x, min(begin + share, count));
}
