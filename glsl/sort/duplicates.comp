// One invocation ITEMS sorted keys: duplicates gains those that equal the key before them. Reads keys.
layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

void main() {
    uint begin = invocation_index() * ITEMS;
    uint end = min(begin + ITEMS, args.count);
    uint sum = 0;
    for (uint i = max(begin, 1u); i < end; ++i) sum += uint(P(keys).at[i] == P(keys).at[i - 1]);
    sum = subgroupAdd(sum);
    if (subgroupElect() && sum > 0) atomicAdd(P(duplicates).at[0], sum);
}
