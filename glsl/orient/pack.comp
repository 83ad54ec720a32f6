// One invocation ITEMS packed nodes: those whose boxes cost less in the frame chosen than as they are, be that axis-aligned
// or in another frame, are packed again in it, by the exact extents of their children. Reads chosen, extents; nodes change.
#include "lib/box.glsl"
#include "lib/grid.glsl"
#include "lib/ordered.glsl"
#include "lib/within.glsl"
#include "lib/cost.glsl"
#include "lib/reference.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

// Half area of child k's box as packed, which is that of its planes.
float packed_area(Node n, uint k) {
    vec3 steps = uintBitsToFloat(uvec3(n.exponents << 23, n.exponents << 15, n.exponents << 7) & 0x7f800000u);
    precise vec3 size = vec3(ivec3(n.hi >> 8 * k & 0xffu) - ivec3(n.lo >> 8 * k & 0xffu)) * steps;
    precise float area = size.x * (size.y + size.z) + size.y * size.z;
    return area;
}

void main() {
    FOR_ITEMS(i, args.count) {
        uvec2 words = words_of(P(chosen).at[i]);
        if (!is_oriented(words)) continue;
        Node n = LOAD_Node(nodes, i);
        Aabb boxes[WIDTH];
        Aabb box = NOWHERE;
        uvec3 least = uvec3(255), greatest = uvec3(0);
        [[unroll]] for (uint k = 0; k < WIDTH; ++k) {
            if (n.children[k] != INVALID) {
                OrderedBounds extent = P(extents).at[4 * i + k];
                boxes[k] = Aabb(vec3(unordered(extent.lo.x), unordered(extent.lo.y), unordered(extent.lo.z)),
                                vec3(unordered(extent.hi.x), unordered(extent.hi.y), unordered(extent.hi.z)));
                box = merged(box, boxes[k]);
                least = min(least, n.lo >> 8 * k & 0xffu);
                greatest = max(greatest, n.hi >> 8 * k & 0xffu);
            }
        }
        uvec3 exponents = step_exponents(box);
        vec3 steps = steps_of(exponents);
        uint packed_exponents = exponents.x | exponents.y << 8 | exponents.z << 16 | ORIENTED_BIT;
        Node oriented = Node(box.lo, packed_exponents, uvec3(0), uvec3(0), n.children, words);
        [[unroll]] for (uint k = 0; k < WIDTH; ++k) {
            uvec3 lo = uvec3(255), hi = uvec3(0);
            if (n.children[k] != INVALID) {
                lo = least_planes(boxes[k].lo, box.lo, steps);
                hi = greatest_planes(boxes[k].hi, box.lo, steps);
            }
            oriented.lo |= lo << 8 * k;
            oriented.hi |= hi << 8 * k;
        }
        // As they would be traced: both with the slack of their grids.
        vec3 r = rodrigues_of(words), r_before = rodrigues_of(n.frame);
        Node whole = Node(n.origin, n.exponents, least, greatest, n.children, uvec2(0));
        precise float cost = 0.0, cost_before = 0.0;
        if (!is_oriented(n.frame)) cost = (args.oriented_cost - args.node_cost) * packed_area(whole, 0);
        for (uint k = 0; k < WIDTH && n.children[k] != INVALID; ++k) {
            float visit = cost_of_visit(n.children[k], leaf_range(n.children[k]).count);
            float area = packed_area(n, k);
            if (is_oriented(n.frame)) area = unstretched(area, r_before);
            cost = cost + visit * unstretched(packed_area(oriented, k), r);
            cost_before = cost_before + visit * area;
        }
        if (cost < cost_before) {
            STORE_Node(nodes, i, oriented)
            if (!is_oriented(n.frame)) atomicAdd(P(oriented).at[0], 1u);
        }
    }
}
