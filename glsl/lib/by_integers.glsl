// Ray against triangle by integers: as if in exact arithmetic. Wants lib/digits.glsl and struct Meeting.

// Whether the triangle is met; of the range from t_min to t_max only sides of 0 count, which t that is 0 to the floats alone
// no longer tells: it may be before a range that begins at 0, or after one that ends there. The origin is o · 2^scale; t comes
// as · 2^shift.
bool meet_by_integers(vec3 d, vec3 o, int scale, int shift, vec3 a, vec3 b, vec3 c, float t_min, float t_max, out Meeting m) {
    if (a == b || b == c || c == a) return false;
    vec2 weight[3], depth;
    ivec3 exponents = ivec3(0);
    int depth_exponent;
    float least = 0.0, most = 0.0;
    begin_digits();
    // The weights, each of the corner a; then t · det.
    for (int k = 0; k < 4; ++k) {
        depth = exact_triple(k < 3 ? d : a, o, scale, c, b, k == 3, depth_exponent);
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
        int less = exponents[k] - exponent;
        vec2 sum = exact_sum(det.x, scaled(weight[k].x, less));
        det = vec2(sum.x, sum.y + (det.y + scaled(weight[k].y, less)));
    }
    vec3 tuv = quotients(Pairs(vec3(depth.x, weight[1].x, weight[2].x), vec3(depth.y, weight[1].y, weight[2].y)), det);
    // Scaled last, so that no quotient is near what devices may take for 0.
    vec2 uv = vec2(scaled(tuv.y, exponents.y - exponent), scaled(tuv.z, exponents.z - exponent));
    float t = scaled(tuv.x, depth_exponent - exponent + shift);
    m = Meeting(t, uv);
    return t != 0.0 || !(tuv.x < 0.0 && t_min >= 0.0 || tuv.x > 0.0 && t_max <= 0.0);
}
