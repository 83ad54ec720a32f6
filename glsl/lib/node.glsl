// Ray against the children of a packed node. Wants lib/ray.glsl.
#include "lib/frame.glsl"

layout(constant_id = SPEC_ORIENTED) const uint ORIENTED = 0;

// What sorts children: the bits of the t where the ray enters, the low two the child's number; at least MISSED where
// the ray passes by. As integers, smaller is nearer; where t is negative the order means nothing, and need not.
const int MISSED = 0x7f800000;

vec3 turned(Frame f, vec3 p) {
    return vec3(fma(f.x.x, p.x, fma(f.x.y, p.y, f.x.z * p.z)), fma(f.y.x, p.x, fma(f.y.y, p.y, f.y.z * p.z)),
                fma(f.z.x, p.x, fma(f.z.y, p.y, f.z.z * p.z)));
}

bool in_frame(Node n) { return ORIENTED != 0 && (n.exponents & ORIENTED_BIT) != 0u; }

// Takes the ray into a frame: its t stays. Nodes that follow each other often share theirs.
void turn(inout Setup s, uvec2 frame) {
    if (frame == s.frame) return;
    vec3 r = rodrigues_of(frame);
    Frame f = frame_of(r);
    vec3 o = turned(f, s.moved);
    s.turned_inverse = inverse_of(turned(f, s.direction));
    vec3 pad = (PAD_ORIENTED * stretch_of(r) * s.walk_reach) * abs(s.turned_inverse);
    s.turned_near = fma(-o, s.turned_inverse, -pad);
    s.turned_far = fma(-o, s.turned_inverse, pad);
    s.frame = frame;
}

// Where the node has a frame, the ray must have been turned into it.
ivec4 meet_children(Setup s, Node n, float limit) {
    vec3 inverse = s.inverse, from_near = s.near, from_far = s.far;
    if (in_frame(n)) {
        inverse = s.turned_inverse;
        from_near = s.turned_near;
        from_far = s.turned_far;
    }
    bvec3 negative = lessThan(inverse, vec3(0.0));
    uvec3 near_planes = mix(n.lo, n.hi, negative), far_planes = mix(n.hi, n.lo, negative);
    vec3 scale = uintBitsToFloat(uvec3(n.exponents << 23, n.exponents << 15, n.exponents << 7) & 0x7f800000u);
    vec3 stride = scale * inverse;
    vec3 near = fma(n.origin, inverse, from_near), far = fma(n.origin, inverse, from_far);
    ivec4 keys;
    [[unroll]] for (int k = 0; k < WIDTH; ++k) {
        vec3 enter3 = fma(vec3(ivec3(near_planes >> 8 * k & 0xffu)), stride, near);
        vec3 leave3 = fma(vec3(ivec3(far_planes >> 8 * k & 0xffu)), stride, far);
        float enter = greatest_of(greatest_of(enter3.x, enter3.y), greatest_of(enter3.z, s.begin));
        float leave = least_of(least_of(leave3.x, leave3.y), least_of(leave3.z, limit));
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
    if (in_frame(n)) tests.oriented += children_of(n);
    else tests.boxes += children_of(n);
}
