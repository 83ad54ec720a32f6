// Ray against triangle in double-single precision, for devices without doubles. Wants lib/double_single.glsl, struct
// Meeting and what is known of one.

// A triple product of double-single vectors is off by 28 u² = 2⁻⁴³ of its products' sizes, these by 2⁻²²: what is larger than
// twice that has its sign, and what is 2⁻¹⁵ of them is right to an eighth of an ulp. Of numbers below 2⁻⁶⁰, for as long as no
// coordinate is above 2²⁰, what underflowed might count.
const float PAIR_DOUBT = 1.0 / 4398046511104.0;
const float PAIR_RIGHT = 1.0 / 32768.0;
const float PAIR_LEAST = 1.0 / 1152921504606846976.0;

// Whether d · (c − a) × (b − a) has no term but 0, as where a triangle and a line lie in one plane along two axes.
bool surely_zero(vec3 d, vec3 a, vec3 b, vec3 c) {
    bvec3 b_as_a = equal(b, a), c_as_a = equal(c, a);
    bool x = (c_as_a.y || b_as_a.z) && (c_as_a.z || b_as_a.y);
    bool y = (c_as_a.z || b_as_a.x) && (c_as_a.x || b_as_a.z);
    bool z = (c_as_a.x || b_as_a.y) && (c_as_a.y || b_as_a.x);
    return (d.x == 0.0 || x) && (d.y == 0.0 || y) && (d.z == 0.0 || z);
}

// Whether the triangle is met, at a t that is not surely out of the range up to `limit`. With x the corner a less the
// origin, n = e₂ × e₁ and h = d × x: det = d·n, t det = x·n, the weights of b and c h·e₂ and −h·e₁.
uint meet_by_pairs(vec3 d, vec3 o, vec3 a, vec3 b, vec3 c, float t_min, float limit, out Meeting m) {
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
    if (!(size > det_least)) return surely_zero(d, a, b, c) ? PASSED_BY : UNKNOWN;
    vec3 off = vec3(u_off, v_off, w_off), weights = det.x > 0.0 ? vec3(u.x, v.x, w.x) : -vec3(u.x, v.x, w.x);
    if (any(lessThan(weights, -off))) return PASSED_BY;
    vec3 tuv = quotients(Pairs(vec3(depth.x, v.x, w.x), vec3(depth.y, v.y, w.y)), det);
    precise float t_off = (PAIR_DOUBT * depth_size + PAIR_LEAST) / size + abs(tuv.x) * (8.0 / 16777216.0);
    precise float latest = tuv.x + t_off, earliest = tuv.x - t_off;
    if (latest < t_min || earliest > limit) return PASSED_BY;
    if (any(lessThan(weights, off)) || !(abs(depth.x) > depth_least)) return UNKNOWN;
    m = Meeting(tuv.x, tuv.yz);
    return MET;
}
