// Rays from DISTANT and beyond, to the robust test. Wants lib/digits.glsl, struct Setup and the struct Ray.
//
// A ray from 10⁷ aimed at a scene of 10⁻³⁷ starts 10⁴⁴ scene sizes away: in unit space its origin overflows, and direction
// components that a scale of powers of two takes to 0 move it by more than the scene. So origin and direction stay as they were
// given, and the origin has an exponent of its own, which the exact test by integers adds; no other could tell what such a ray
// meets. Its walk begins on a plane before the scene, at a point that is found by integers too: boxes are padded as for a
// ray from there, so that none is met for the distance alone. All of the scene is at one t, to the floats: a ray that has
// that out of its range is done, and another has no limit to its walk.

// Takes the ray's own numbers; returns its origin · 2^−scale. Of t a fourth is taken, which can't overflow.
vec3 take_far(inout Setup s, Ray ray, vec3 o) {
    s.line = ray.direction;
    s.t_exponent += scale_of(s) + 2;
    return scale_of(s) > 0 ? ray.origin : o;
}

// Where the walk begins, moved: on the plane of the largest component, 2 before the anchor, so that the scene, within 1 of
// that, is ahead. What is rounded of `off` (a sum and a quotient, 6 u) is of lengths of R at most, as R has 2 added, what is of
// the way back (a quotient and a product, 6 u) of R / 2: with their sum it is 10 u R.
vec3 approached_from_far(inout Setup s, vec3 o, int exponent) {
    uint z = s.axes.z;
    float t = 0.0;
    vec3 off = vec3(0.0);
    begin_digits();
    for (uint k = 0; k < 3; ++k) {
        // Of the line, where it crosses the anchor's plane: ((o − anchor)_k d_z − (o − anchor)_z d_k) / d_z; for t, without the
        // latter.
        digits_used = ivec2(DIGITS, 0);
        for (uint i = 0; i < (k == z ? 2u : 4u); ++i) {
            bool of_anchor = (i & 1u) != 0u, latter = i >= 2u;
            uint from = latter ? z : k, along = latter ? k : z;
            add_product(of_anchor ? args.anchor[from] : o[from], s.line[along], 1.0, of_anchor ? 0 : scale_of(s), of_anchor != latter);
        }
        int place;
        vec2 sum = take_digits(place);
        precise float quotient = (sum.x + sum.y) / s.direction[z];
        precise float along_ray = quotient / s.direction[z];
        // Of what is far aside all that counts is that it is.
        if (k == z) t = -scaled(along_ray, place - 2 * exponent + shift_of(s));
        else off[k] = scaled(quotient, min(place - exponent, 60));
    }
    // Along the ray the scene is less than t · 2⁻²⁸ long.
    precise float slack = abs(t) * (1.0 / 1048576.0);
    bool aside = max(abs(off.x), max(abs(off.y), abs(off.z))) > 4.0;
    s.valid = s.valid && !(aside || t + slack < s.t_min || t - slack > s.t_max);
    precise vec3 begin = off - s.direction * (2.0 / abs(s.direction[z]));
    s.begin = 0.0;
    s.walk_reach = args.reach + max(abs(begin.x), max(abs(begin.y), abs(begin.z))) + 2.0;
    return begin;
}
