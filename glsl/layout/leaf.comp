// One invocation: the packed tree of a scene that is a single leaf. Reads raw, root, order.
#include "lib/raw.glsl"
#include "lib/pack.glsl"
#include "lib/grid.glsl"

void main() {
    if (invocation_index() != 0) return;
    uint count = pack_leaf(P(root).at[0].node, 0);
    Aabb box = P(root).at[0].bounds;
    uvec3 exponents = step_exponents(box);
    uvec3 hi = greatest_planes(box.hi, box.lo, steps_of(exponents));
    Node node = Node(box.lo, exponents.x | exponents.y << 8 | exponents.z << 16, uvec3(0xffffff00u), hi,
                     uvec4(leaf_reference(0, count), INVALID, INVALID, INVALID), uvec2(0));
    STORE_Node(nodes, 0, node)
}
