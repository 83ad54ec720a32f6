// One invocation ITEMS packed nodes: from each node without inner children the boxes of its triangles in BASES bases
// climb as far as it is the last child to arrive. A node whose children's boxes cost less in one of them than in any so
// far takes its frame, the first of equal ones, and their extents. Of nodes of `above` triangles or fewer none is
// chosen. Writes boxes and counts, and hands them over there; least, chosen, extents. Reads nodes, triangles, parents,
// bases. Keeps: nobody waits, no barrier; the same frames however bases are grouped.
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
Aabb own[BASES];
float costs[BASES];

void take_in(inout Aabb box, Frame frame, PackedTriangle triangle) {
    precise vec3 x = triangle.a - args.anchor, y = triangle.b - args.anchor, z = triangle.c - args.anchor;
    take_in(box, within(frame, x));
    take_in(box, within(frame, y));
    take_in(box, within(frame, z));
}

// The node's box, and what it is expected to cost; returns its triangles, where these matter.
uint gather(uvec4 children) {
    uint count = 0;
    [[unroll]] for (uint b = 0; b < BASES; ++b) {
        own[b] = NOWHERE;
        costs[b] = 0.0;
    }
    for (uint k = 0; k < WIDTH && children[k] != INVALID; ++k) {
        uint child = children[k];
        Range range = leaf_range(child);
        Aabb below[BASES];
        if (child < LEAF_BIT) {
            [[unroll]] for (uint b = 0; b < BASES; ++b) below[b] = LOAD_Aabb(boxes, BASES * child + b);
            if (args.above > 0) count += P(counts).at[child];
        } else {
            count += range.count;
            [[unroll]] for (uint b = 0; b < BASES; ++b) below[b] = NOWHERE;
            for (uint place = range.first; place < range.first + range.count; ++place) {
                PackedTriangle triangle = LOAD_PackedTriangle(triangles, place);
                [[unroll]] for (uint b = 0; b < BASES; ++b) take_in(below[b], frames[b], triangle);
            }
        }
        float visit = cost_of_visit(child, range.count);
        [[unroll]] for (uint b = 0; b < BASES; ++b) {
            own[b] = merged(own[b], below[b]);
            precise float sum = costs[b] + visit * half_area(below[b]);
            costs[b] = sum;
        }
    }
    return count;
}

// Once more the children's boxes, in the frame that is kept. Tried holding them all: 4 to 8 times as long on lavapipe, for
// want of registers.
void keep(uint node, uvec4 children, uint best) {
    PAIR words = P(bases).at[args.first + best];
    P(chosen).at[node] = words;
    Frame frame = frame_of(rodrigues_of(words_of(words)));
    for (uint k = 0; k < WIDTH && children[k] != INVALID; ++k) {
        Aabb box = NOWHERE;
        if (children[k] < LEAF_BIT) {
            box = LOAD_Aabb(boxes, BASES * children[k] + best);
        } else {
            Range range = leaf_range(children[k]);
            for (uint place = range.first; place < range.first + range.count; ++place) {
                take_in(box, frame, LOAD_PackedTriangle(triangles, place));
            }
        }
        P(extents).at[4 * node + k] = OrderedBounds(uvec3(ordered(box.lo.x), ordered(box.lo.y), ordered(box.lo.z)),
                                                    uvec3(ordered(box.hi.x), ordered(box.hi.y), ordered(box.hi.z)));
    }
}

void choose(uint node, uvec4 children, uint count) {
    if (args.above > 0 && count <= args.above) {
        if (args.first == 0) P(chosen).at[node] = pair_of(uvec2(0));
        return;
    }
    float least;
    if (args.first == 0) {
        precise float dearer = (args.oriented_cost - args.node_cost) * half_area(own[0]);
        precise float along_axes = costs[0] - dearer;
        least = along_axes;
        P(least).at[node] = least;
        P(chosen).at[node] = pair_of(uvec2(0));
    } else {
        least = P(least).at[node];
    }
    uint best = BASES;
    [[unroll]] for (uint b = 0; b < BASES; ++b) {
        float cost = unstretched(costs[b], rodrigues[b]);
        if (rodrigues[b] != vec3(0.0) && cost < least) {
            least = cost;
            best = b;
        }
    }
    if (best < BASES) {
        P(least).at[node] = least;
        keep(node, children, best);
    }
}

void main() {
    [[unroll]] for (uint b = 0; b < BASES; ++b) {
        rodrigues[b] = rodrigues_of(words_of(P(bases).at[args.first + b]));
        frames[b] = frame_of(rodrigues[b]);
    }
    uint next = group_index() * WG * ITEMS + gl_LocalInvocationID.x;
    uint end = min((group_index() + 1) * WG * ITEMS, args.count);
    uint node = INVALID;
    // One loop for starting and for climbing: invocations whose climb is over don't wait for the others of their subgroup.
    for (;;) {
        uvec4 children;
        if (node == INVALID) {
            for (; next < end; next += WG) {
                children = LOAD_Node(nodes, next).children;
                if (inner_children(children) == 0) break;
            }
            if (next >= end) return;
            node = next;
            next += WG;
        } else {
            children = LOAD_Node(nodes, node).children;
        }
        uint count = gather(children);
        choose(node, children, count);
        uint above = P(parents).at[node] / 4;
        if (above < args.count) {
            [[unroll]] for (uint b = 0; b < BASES; ++b) STORE_Aabb(boxes, BASES * node + b, own[b])
            if (args.above > 0) P(counts).at[node] = count;
            // Hand-over: each inner child's invocation leaves its boxes and count; the last has read a count that all others'
            // went into, so that theirs are visible to it. The others turn to leaves that nobody else takes.
            uint inner = inner_children(LOAD_Node(nodes, above).children);
            node = arrive(above) + 1 == inner ? above : INVALID;
        } else {
            node = INVALID;  // that was the root
        }
    }
}
