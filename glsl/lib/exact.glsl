// Signs of a·b − c·d that rounding can't change, from integer products of the mantissas: no float64, no fma.

struct Product {
    uint hi;        // 48 bits, the upper one set: |product| = (hi · 2³² + lo) · 2^exponent
    uint lo;
    int exponent;
    int sign;       // 0: the product is 0
};

Product product(float a, float b) {
    uvec2 bits = uvec2(floatBitsToUint(a), floatBitsToUint(b));
    uvec2 magnitude = bits & 0x7fffffffu;
    if (magnitude.x == 0u || magnitude.y == 0u) return Product(0u, 0u, 0, 0);
    int exponent = 0;
    uvec2 mantissa;
    for (int k = 0; k < 2; ++k) {
        uint e = magnitude[k] >> 23;
        uint m = magnitude[k] & 0x007fffffu;
        int shift = e == 0u ? 23 - findMSB(m) : 0;  // denormal
        mantissa[k] = e == 0u ? m << shift : m | 0x00800000u;
        exponent += int(max(e, 1u)) - shift;
    }
    Product p;
    umulExtended(mantissa.x, mantissa.y, p.hi, p.lo);
    if ((p.hi & 0x8000u) == 0u) {
        p.hi = p.hi << 1 | p.lo >> 31;
        p.lo <<= 1;
        --exponent;
    }
    p.exponent = exponent - 300;  // 2 · (127 + 23)
    p.sign = ((bits.x ^ bits.y) & 0x80000000u) != 0u ? -1 : 1;
    return p;
}

// a·b − c·d to a few ulp: 0 exactly where it is 0, else of the right sign.
float exact_difference(float a, float b, float c, float d) {
    Product p = product(a, b), q = product(c, d);
    if (p.sign != q.sign) {
        float rough = a * b - c * d;
        return rough != 0.0 ? rough : p.sign > q.sign ? 1.2e-38 : -1.2e-38;
    }
    if (p.sign == 0) return 0.0;
    bool less = p.exponent != q.exponent ? p.exponent < q.exponent : p.hi != q.hi ? p.hi < q.hi : p.lo < q.lo;
    Product big = less ? q : p, small = less ? p : q;
    if (big.exponent == small.exponent && big.hi == small.hi && big.lo == small.lo) return 0.0;
    // Aligned by a shift of at most 15 bits to the left; where more is needed the smaller one does not show.
    int shift = big.exponent - small.exponent;
    uint hi = big.hi, lo = big.lo;
    if (shift <= 15) {
        if (shift > 0) {
            hi = hi << shift | lo >> (32 - shift);
            lo <<= shift;
        }
        uint borrow;
        lo = usubBorrow(lo, small.lo, borrow);
        hi -= small.hi + borrow;
        shift = 0;
    }
    float magnitude = scaled(float(hi) * 4294967296.0 + float(lo), small.exponent + shift);
    magnitude = max(magnitude, 1.2e-38);
    return (p.sign > 0) != less ? magnitude : -magnitude;
}
