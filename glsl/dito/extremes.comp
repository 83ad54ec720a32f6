// One invocation ITEMS packed nodes: from each node without inner children the extremal points of its children's and its
// own triangles climb as far as it is the last child to arrive. Writes points, ranges; hands them over there. Reads nodes,
// triangles, parents. Keeps: nobody waits, no barrier; the same points whatever the timing. Of leaves with few triangles
// all corners are kept, for some may be extremal in no direction.
#include "lib/points.glsl"
#include "lib/within.glsl"
#include "lib/reference.glsl"
#include "lib/climb.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

vec3 points_below[POINTS];
vec3 corners_below[POINTS];

// Takes p into the points of e.
#define TAKE_IN(e, p, first)                                                                                          \
    [[unroll]] for (uint j = 0; j < POINTS / 2; ++j) {                                                                \
        float here = along(direction_of(j), p);                                                                       \
        if (first || here < along(direction_of(j), e[2 * j])) e[2 * j] = p;                                           \
        if (first || here > along(direction_of(j), e[2 * j + 1])) e[2 * j + 1] = p;                                   \
    }

// Both arrays; of corners_below only where all corners have room, again and again.
void take_in_leaf(uint first, uint count) {
    for (uint place = first; place < first + count; ++place) {
        PackedTriangle triangle = LOAD_PackedTriangle(triangles, place);
        for (uint corner = 0; corner < 3; ++corner) {
            precise vec3 p = (corner == 0 ? triangle.a : corner == 1 ? triangle.b : triangle.c) - args.anchor;
            bool none = place == first && corner == 0;
            TAKE_IN(points_below, p, none)
            for (uint i = 3 * (place - first) + corner; i < POINTS; i += 3 * count) corners_below[i] = p;
        }
    }
}

void climb(uint node) {
    uvec4 children = LOAD_Node(nodes, node).children;
    if (inner_children(children) > 0) return;
    for (;;) {
        vec3 own[POINTS];
        Range range = Range(0, 0);
        for (uint k = 0; k < WIDTH && children[k] != INVALID; ++k) {
            uint slot = 4 * node + k;
            Range below;
            if (children[k] < LEAF_BIT) {
                LOAD_POINTS(points_below, slot)
                below = LOAD_Range(ranges, slot);
            } else {
                below = leaf_range(children[k]);
                take_in_leaf(below.first, below.count);
                if (3 * below.count <= POINTS) {
                    STORE_POINTS(corners_below, slot)
                } else {
                    STORE_POINTS(points_below, slot)
                }
                STORE_Range(ranges, slot, below)
            }
            [[unroll]] for (uint j = 0; j < POINTS / 2; ++j) {
                vec3 direction = direction_of(j), least = points_below[2 * j], greatest = points_below[2 * j + 1];
                if (k == 0 || along(direction, least) < along(direction, own[2 * j])) own[2 * j] = least;
                if (k == 0 || along(direction, greatest) > along(direction, own[2 * j + 1])) own[2 * j + 1] = greatest;
            }
            range = Range(k == 0 ? below.first : min(range.first, below.first), range.count + below.count);
        }
        uint up = P(parents).at[node];
        STORE_POINTS(own, up)
        STORE_Range(ranges, up, range)
        node = up / 4;
        if (node == args.count) return;  // that was the root
        children = LOAD_Node(nodes, node).children;
        if (!arrive_last(node, children)) return;
    }
}

void main() {
    FOR_ITEMS(i, args.count) climb(i);
}
