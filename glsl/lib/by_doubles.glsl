// Ray against triangle in double precision. Wants struct Meeting and what is known of one.

// A triple product is off by seven roundings of 2⁻⁵³ of its products' sizes: what is 2⁻²⁰ of them is right to a share of 2⁻³⁰.
// With the sums of components X of x and E of e₁ and e₂, and no component of the direction above 2, those are less than 2 X E
// of a weight, E² / 2 of the determinant: of weights beyond 2⁻⁴⁶ E (X + E) signs are right.
const double DOUBLE_RIGHT = 1.0LF / 1048576.0LF;
const double DOUBLE_DOUBT = 1.0LF / 70368744177664.0LF;
// 2⁻¹²⁶.
const double LEAST_NORMAL = 1.0LF / 85070591730234615865843651857942052864.0LF;

double dot_of(dvec3 a, dvec3 b) {
    precise double sum = a.x * b.x + (a.y * b.y + a.z * b.z);
    return sum;
}

double sum_of(dvec3 a) { return a.x + (a.y + a.z); }

// Whether the triangle is met, at a t that is not surely out of the range from t_min to `latest`. With x the corner a less the
// origin, n = e₂ × e₁ and h = d × x: det = d·n, t det = x·n, the weights of b and c h·e₂ and −h·e₁.
uint meet_by_doubles(vec3 d, vec3 o, vec3 a, vec3 b, vec3 c, float t_min, double latest, out Meeting m) {
    dvec3 corner = dvec3(a), line = dvec3(d);
    precise dvec3 x = corner - dvec3(o), e1 = dvec3(b) - corner, e2 = dvec3(c) - corner;
    precise dvec3 n_more = e2.yzx * e1.zxy, n_less = e2.zxy * e1.yzx, n = n_more - n_less;
    precise dvec3 h = line.yzx * x.zxy - line.zxy * x.yzx;
    double det = dot_of(line, n), depth = dot_of(x, n), v = dot_of(h, e2), w = -dot_of(h, e1);
    precise double u = det - (v + w);

    precise dvec3 n_size = abs(n_more) + abs(n_less), x_size = abs(x);
    double det_size = dot_of(abs(line), n_size), e_sum = sum_of(abs(e1) + abs(e2));
    precise double off = (DOUBLE_DOUBT * e_sum) * (sum_of(x_size) + e_sum);
    double least = v < w ? v : w, most = v < w ? w : v;
    least = u < least ? u : least;
    most = u > most ? u : most;
    bool det_right = abs(det) > DOUBLE_RIGHT * det_size;
    precise double over = 1.0LF / det, t = depth * over, t_size = dot_of(x_size, n_size) * abs(over);
    precise double t_off = DOUBLE_DOUBT * t_size + abs(t) * (8.0LF / 16777216.0LF);
    precise dvec2 uv = dvec2(v, w) * over;
    m = Meeting(float(t), vec2(uv));
    // One value: branches are dear where lanes go different ways. Where the determinant has no part but 0, it is 0.
    return least < -off && most > off || det_right && (t + t_off < t_min || t - t_off > latest) || det_size == 0.0LF ? PASSED_BY
        : det_right && (least > off || most < -off) && abs(t) > DOUBLE_RIGHT * t_size ? MET
        : UNKNOWN;
}
