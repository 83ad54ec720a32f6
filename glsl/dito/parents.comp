// One invocation ITEMS packed nodes: the slot above each node among its children. Reads nodes.
layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

void main() {
    FOR_ITEMS(i, args.count) {
        uvec4 children = LOAD_Node(nodes, i).children;
        for (int k = 0; k < WIDTH; ++k) {
            if (children[k] < LEAF_BIT) P(parents).at[children[k]] = 4 * i + k;
        }
        if (i == args.root) P(parents).at[i] = 4 * args.count;
    }
}
