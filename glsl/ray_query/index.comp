// One invocation a triangle of the list: the numbers of its three corners. Reads triangles.
void main() {
    uint i = invocation_index();
    if (i >= args.count) return;
    uint t = P(triangles).at[i];
    P(indices).at[3u * i] = 3u * t;
    P(indices).at[3u * i + 1u] = 3u * t + 1u;
    P(indices).at[3u * i + 2u] = 3u * t + 2u;
}
