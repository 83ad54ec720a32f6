// One invocation an entry: gathered[i] = source[order[i]].
void main() {
    uint i = invocation_index();
    if (i < args.count) P(gathered).at[i] = P(source).at[P(order).at[i]];
}
