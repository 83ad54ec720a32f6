// One workgroup WG · ITEMS raw nodes, a row at a time: those kept are numbered in their order, which is about that of the
// tree read left to right. Reads sums, cuts.
#include "lib/scan.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

void main() {
    uint begin = group_index() * WG * ITEMS;
    if (begin >= args.count) return;
    uint end = min(begin + WG * ITEMS, args.count);
    uint node = P(sums).at[group_index()];
    for (uint row = begin; row < end; row += WG) {
        uint i = row + lane();
        bool kept = i < end && (LOAD_RawCut(cuts, i).choices & KEPT_BIT) != 0;
        uint all_kept;
        uint to = node + row_scan(kept, all_kept);
        if (kept) {
            P(packed).at[i] = to;
            P(kept).at[to] = i;
        }
        node += all_kept;
    }
}
