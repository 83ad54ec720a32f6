// Ray against triangle. Wants lib/ray.glsl, the buffer triangles and the constants ANY and ROBUST.

layout(constant_id = SPEC_ANY) const uint ANY = 0;
layout(constant_id = SPEC_COUNT) const uint COUNT = 0;
layout(constant_id = SPEC_ROBUST) const uint ROBUST = 1;
layout(constant_id = SPEC_LEAF_BITS) const uint LEAF_BITS = 3;

uint leaf_first(uint reference) { return reference & ((1u << (31 - LEAF_BITS)) - 1u); }
uint leaf_count(uint reference) { return ((reference & ~LEAF_BIT) >> (31 - LEAF_BITS)) + 1u; }

// x, y, z in the order of s.axes.
vec3 turned(Setup s, vec3 p) { return s.axes.z == 2 ? p : s.axes.z == 1 ? p.zxy : p.yzx; }

// What a triangle test knows: the hit at t = depth / det, weights of the second and third corner = uv / det.
struct Meeting {
    float depth;
    float det;
    vec2 uv;
};

#ifdef FLOAT64
#include "lib/triple.glsl"

// The test in double precision. Signs are those of exact arithmetic and the triangle is closed: of the triangles around a
// vertex that a ray goes through, at least one is hit, and no other triangle is.
bool meet_in_doubt(Setup s, PackedTriangle t, float limit, out Meeting m) {
    dvec3 d = dvec3(turned(s, s.direction)), o = dvec3(s.origin);
    dvec3 a = dvec3(turned(s, t.a)), b = dvec3(turned(s, t.b)), c = dvec3(turned(s, t.c));
    bvec3 sure;
    dvec3 weight = dvec3(triple(d, o, c, b, sure.x), triple(d, o, a, c, sure.y), triple(d, o, b, a, sure.z));
    // In one place, for drivers that run what no ray of a subgroup wants.
    if (!all(sure)) {
        for (int k = 0; k < 3; ++k) {
            double exact = sure.x ? weight.x : exact_triple(d, o, c, b);
            weight = dvec3(weight.yz, exact);
            sure = bvec3(sure.yz, true);
            dvec3 first = a;
            a = b;
            b = c;
            c = first;
        }
    }
    double u = weight.x, v = weight.y, w = weight.z;
    if ((u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0)) return false;
    precise double det = u + v + w;
    if (det == 0.0) return false;
    precise double depth = (u * (a.z - o.z) + v * (b.z - o.z) + w * (c.z - o.z)) / (det * d.z);
    m = Meeting(float(depth), 1.0, vec2(float(v / det), float(w / det)));
    return true;
}
#else
#include "lib/double_single.glsl"
#include "lib/digits.glsl"

// A triple product of double-single vectors is off by 28 u² = 2⁻⁴³ of its products' sizes, these by 2⁻²²: what is larger than
// twice that has its sign, and what is 2⁻¹⁵ of them is right to an eighth of an ulp. Of numbers below 2⁻⁶⁰, for as long as no
// coordinate is above 2²⁰, what underflowed might count.
const float PAIR_DOUBT = 1.0 / 4398046511104.0;
const float PAIR_RIGHT = 1.0 / 32768.0;
const float PAIR_LEAST = 1.0 / 1152921504606846976.0;

const uint PASSED_BY = 0u;
const uint MET = 1u;
const uint UNKNOWN = 2u;

// In double-single precision: whether the triangle is met, at a t that is not surely out of the range up to `limit`. With x
// the corner a less the origin, n = e₂ × e₁ and h = d × x: det = d·n, t det = x·n, the weights of b and c h·e₂ and −h·e₁.
uint meet_by_pairs(vec3 d, vec3 o, vec3 a, vec3 b, vec3 c, float t_min, float limit, float reach, out Meeting m) {
    Pairs x = exact_sum(a, -o), e1 = exact_sum(b, -a), e2 = exact_sum(c, -a), line = Pairs(d, vec3(0.0));
    Pairs n = cross_of(e2, e1), h = cross_of(line, x);
    vec2 det = dot_of(line, n), depth = dot_of(x, n), v = dot_of(h, e2), w = -dot_of(h, e1);
    vec2 u = sum_of(det, -sum_of(v, w));

    vec3 n_size = outer_size(e2.hi, e1.hi), h_size = outer_size(d, x.hi);
    float det_size = inner_size(d, n_size), depth_size = inner_size(x.hi, n_size);
    precise float v_off = PAIR_DOUBT * inner_size(h_size, e2.hi) + PAIR_LEAST;
    precise float w_off = PAIR_DOUBT * inner_size(h_size, e1.hi) + PAIR_LEAST;
    precise float u_off = PAIR_DOUBT * det_size + (v_off + w_off);
    precise float det_least = PAIR_RIGHT * det_size + PAIR_LEAST, depth_least = PAIR_RIGHT * depth_size + PAIR_LEAST;
    float size = abs(det.x);
    if (!(reach < 1048576.0 && size > det_least)) return UNKNOWN;
    vec3 off = vec3(u_off, v_off, w_off), weights = det.x > 0.0 ? vec3(u.x, v.x, w.x) : -vec3(u.x, v.x, w.x);
    if (any(lessThan(weights, -off))) return PASSED_BY;
    vec3 tuv = quotients(Pairs(vec3(depth.x, v.x, w.x), vec3(depth.y, v.y, w.y)), det);
    precise float t_off = (PAIR_DOUBT * depth_size + PAIR_LEAST) / size + abs(tuv.x) * (8.0 / 16777216.0);
    precise float latest = tuv.x + t_off, earliest = tuv.x - t_off;
    if (latest < t_min || earliest > limit) return PASSED_BY;
    if (any(lessThan(weights, off)) || !(abs(depth.x) > depth_least)) return UNKNOWN;
    m = Meeting(tuv.x, 1.0, tuv.yz);
    return MET;
}

// The test in double-single precision and, where that can't tell, by integers: as if in exact arithmetic. t is less than an
// ulp off, however the triangle lies. Of those that are surely beyond `limit` nothing is met.
bool meet_in_doubt(Setup s, PackedTriangle t, float limit, out Meeting m) {
    if (!finite(s.reach)) return false;
    vec3 d = turned(s, s.direction), a = turned(s, t.a), b = turned(s, t.b), c = turned(s, t.c);
    uint known = meet_by_pairs(d, s.origin, a, b, c, s.t_min, limit, s.reach, m);
    if (known != UNKNOWN) return known == MET;
    vec2 weight[3], depth;
    ivec3 exponents = ivec3(0);
    int depth_exponent;
    float least = 0.0, most = 0.0;
    begin_digits();
    // The weights, each of the corner a; then t · det.
    for (int k = 0; k < 4; ++k) {
        depth = exact_triple(k < 3 ? d : a, s.origin, c, b, k == 3, depth_exponent);
        if (k == 3) break;
        least = min(least, depth.x);
        most = max(most, depth.x);
        if (least < 0.0 && most > 0.0) return false;
        weight[k] = depth;
        exponents[k] = depth_exponent;
        vec3 first = a;
        a = b;
        b = c;
        c = first;
    }
    if (least == most) return false;
    // The weights are of like signs: what a shift to the largest exponent loses, the largest outweighs.
    int exponent = max(exponents.x, max(exponents.y, exponents.z));
    vec2 det = vec2(0.0);
    for (int k = 0; k < 3; ++k) {
        int shift = exponents[k] - exponent;
        vec2 sum = exact_sum(det.x, scaled(weight[k].x, shift));
        det = vec2(sum.x, sum.y + (det.y + scaled(weight[k].y, shift)));
    }
    vec3 tuv = quotients(Pairs(vec3(depth.x, weight[1].x, weight[2].x), vec3(depth.y, weight[1].y, weight[2].y)), det);
    // Scaled last, so that no quotient is near what devices may take for 0.
    vec2 uv = vec2(scaled(tuv.y, exponents.y - exponent), scaled(tuv.z, exponents.z - exponent));
    m = Meeting(scaled(tuv.x, depth_exponent - exponent), 1.0, uv);
    return true;
}
#endif

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
    return !(lo < -doubt && hi > doubt) && meet_in_doubt(s, t, limit, m);
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
    m = Meeting(dot(e2, q) * sign_of, abs(det), vec2(u, v));
    return true;
}

// The nearest hit so far. Starts at t_max and INVALID.
struct Nearest {
    float t;
    uint triangle;
    vec2 uv;
};

// Of equal t the lower triangle index wins, so that neither the tree nor the order of traversal shows in the result.
// Returns whether an any-hit query is answered.
bool meet_triangle(Setup s, PackedTriangle triangle, inout Nearest nearest) {
    Meeting m;
    bool met = ROBUST != 0 ? meet_robust(s, triangle, nearest.t, m) : meet_fast(s, triangle, m);
    if (!met) return false;
    precise float over = 1.0 / m.det;
    precise float t = m.depth * over;
    // Of a determinant too small for its reciprocal t would be infinite, and no number of u and v.
    if (!(t >= s.t_min && t <= min(nearest.t, 3.4028235e38))) return false;
    if (ANY != 0) {
        nearest.triangle = 0;
        return true;
    }
    if (t == nearest.t && triangle.index >= nearest.triangle) return false;
    nearest.t = t;
    nearest.triangle = triangle.index;
    nearest.uv = m.uv * over;
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
