// One workgroup WG · ITEMS raw nodes of the queue, a row at a time, each with a packed node of its own: the bits of the
// references to those below it, and those of them that have packed nodes of their own, which are the next round, with
// the first triangle below each.
// Reads cuts, state. The order within a round depends on the timing; what is written to raw and cuts doesn't.
#include "lib/dispatch.glsl"
#include "lib/raw.glsl"
#include "lib/scan.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;
const uint TILE = WG * ITEMS;

shared uint row_place;

// How many of `share` children the first side gets (see RawCut); of 1: of a packed node's.
uint first_of(uint choices, uint share) { return choices >> 2 * (share - 1) & 3; }

// Marks a raw node and sets the bits below it, as far as its packed node reaches. Returns the next round's, count of them.
uvec4 expand(uint node, out uint count) {
    RawCut cut = LOAD_RawCut(cuts, node);
    STORE_RawCut(cuts, node, RawCut(cut.count, cut.choices | KEPT_BIT))
    uvec4 found = uvec4(0);
    count = 0;
    // Children to deal out below node, the first side's, and the first triangle.
    uint share = WIDTH, first = first_of(cut.choices, 1), triangle = P(firsts).at[node];
    uvec4 waiting = uvec4(INVALID);  // a packed node has room for two absorbed ones: one of them can wait
    for (;;) {
        uvec2 children = CHILDREN(node);
        uvec2 shares = uvec2(first, share - first);
        uvec4 next = uvec4(INVALID);
        [[unroll]] for (int side = 0; side < 2; ++side) {
            uint child = children[side];
            if (child >= LEAF_BIT) {
                ++triangle;
                continue;
            }
            RawCut below = LOAD_RawCut(cuts, child);
            uint choices = below.choices;
            uint here = shares[side];
            while (here > 1 && first_of(choices, here) == 0) --here;
            if (here > 1) {
                children[side] |= ABSORBED_BIT;
                if (next.x != INVALID) waiting = next;
                next = uvec4(child, here, first_of(choices, here), triangle);
            } else if (first_of(choices, 1) == 0) {
                children[side] |= COLLAPSED_BIT;
            } else {
                P(firsts).at[child] = triangle;
                found = uvec4(child, found.xyz);
                ++count;
            }
            triangle += below.count;
        }
        P(raw).at[node].p[6] = pair_of(children);
        if (next.x == INVALID) {
            if (waiting.x == INVALID) return found;
            next = waiting;
            waiting.x = INVALID;
        }
        node = next.x;
        share = next.y;
        first = next.z;
        triangle = next.w;
    }
}

// Room for count more in the next round, which starts at first: the place of the first.
uint append(uint first, uint count) {
    // No hand-over: the sum gives each workgroup places of its own, which nobody reads in this round.
    uint before = atomicAdd(P(state).at[args.round + 1].count, count);
    // Each component rises with the number of nodes.
    uvec3 groups = dispatch_over(before + count, TILE);
    atomicMax(P(state).at[args.round + 1].groups.x, groups.x);
    atomicMax(P(state).at[args.round + 1].groups.y, groups.y);
    atomicMax(P(state).at[args.round + 1].groups.z, groups.z);
    return first + before;
}

void main() {
    Expansion now = P(state).at[args.round];
    uint begin = group_index() * TILE;
    if (begin >= now.count) return;
    uint end = min(begin + TILE, now.count);
    // By one alone: two writes of even the same number would be a race.
    if (invocation_index() == 0) P(state).at[args.round + 1].first = now.first + now.count;
    for (uint row = begin; row < end; row += WG) {
        uint i = row + lane();
        uint count = 0;
        uvec4 found = uvec4(0);
        if (i < end) found = expand(P(queue).at[now.first + i], count);
        uint total;
        uint at = row_scan(count, total);
        if (total == 0) continue;
        barrier();  // an earlier row's readers are done
        if (gl_LocalInvocationID.x == 0) row_place = append(now.first + now.count, total);
        barrier();
        at += row_place;
        [[unroll]] for (uint k = 0; k < WIDTH; ++k) {
            if (k < count) P(queue).at[at + k] = found[k];
        }
    }
}
