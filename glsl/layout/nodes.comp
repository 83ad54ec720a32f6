// One invocation a kept node: its packed node, and the input indices of the triangles in the leaves among its children.
// Reads raw, cuts, kept, packed, firsts, order. Keeps: the triangles below any child lie side by side.
#include "lib/raw.glsl"
#include "lib/pack.glsl"
#include "lib/grid.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

void main() {
    FOR_ITEMS(i, args.count) {
        uint from = P(kept).at[i];
        // The children left to right: those of absorbed nodes in their place. An edge is a raw node and a side; at
        // most three wait.
        Aabb boxes[WIDTH];
        uint references[WIDTH];
        uint edge = 2 * from;
        uvec3 waiting = uvec3(2 * from + 1, INVALID, INVALID);
        Aabb box = Aabb(vec3(3.4e38), vec3(-3.4e38));
        [[unroll]] for (int k = 0; k < WIDTH; ++k) {
            references[k] = INVALID;
            if (edge != INVALID) {
                uvec2 children = CHILDREN(edge >> 1);
                uint child = (edge & 1) == 0 ? children.x : children.y;
                while (is_absorbed(child)) {
                    waiting = uvec3(2 * (child & RAW_MASK) + 1, waiting.xy);
                    edge = 2 * (child & RAW_MASK);
                    child = CHILDREN(edge >> 1).x;
                }
                references[k] = child;
                boxes[k] = CHILD_BOX(edge >> 1, edge & 1);
                box.lo = least_of(box.lo, boxes[k].lo);
                box.hi = greatest_of(box.hi, boxes[k].hi);
                edge = waiting.x;
                waiting = uvec3(waiting.yz, INVALID);
            }
        }

        uvec3 exponents = step_exponents(box);
        vec3 steps = steps_of(exponents);
        uint to = P(firsts).at[from];
        uint packed_exponents = exponents.x | exponents.y << 8 | exponents.z << 16;
        Node node = Node(box.lo, packed_exponents, uvec3(0), uvec3(0), uvec4(0), uvec2(0));
        [[unroll]] for (int k = 0; k < WIDTH; ++k) {
            uint child = references[k];
            uvec3 lo = uvec3(255), hi = uvec3(0);
            if (child != INVALID) {
                lo = least_planes(boxes[k].lo, box.lo, steps);
                hi = greatest_planes(boxes[k].hi, box.lo, steps);
                if (is_leaf(child)) {
                    uint count = pack_leaf(child, to);
                    child = leaf_reference(to, count);
                    to += count;
                } else {
                    to += LOAD_RawCut(cuts, child).count;
                    child = P(packed).at[child];
                }
            }
            node.lo |= lo << 8 * k;
            node.hi |= hi << 8 * k;
            node.children[k] = child;
        }
        STORE_Node(nodes, i, node)
    }
}
