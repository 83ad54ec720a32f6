// One invocation ITEMS packed nodes: from each node without inner children the extremal points of its children's and
// its own triangles climb as far as it is the last child to arrive. Writes points, ranges; hands them over there. Reads
// nodes, triangles, parents, directions. Keeps: nobody waits, no barrier; the same points whatever the timing. Of
// leaves with few triangles all corners are kept, for some may be extremal in no direction. Of slots of more than
// `most` triangles there are ranges alone.
#include "lib/points.glsl"
#include "lib/within.glsl"
#include "lib/reference.glsl"
#include "lib/climb.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;
layout(constant_id = SPEC_DIRECTIONS) const uint DIRECTIONS = 0;

vec3 directions[POINTS / 2];  // where not those of lib/points.glsl

// Of a child and of the node so far: extremal points, and how far along its direction each is.
vec3 below[POINTS];
float below_at[POINTS];
vec3 own[POINTS];
float own_at[POINTS];

#define CLEAR(e)                                                                                                      \
    [[unroll]] for (uint j = 0; j < POINTS / 2; ++j) {                                                                \
        e[2 * j] = e[2 * j + 1] = vec3(0);                                                                            \
        e##_at[2 * j] = 3.4028235e38;                                                                                 \
        e##_at[2 * j + 1] = -3.4028235e38;                                                                            \
    }

#define TAKE_LEAST(e, j, p, here) if (here < e##_at[2 * j]) { e##_at[2 * j] = here; e[2 * j] = p; }
#define TAKE_GREATEST(e, j, p, here) if (here > e##_at[2 * j + 1]) { e##_at[2 * j + 1] = here; e[2 * j + 1] = p; }

// Of axes the coordinate itself: nothing to multiply.
float along_direction(uint j, vec3 p) {
    if (DIRECTIONS != 0) return along(directions[j], p);
    if (j < 3 && POINTS != 12 && POINTS != 20) return p[j];
    return along(direction_of(j), p);
}

void take_in(vec3 p) {
    [[unroll]] for (uint j = 0; j < POINTS / 2; ++j) {
        float here = along_direction(j, p);
        TAKE_LEAST(below, j, p, here)
        TAKE_GREATEST(below, j, p, here)
    }
}

// Of a leaf of few triangles writes all corners, again and again, else the extremal ones.
void take_in_leaf(uint first, uint count, uint slot) {
    CLEAR(below)
    uint corners = 3 * count;
    for (uint i = 0; i < count; ++i) {
        PackedTriangle triangle = LOAD_PackedTriangle(triangles, first + i);
        precise vec3 a = triangle.a - args.anchor, b = triangle.b - args.anchor, c = triangle.c - args.anchor;
        take_in(a);
        take_in(b);
        take_in(c);
        if (corners > POINTS) continue;
        for (uint k = 3 * i; k < POINTS; k += corners) {
            STORE_POINT(slot, k, a)
            if (k + 1 < POINTS) STORE_POINT(slot, k + 1, b)
            if (k + 2 < POINTS) STORE_POINT(slot, k + 2, c)
        }
    }
    if (corners > POINTS) STORE_POINTS(below, slot)
}

void climb(uint node) {
    uvec4 children = LOAD_Node(nodes, node).children;
    if (inner_children(children) > 0) return;
    for (;;) {
        CLEAR(own)
        Range range = Range(0, 0);
        for (uint k = 0; k < WIDTH && children[k] != INVALID; ++k) {
            uint slot = 4 * node + k;
            Range child;
            if (children[k] < LEAF_BIT) {
                child = LOAD_Range(ranges, slot);
                if (child.count <= args.most) {
                    LOAD_POINTS(below, slot)
                    [[unroll]] for (uint i = 0; i < POINTS; ++i) below_at[i] = along_direction(i / 2, below[i]);
                }
            } else {
                child = leaf_range(children[k]);
                take_in_leaf(child.first, child.count, slot);
                STORE_Range(ranges, slot, child)
            }
            [[unroll]] for (uint j = 0; j < POINTS / 2; ++j) {
                TAKE_LEAST(own, j, below[2 * j], below_at[2 * j])
                TAKE_GREATEST(own, j, below[2 * j + 1], below_at[2 * j + 1])
            }
            range = Range(k == 0 ? child.first : min(range.first, child.first), range.count + child.count);
        }
        uint up = P(parents).at[node];
        if (range.count <= args.most) STORE_POINTS(own, up)
        STORE_Range(ranges, up, range)
        node = up / 4;
        if (node == args.count) return;  // that was the root
        children = LOAD_Node(nodes, node).children;
        // Hand-over: each inner child's invocation leaves points and range in the child's slot; the last has read a count
        // that all others' went into, so that theirs are visible to it. They store and load nothing here any more.
        if (arrive(node) + 1 < inner_children(children)) return;
    }
}

void main() {
    if (DIRECTIONS != 0) {
        [[unroll]] for (uint j = 0; j < POINTS / 2; ++j) {
            directions[j] = vec3(P(directions).at[3 * j], P(directions).at[3 * j + 1], P(directions).at[3 * j + 2]);
        }
    }
    FOR_ITEMS(i, args.count) climb(i);
}
