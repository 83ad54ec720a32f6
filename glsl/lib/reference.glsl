// What references of a packed node's children mean.
layout(constant_id = SPEC_LEAF_BITS) const uint LEAF_BITS = 3;

// Triangles of a leaf.
Range leaf_range(uint child) {
    uint bits = child & ~LEAF_BIT;
    return Range(bits & ((1u << (31 - LEAF_BITS)) - 1u), (bits >> (31 - LEAF_BITS)) + 1u);
}

uint inner_children(uvec4 children) {
    return uint(children.x < LEAF_BIT) + uint(children.y < LEAF_BIT) + uint(children.z < LEAF_BIT)
           + uint(children.w < LEAF_BIT);
}
