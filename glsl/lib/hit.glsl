// Ray against triangle. Wants lib/ray.glsl, the buffer triangles and the constants ANY and ROBUST.

layout(constant_id = SPEC_ANY) const uint ANY = 0;
layout(constant_id = SPEC_COUNT) const uint COUNT = 0;
layout(constant_id = SPEC_LEAF_BITS) const uint LEAF_BITS = 3;

uint leaf_first(uint reference) { return reference & ((1u << (31 - LEAF_BITS)) - 1u); }
uint leaf_count(uint reference) { return ((reference & ~LEAF_BIT) >> (31 - LEAF_BITS)) + 1u; }

// x, y, z in the order of s.axes.
vec3 turned(Setup s, vec3 p) { return s.axes.z == 2 ? p : s.axes.z == 1 ? p.zxy : p.yzx; }

// Where a ray meets a triangle: u and v are the weights of the second and third corner.
struct Meeting {
    float t;
    vec2 uv;
};

// What is known of a meeting.
const uint PASSED_BY = 0u;
const uint MET = 1u;
const uint UNKNOWN = 2u;

#ifdef FLOAT64
#include "lib/by_doubles.glsl"
#else
#include "lib/by_pairs.glsl"
#endif
#include "lib/by_integers.glsl"

// The test in higher precision and, where that can't tell, by integers: as if in exact arithmetic. t is less than an ulp off,
// however the triangle lies. Of those that are surely beyond `limit` nothing is met.
bool meet_in_doubt(Setup s, PackedTriangle t, float limit, out Meeting m) {
    vec3 d = turned(s, s.line), a = turned(s, t.a), b = turned(s, t.b), c = turned(s, t.c);
#ifdef FLOAT64
    // Of t that differ by less than the least normal float both may be one: then neither is beyond the other.
    double latest = double(limit) + (limit < s.t_max ? LEAST_NORMAL : 0.0LF);
    uint known = is_distant(s) ? UNKNOWN : meet_by_doubles(d, s.origin, a, b, c, s.t_min, latest, m);
#else
    // Beyond, products might overflow.
    uint known = s.reach < 1048576.0 ? meet_by_pairs(d, s.origin, a, b, c, s.t_min, limit, m) : UNKNOWN;
#endif
    if (known == UNKNOWN)
        known = meet_by_integers(d, s.origin, scale_of(s), shift_of(s), a, b, c, s.t_min, s.t_max, m) ? MET : PASSED_BY;
    return known == MET;
}

// [WOOP13]: shears the triangle so that the ray is the z axis, then takes the signs of three 2-D edge functions.
// Differs: what rounding may have turned, and all that is met, is met again in higher precision
// (meet_in_doubt).
bool meet_robust(Setup s, PackedTriangle t, float limit, out Meeting m) {
    precise vec3 a = turned(s, t.a) - s.origin;
    precise vec3 b = turned(s, t.b) - s.origin;
    precise vec3 c = turned(s, t.c) - s.origin;
    precise vec2 p = a.xy - s.shear.xy * a.z;
    precise vec2 q = b.xy - s.shear.xy * b.z;
    precise vec2 r = c.xy - s.shear.xy * c.z;
    precise float u = r.x * q.y - r.y * q.x;
    precise float v = p.x * r.y - p.y * r.x;
    precise float w = q.x * p.y - q.y * p.x;
    float lo = least_of(u, least_of(v, w)), hi = greatest_of(u, greatest_of(v, w));
    // A sheared coordinate is off by at most 10 u R (see lib/ray.glsl), so an edge function by at most 20 u R F and
    // 200 u² R², F the largest |x| + |y|, and by 4 u of products that R F bounds. It is no larger than F² / 2, so what is
    // beyond the doubt has F > 64 u R, and 200 u² R² is 4 u R F: 28 in all.
    vec2 far = max(abs(p), max(abs(q), abs(r)));
    float doubt = ((32.0 / 16777216.0) * s.reach) * (far.x + far.y);
    // What passes is few: it is met again, for its sign where in doubt, and for its t: of a triangle much larger than t,
    // single precision would lose a share of 10⁻⁴.
    return (is_distant(s) || !(lo < -doubt && hi > doubt)) && meet_in_doubt(s, t, limit, m);
}

// [MOLLER97]. Leaks at edges and vertices.
bool meet_fast(Setup s, PackedTriangle t, out Meeting m) {
    vec3 direction = turned(s, s.direction);
    vec3 a = turned(s, t.a), e1 = turned(s, t.b) - a, e2 = turned(s, t.c) - a;
    vec3 h = cross(direction, e2);
    float det = dot(e1, h);
    float sign_of = det < 0.0 ? -1.0 : 1.0;
    vec3 from = s.origin - a;
    float u = dot(from, h) * sign_of;
    vec3 q = cross(from, e1);
    float v = dot(direction, q) * sign_of;
    if (det == 0.0 || u < 0.0 || v < 0.0 || u + v > abs(det)) return false;
    precise float over = 1.0 / abs(det);
    float depth = dot(e2, q) * sign_of;
    precise float at = depth * over;
    precise vec2 uv = vec2(u, v) * over;
    m = Meeting(at, uv);
    return true;
}

// The nearest hit so far.
struct Nearest {
    float t;
    uint triangle;
    vec2 uv;
    float limit;  // what is beyond, as the walk counts t, is passed by
};

Nearest none_yet(Setup s) { return Nearest(s.t_max, INVALID, vec2(0.0), limit_at(s, s.t_max)); }

// Of equal t the lower triangle index wins, so that neither the tree nor the order of traversal shows in the result.
// Returns whether an any-hit query is answered.
bool meet_triangle(Setup s, PackedTriangle triangle, inout Nearest nearest) {
    Meeting m;
    bool met = ROBUST != 0 ? meet_robust(s, triangle, nearest.t, m) : meet_fast(s, triangle, m);
    if (!met) return false;
    // Of a determinant too small for its reciprocal t would be infinite, and no number of u and v.
    if (!(m.t >= s.t_min && m.t <= min(nearest.t, 3.4028235e38))) return false;
    if (ANY != 0) {
        nearest.triangle = 0;
        return true;
    }
    if (m.t == nearest.t && triangle.index >= nearest.triangle) return false;
    nearest.t = m.t;
    nearest.triangle = triangle.index;
    nearest.uv = m.uv;
    nearest.limit = limit_at(s, m.t);
    return false;
}

// The integer nearest to the float of these bits, below 2²³; of two the even one. Not roundEven: lavapipe's, with 16
// lanes, takes the one farther from 0.
uint nearest_even(uint bits) {
    int shift = 150 - int(bits >> 23);
    if (shift > 24) return 0u;
    uint mantissa = bits & 0x007fffffu | 0x00800000u, half_unit = 1u << (shift - 1);
    uint whole = mantissa >> shift, rest = mantissa & ((half_unit << 1) - 1);
    return whole + uint(rest > half_unit || (rest == half_unit && (whole & 1u) != 0u));
}

Hit hit_of(Setup s, Nearest nearest) {
    if (nearest.triangle == INVALID) return Hit(uintBitsToFloat(0x7f800000u), INVALID, 0.0, 0.0);
    if (ANY != 0) return Hit(0.0, INVALID, 0.0, 0.0);
    // +inf means a miss: a t beyond the floats (a denormal direction has such) becomes the largest of them.
    float t = min(scaled(nearest.t, s.t_exponent), 3.4028235e38);
    // A denormal t is put together by integers: some devices would make it 0.
    if (t == 0.0) {
        uint units = floatBitsToUint(scaled(nearest.t, s.t_exponent + 149));
        t = uintBitsToFloat(units & 0x80000000u | nearest_even(units & 0x7fffffffu));
    }
    return Hit(t, nearest.triangle, nearest.uv.x, nearest.uv.y);
}
