// d · ((p − o) × (q − o)) of single-precision vectors, in double precision and with the sign of exact arithmetic.

// Doubles that add up to each of the 18 products of three floats, two a product.
const int TERMS = 36;

// The same, from the exact sum of d · (p × q) + d · (q × o) + d · (o × p). A product of two floats is a double; its upper
// 24 bits and the rest times a third are two. They are added to a sum whose parts share no binary place, smallest first
// [SHEWCHUK97]; from the largest down, what adding rounds away is less than all that is left.
double exact_triple(dvec3 d, dvec3 o, dvec3 p, dvec3 q) {
    double parts[TERMS];
    int count = 0;
    for (int i = 0; i < TERMS; ++i) {
        bool less = (i & 1) != 0;
        precise double product = less ? p.z * q.y : p.y * q.z;
        precise double wide = product * 536870913.0LF;  // 2²⁹ + 1 [DEKKER71]
        precise double upper = wide - (wide - product);
        precise double term = ((i & 2) != 0 ? upper : product - upper) * (less ? -d.x : d.x);  // of 48 bits: exact
        int kept = 0;
        for (int k = 0; k < count; ++k) {
            double part = parts[k];
            precise double sum = term + part;
            precise double share = sum - term;
            precise double lost = (term - (sum - share)) + (part - share);
            if (lost != 0.0) parts[kept++] = lost;
            term = sum;
        }
        if (term != 0.0) parts[kept++] = term;
        count = kept;
        if ((i & 3) == 3) {
            d = d.yzx;
            o = o.yzx;
            p = p.yzx;
            q = q.yzx;
        }
        if (i % 12 == 11) {
            dvec3 first = p;
            p = q;
            q = o;
            o = first;
        }
    }
    precise double value = 0.0;
    for (int k = count - 1; k >= 0; --k) value += parts[k];
    return value;
}

// With x = p − o and e = q − p, which is short where the origin is far, d · (x × e): seven roundings of 2⁻⁵³ of its six
// products, less than 2⁻⁵⁰ of their sizes. It is sure beyond 2⁻⁴⁰ of them: its sign is right, and the value off by a share
// of 2⁻¹⁰ at most.
double triple(dvec3 d, dvec3 o, dvec3 p, dvec3 q, out bool sure) {
    precise dvec3 x = p - o, e = q - p;
    precise dvec3 m = x.yzx * e.zxy, n = x.zxy * e.yzx;
    precise dvec3 cross_product = m - n;
    precise double sum = d.x * cross_product.x + (d.y * cross_product.y + d.z * cross_product.z);
    dvec3 size = abs(d) * (abs(m) + abs(n));
    sure = abs(sum) > 9.094947017729282e-13LF * (size.x + size.y + size.z);
    return sum;
}
