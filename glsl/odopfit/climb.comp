// One invocation ITEMS packed nodes: from each node without inner children the boxes of its triangles in BASES bases climb
// as far as it is the last child to arrive. A node whose children's boxes cost less in one of them than in any so far takes
// its frame, the first of equal ones, and their extents. Writes boxes, and hands them over there; least, chosen, extents.
// Reads nodes, triangles, parents, bases. Keeps: nobody waits, no barrier; the same frames however bases are grouped.
#include "lib/box.glsl"
#include "lib/within.glsl"
#include "lib/ordered.glsl"
#include "lib/cost.glsl"
#include "lib/reference.glsl"
#include "lib/climb.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;
layout(constant_id = SPEC_BASES) const uint BASES = 2;

vec3 rodrigues[BASES];
Frame frames[BASES];
// Of the node at hand.
Aabb below[WIDTH][BASES];
Aabb own[BASES];
float costs[BASES];

void take_in_leaf(uint k, Range range) {
    [[unroll]] for (uint b = 0; b < BASES; ++b) below[k][b] = NOWHERE;
    for (uint place = range.first; place < range.first + range.count; ++place) {
        PackedTriangle triangle = LOAD_PackedTriangle(triangles, place);
        precise vec3 x = triangle.a - args.anchor, y = triangle.b - args.anchor, z = triangle.c - args.anchor;
        [[unroll]] for (uint b = 0; b < BASES; ++b) {
            take_in(below[k][b], within(frames[b], x));
            take_in(below[k][b], within(frames[b], y));
            take_in(below[k][b], within(frames[b], z));
        }
    }
}

// The boxes of the node's children, its own, and what it is expected to cost.
void gather(uvec4 children) {
    [[unroll]] for (uint b = 0; b < BASES; ++b) {
        own[b] = NOWHERE;
        costs[b] = 0.0;
    }
    [[unroll]] for (uint k = 0; k < WIDTH; ++k) {
        uint child = children[k];
        if (child != INVALID) {
            Range range = leaf_range(child);
            if (child < LEAF_BIT) {
                [[unroll]] for (uint b = 0; b < BASES; ++b) below[k][b] = LOAD_Aabb(boxes, BASES * child + b);
            } else {
                take_in_leaf(k, range);
            }
            float visit = cost_of_visit(child, range.count);
            [[unroll]] for (uint b = 0; b < BASES; ++b) {
                own[b] = merged(own[b], below[k][b]);
                precise float sum = costs[b] + visit * half_area(below[k][b]);
                costs[b] = sum;
            }
        }
    }
}

void choose(uint node, uvec4 children) {
    float least = P(least).at[node];
    if (args.first == 0) {
        precise float dearer = (args.oriented_cost - args.node_cost) * half_area(own[0]);
        precise float along_axes = costs[0] - dearer;
        least = along_axes;
        P(least).at[node] = least;
        P(chosen).at[node] = pair_of(uvec2(0));
    }
    uint best = BASES;
    [[unroll]] for (uint b = 0; b < BASES; ++b) {
        float cost = unstretched(costs[b], rodrigues[b]);
        if (rodrigues[b] != vec3(0.0) && cost < least) {
            least = cost;
            best = b;
        }
    }
    if (best == BASES) return;
    P(least).at[node] = least;
    P(chosen).at[node] = P(bases).at[args.first + best];
    [[unroll]] for (uint k = 0; k < WIDTH; ++k) {
        Aabb box = below[k][0];
        [[unroll]] for (uint b = 1; b < BASES; ++b) {
            if (b == best) box = below[k][b];
        }
        if (children[k] != INVALID) {
            P(extents).at[4 * node + k] = OrderedBounds(uvec3(ordered(box.lo.x), ordered(box.lo.y), ordered(box.lo.z)),
                                                        uvec3(ordered(box.hi.x), ordered(box.hi.y), ordered(box.hi.z)));
        }
    }
}

void climb(uint node) {
    uvec4 children = LOAD_Node(nodes, node).children;
    if (inner_children(children) > 0) return;
    for (;;) {
        gather(children);
        choose(node, children);
        uint above = P(parents).at[node] / 4;
        if (above == args.count) return;  // that was the root
        [[unroll]] for (uint b = 0; b < BASES; ++b) STORE_Aabb(boxes, BASES * node + b, own[b])
        node = above;
        children = LOAD_Node(nodes, node).children;
        if (!arrive_last(node, children)) return;
    }
}

void main() {
    [[unroll]] for (uint b = 0; b < BASES; ++b) {
        rodrigues[b] = rodrigues_of(words_of(P(bases).at[args.first + b]));
        frames[b] = frame_of(rodrigues[b]);
    }
    FOR_ITEMS(i, args.count) climb(i);
}
