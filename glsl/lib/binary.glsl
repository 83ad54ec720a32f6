// A ray's way through a binary tree whose nodes have the literature's layouts. Wants the buffers aabbs, obbs, triangles
// and args.half_over_reach.
//
// Padding of oriented boxes. As in lib/ray.glsl: the hit lies within 8 u R of the ray in each axis and in depth, the
// moved origin within 10 u R. A row of the matrix is a unit vector over the box's extent e along it, so of components that
// sum to √3 / e at most: what was off by x is off by √3 x / e in the cube. Three products and three sums (4 u) take the
// origin into the cube, of terms that sum to √3 R / e at most, for the row's last number is no larger than a corner of the
// tree makes it; three products and two sums (3 u) the direction, over the distance R. The row's last number is rounded (1 u); then the reciprocal (5 u), a product and a
// sum (3 u). That is 34 u √3, below 59 u, so PAD_OBB is 64 u; the half edge is rounded too, for which extents are larger by
// 2⁻²⁰ of themselves.
// A matrix has no room for a ray's own R: boxes are padded by PAD_OBB · R₀ at build, R₀ four times the tree's largest
// coordinate, and for a ray from farther away the half edge is R / R₀ times as long, which is more than the padding needs.
#include "lib/visit.glsl"

layout(constant_id = SPEC_LAYOUT) const uint LAYOUT = 0;

// What sorts a child: the bits of the t where the ray enters; at least MISSED where it passes by.
int key_of(vec3 enter3, vec3 leave3, Setup s, float limit) {
    float enter = greatest_of(greatest_of(enter3.x, enter3.y), greatest_of(enter3.z, s.begin));
    float leave = least_of(least_of(leave3.x, leave3.y), least_of(leave3.z, limit));
    return enter <= leave ? floatBitsToInt(enter) : MISSED;
}

int meet_aabb(Setup s, vec3 lo, vec3 hi, float limit) {
    bvec3 negative = lessThan(s.inverse, vec3(0.0));
    vec3 enter3 = fma(mix(lo, hi, negative), s.inverse, s.near);
    return key_of(enter3, fma(mix(hi, lo, negative), s.inverse, s.far), s, limit);
}

int meet_obb(Setup s, Obb b, float limit) {
    vec3 o = turned(Frame(b.x.xyz, b.y.xyz, b.z.xyz), s.moved) + vec3(b.x.w, b.y.w, b.z.w);
    vec3 inverse = inverse_of(turned(Frame(b.x.xyz, b.y.xyz, b.z.xyz), s.direction));
    vec3 centre = -o * inverse, reach = max(0.5, s.walk_reach * args.half_over_reach) * abs(inverse);
    return key_of(centre - reach, centre + reach, s, limit);
}

int meet_either(Setup s, Obb b, bool aligned, float limit) {
    if (LAYOUT == LAYOUT_MIXED && aligned) return meet_aabb(s, b.x.xyz, vec3(b.x.w, b.y.xy), limit);
    return meet_obb(s, b, limit);
}

// From a node to what comes next: its nearer child that is met, or what waited.
uint descend(uint node, inout Setup s, Nearest nearest, inout Tests tests) {
    uvec2 children;
    ivec2 keys;
    if (STEPS != 0) count_node(true);
    if (LAYOUT == LAYOUT_OBB || (LAYOUT == LAYOUT_MIXED && (node & OBB_BIT) != 0u)) {
        ObbNode n = LOAD_ObbNode(obbs, node & ~OBB_BIT);
        children = n.children;
        keys = ivec2(meet_either(s, n.left, (n.aligned & 1u) != 0u, nearest.limit),
                     meet_either(s, n.right, (n.aligned & 2u) != 0u, nearest.limit));
        if (COUNT != 0) {
            uint aligned = bitCount(n.aligned);
            tests.boxes += aligned;
            tests.oriented += 2 - aligned;
        }
    } else {
        AabbNode n = LOAD_AabbNode(aabbs, node);
        children = n.children;
        keys = ivec2(meet_aabb(s, n.left.lo, n.left.hi, nearest.limit),
                     meet_aabb(s, n.right.lo, n.right.hi, nearest.limit));
        if (COUNT != 0) tests.boxes += 2;
    }
    if (keys.y < keys.x) {
        keys = keys.yx;
        children = children.yx;
    }
    if (keys.y < MISSED) stack[top++] = pair_of(uvec2(keys.y, children.y));
    return keys.x < MISSED ? children.x : pop_within(nearest.limit);
}
