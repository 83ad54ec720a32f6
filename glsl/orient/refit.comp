// One workgroup WG · ITEMS consecutive triangles: walks down to all nodes above them and grows the extents of the children
// that hold them, in the frames of nodes that have one. Reads nodes, triangles, ranges, chosen.
// Keeps: extents only grow, so the order of workgroups doesn't matter; control flow is the same in a workgroup.
#include "lib/box.glsl"
#include "lib/within.glsl"
#include "lib/ordered.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;
layout(constant_id = SPEC_STACK) const uint STACK = 64;

PackedTriangle mine[ITEMS];

void grow(uint slot, Frame f, uint first, uint end, uint begin) {
    Aabb box = NOWHERE;
    [[unroll]] for (uint t = 0; t < ITEMS; ++t) {
        uint place = begin + t * WG + gl_LocalInvocationID.x;
        if (place >= first && place < end) {
            take_in(box, within(f, mine[t].a));
            take_in(box, within(f, mine[t].b));
            take_in(box, within(f, mine[t].c));
        }
    }
    // One atomic a subgroup and side.
    vec3 lo = subgroupMin(box.lo), hi = subgroupMax(box.hi);
    if (subgroupElect() && lo.x <= hi.x) {
        for (int k = 0; k < 3; ++k) {
            atomicMin(P(extents).at[slot].lo[k], ordered(lo[k]));
            atomicMax(P(extents).at[slot].hi[k], ordered(hi[k]));
        }
    }
}

void main() {
    uint begin = group_index() * WG * ITEMS;
    uint end = min(begin + WG * ITEMS, args.count);
    if (begin >= end) return;
    [[unroll]] for (uint t = 0; t < ITEMS; ++t) {
        mine[t] = LOAD_PackedTriangle(triangles, min(begin + t * WG + gl_LocalInvocationID.x, end - 1));
        precise vec3 a = mine[t].a - args.anchor, b = mine[t].b - args.anchor, c = mine[t].c - args.anchor;
        mine[t] = PackedTriangle(a, b, c, 0);
    }
    uint stack[STACK];
    uint top = 0;
    uint node = args.root;
    while (node != INVALID) {
        uvec4 children = LOAD_Node(nodes, node).children;
        uvec2 words = words_of(P(chosen).at[node]);
        Frame f = frame_of(rodrigues_of(words));
        uint slots = 4 * node;
        node = INVALID;
        for (uint k = 0; k < WIDTH && children[k] != INVALID; ++k) {
            Range range = LOAD_Range(ranges, slots + k);
            if (range.first >= end || range.first + range.count <= begin) continue;
            if (is_oriented(words)) grow(slots + k, f, range.first, range.first + range.count, begin);
            if (children[k] < LEAF_BIT) {
                if (node != INVALID) stack[top++] = node;
                node = children[k];
            }
        }
        if (node == INVALID && top > 0) node = stack[--top];
    }
}
