// A ray made ready for boxes and triangles. Wants args.{exponent, anchor, reach, count, threads, order}.
//
// Unit space: coordinates are scaled by 2^exponent, so that the scene measures between ½ and 1 and only the origin of a
// distant ray overflows (lib/distant.glsl); the direction is scaled by a power of two to a largest component in [1, 2). Both
// are exact. Boxes, not triangles, are moved by −anchor besides, so that their coordinates are small however far from the
// origin the scene lies.
//
// Box padding. A hit that the triangle test reports lies within PAD · R of the ray in each axis and in depth, where R is
// the largest coordinate difference between where its walk begins (lib/approach.glsl) and the scene: the robust test is
// exact but for t, which it rounds (1⅛ u, u = 2⁻²⁴); the boxes' coordinates are rounded (1 u), their planes' distances from
// the node's corner (1 u), the moved origin (1 u, of a distant ray 10 u), the reciprocal direction (5 u), and of a plane two
// products and three sums (5 u; steps are powers of two). That is less than 24 u; PAD is 32 u. Boxes larger by PAD · R on
// every side contain every robust hit, so no ray falls between two of them. Of the fast test's hits, whose errors grow with
// slenderness, it is not said.
const float PAD = 32.0 / 16777216.0;
// Padding in a node's frame, times its stretch (lib/frame.glsl). A row of the rotation has components that sum to √3 at
// most, so what was off by e an axis is off by √3 e: the hit (1⅛ u √3), the corner less the anchor and the moved origin
// (1 u √3 each, of a distant ray 10 u √3). Three products and two sums (3 u √3) take the corner, the origin and, over the
// distance R, the direction into the frame. Distances from the node's corner, up to twice as long, are rounded (2 u √3);
// reciprocals and planes as above, of lengths up to √3 R (10 u √3). That is 58 u; PAD_ORIENTED is 64 u.
const float PAD_ORIENTED = 64.0 / 16777216.0;
// Direction components below this are raised to it, with their sign: over the distance R that moves the ray by
// 2⁻⁴⁰ R, far less than the padding, and ±0 needs no case of its own.
const float LEAST_DIRECTION = 1.0 / 1099511627776.0;

layout(constant_id = SPEC_ROBUST) const uint ROBUST = 1;

#include "lib/finite.glsl"
#include "lib/turn.glsl"
#include "lib/double_single.glsl"
#include "lib/approach.glsl"

struct Setup {
    vec3 origin;      // unit scale · 2^−scale_of, not moved; in the order of axes
    vec3 shear;       // of the triangle test: direction[axes.x], [axes.y] over [axes.z]; 1 over [axes.z]
    uvec3 axes;       // a permutation of 0 1 2; axes.z is the direction's largest component
    vec3 inverse;     // 1 / direction
    vec3 near;        // of the walk, t of a near plane at p: p · inverse + near, not too great
    vec3 far;         // t of a far plane, not too small
    float t_min;
    float t_max;
    int t_exponent;   // t of the file = t here · 2^t_exponent
    vec3 direction;   // scaled
    vec3 line;        // as the exact test takes the direction
    float reach;      // largest coordinate difference between the origin and the scene
    float ahead;      // where the walk begins, in lengths of the direction: what is of the walk counts t from there
    float begin;      // t_min, of the walk
    float walk_reach; // R, of the walk
    vec3 moved;       // origin of the walk, moved
    uvec2 frame;      // that the next three are of; 0: of none yet
    vec3 turned_inverse;
    vec3 turned_near;
    vec3 turned_far;
    bool valid;       // finite, with a direction, and not seen to miss; other rays miss
};

// The exponent, biased by 127, of the positive float of these bits, which become those of a normal float of the same
// mantissa. By integers: to floating point, denormal numbers may be 0.
int exponent_of(inout uint bits) {
    if (bits >= 0x00800000u) return int(bits >> 23);
    bits = floatBitsToUint(float(bits));  // units of 2⁻¹⁴⁹
    return int(bits >> 23) - 149;
}

// x · 2^exponent, exactly; 0 of x's sign where that is below 2⁻¹²⁶.
float scaled(float x, int exponent) {
    uint sign_bit = floatBitsToUint(x) & 0x80000000u, bits = floatBitsToUint(x) ^ sign_bit;
    if (bits == 0u || bits >= 0x7f800000u) return x;
    int e = exponent_of(bits) + exponent;
    return uintBitsToFloat(sign_bit | (e < 1 ? 0u : e > 254 ? 0x7f800000u : bits & 0x007fffffu | uint(e) << 23));
}

// Likewise a limit of t, which stays on its side of 0: below 2⁻¹²⁶ it becomes that, so that a range that begins or ends at 0
// is told from one that only does so nearly.
float scaled_limit(float t, int exponent) {
    uint bits = floatBitsToUint(t), size = floatBitsToUint(scaled(t, exponent)) & 0x7fffffffu;
    bool nearly = size == 0u && (bits & 0x7fffffffu) != 0u;
    return nearly ? uintBitsToFloat(bits & 0x80000000u | 0x00800000u) : scaled(t, exponent);
}

// 1 / d, finite.
vec3 inverse_of(vec3 d) {
    vec3 inverse;
    for (int k = 0; k < 3; ++k) {
        float sign_bit = uintBitsToFloat(floatBitsToUint(LEAST_DIRECTION) | (floatBitsToUint(d[k]) & 0x80000000u));
        inverse[k] = 1.0 / (abs(d[k]) < LEAST_DIRECTION ? sign_bit : d[k]);
    }
    return inverse;
}

// Whether the origin is so far away that lib/distant.glsl sees to it.
bool is_distant(Setup s) { return ROBUST != 0 && !(s.reach < DISTANT); }

// Exponent of the origin: 0, but of a distant ray. Not kept, nor is the next, for hardly a ray asks.
int scale_of(Setup s) { return is_distant(s) ? max(args.exponent, 0) : 0; }

// t here = t in lengths of `line` · 2^shift.
int shift_of(Setup s) { return is_distant(s) ? -s.t_exponent - args.exponent : 0; }

// What is beyond t, as the walk counts.
float limit_at(Setup s, float t) { return is_distant(s) ? 3.4028235e38 : walk_limit(t, s.ahead, 1.0); }

#include "lib/digits.glsl"
#include "lib/distant.glsl"

Setup prepare(Ray ray) {
    Setup s;
    vec3 d = ray.direction, o = ray.origin;
    s.valid = finite(d) && finite(o) && !is_nan(ray.t_min) && !is_nan(ray.t_max);
    uvec3 sizes = floatBitsToUint(d) & 0x7fffffffu;
    uint largest = max(sizes.x, max(sizes.y, sizes.z));
    s.valid = s.valid && largest > 0u;
    int exponent = exponent_of(largest) - 127;
    d = vec3(scaled(d.x, -exponent), scaled(d.y, -exponent), scaled(d.z, -exponent));
    s.direction = d;
    s.line = d;
    s.t_exponent = -exponent - args.exponent;
    vec3 a = abs(d);
    s.axes = a.z >= a.x && a.z >= a.y ? uvec3(0, 1, 2) : a.y >= a.x ? uvec3(2, 0, 1) : uvec3(1, 2, 0);

    o = vec3(scaled(o.x, args.exponent), scaled(o.y, args.exponent), scaled(o.z, args.exponent));
    vec3 moved = o - args.anchor;
    float reach = args.reach + max(abs(moved.x), max(abs(moved.y), abs(moved.z)));
    s.reach = reach;
    s.walk_reach = reach;
    s.ahead = 0.0;
    if (is_distant(s)) o = take_far(s, ray, o);
    s.t_min = scaled_limit(ray.t_min, -s.t_exponent);
    s.t_max = scaled_limit(ray.t_max, -s.t_exponent);
    s.begin = s.t_min;
    if (is_distant(s)) {
        moved = approached_from_far(s, o, exponent);
    } else if (reach > NEAR && reach < FARTHEST) {
        s.ahead = ahead_of(moved, d, reach);
        s.begin = walk_limit(s.t_min, s.ahead, -1.0);
        moved = approached(o, args.anchor, d, s.ahead);
        s.walk_reach = args.reach + max(abs(moved.x), max(abs(moved.y), abs(moved.z))) + reach * (1.0 / 16777216.0);
    }
    s.moved = moved;
    s.frame = uvec2(0);
    s.inverse = inverse_of(d);
    precise vec3 centre = -moved * s.inverse;
    precise vec3 pad = (PAD * s.walk_reach) * abs(s.inverse);
    s.near = centre - pad;
    s.far = centre + pad;

    s.origin = s.axes.z == 2 ? o : s.axes.z == 1 ? o.zxy : o.yzx;
    vec3 turned = s.axes.z == 2 ? d : s.axes.z == 1 ? d.zxy : d.yzx;
    precise vec3 shear = vec3(turned.x, turned.y, 1.0) / turned.z;
    s.shear = shear;
    return s;
}
