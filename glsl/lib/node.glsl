// Ray against the children of a packed node. Wants lib/ray.glsl.
#include "lib/frame.glsl"

layout(constant_id = SPEC_ORIENTED) const uint ORIENTED = 0;

// What sorts children: the bits of the t where the ray enters, the low two the child's number; at least MISSED where
// the ray passes by. As integers, smaller is nearer; where t is negative the order means nothing, and need not.
const int MISSED = 0x7f800000;

// The ray in a node's frame: its t stays.
void turn(inout Setup s, inout bvec3 negative, uvec2 frame) {
    vec3 r = rodrigues_of(frame);
    Frame f = frame_of(r);
    vec3 o = vec3(dot(f.x, s.moved), dot(f.y, s.moved), dot(f.z, s.moved));
    s.inverse = inverse_of(vec3(dot(f.x, s.direction), dot(f.y, s.direction), dot(f.z, s.direction)));
    vec3 centre = -o * s.inverse;
    vec3 pad = (PAD_ORIENTED * stretch_of(r) * s.reach) * abs(s.inverse);
    s.near = centre - pad;
    s.far = centre + pad;
    negative = lessThan(s.inverse, vec3(0.0));
}

ivec4 meet_children(Setup s, bvec3 negative, Node n, float t_max) {
    if (ORIENTED != 0 && is_oriented(n.frame)) turn(s, negative, n.frame);
    uvec3 near_planes = mix(n.lo, n.hi, negative), far_planes = mix(n.hi, n.lo, negative);
    vec3 scale = uintBitsToFloat(uvec3(n.exponents << 23, n.exponents << 15, n.exponents << 7) & 0x7f800000u);
    vec3 stride = scale * s.inverse;
    vec3 near = n.origin * s.inverse + s.near, far = n.origin * s.inverse + s.far;
    ivec4 keys;
    [[unroll]] for (int k = 0; k < WIDTH; ++k) {
        vec3 enter3 = vec3(ivec3(near_planes >> 8 * k & 0xffu)) * stride + near;
        vec3 leave3 = vec3(ivec3(far_planes >> 8 * k & 0xffu)) * stride + far;
        float enter = greatest_of(greatest_of(enter3.x, enter3.y), greatest_of(enter3.z, s.t_min));
        float leave = least_of(least_of(leave3.x, leave3.y), least_of(leave3.z, t_max));
        bool met = enter <= leave && (k < 1 || n.children[k] != INVALID);
        keys[k] = ((met ? floatBitsToInt(enter) : MISSED) & ~3) | k;
    }
    return keys;
}

// Nearest first.
ivec4 sorted(ivec4 k) {
    k = ivec4(min(k.xz, k.yw), max(k.xz, k.yw)).xzyw;
    k = ivec4(min(k.xy, k.zw), max(k.xy, k.zw));
    return ivec4(k.x, min(k.y, k.z), max(k.y, k.z), k.w);
}

uint child_of(Node n, int key) {
    uint low = (key & 1) != 0 ? n.children.y : n.children.x, high = (key & 1) != 0 ? n.children.w : n.children.z;
    return (key & 2) != 0 ? high : low;
}

// Children that are there.
uint children_of(Node n) {
    return 1 + uint(n.children.y != INVALID) + uint(n.children.z != INVALID) + uint(n.children.w != INVALID);
}

void count_boxes(inout Tests tests, Node n) {
    if (ORIENTED != 0 && is_oriented(n.frame)) tests.oriented += children_of(n);
    else tests.boxes += children_of(n);
}
