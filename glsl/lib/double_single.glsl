// Numbers of two floats, hi + lo, hi the float nearest to the sum or the next [DEKKER71]. With u = 2⁻²⁴, a sum is off by
// 4 u² (|a| + |b|) and a product by 8 u² |a b| at most, as long as nothing underflows.

vec2 exact_sum(float a, float b) {
    precise float sum = a + b;
    precise float share = sum - a;
    precise float lost = (a - (sum - share)) + (b - share);
    return vec2(sum, lost);
}

vec2 sum_of(vec2 a, vec2 b) {
    vec2 s = exact_sum(a.x, b.x);
    precise float lo = s.y + (a.y + b.y);
    precise float hi = s.x + lo;
    precise float rest = lo - (hi - s.x);
    return vec2(hi, rest);
}

// Three of them.
struct Pairs {
    vec3 hi;
    vec3 lo;
};

Pairs exact_sum(vec3 a, vec3 b) {
    precise vec3 sum = a + b;
    precise vec3 share = sum - a;
    precise vec3 lost = (a - (sum - share)) + (b - share);
    return Pairs(sum, lost);
}

Pairs exact_product(vec3 a, vec3 b) {
    precise vec3 wide_a = a * 4097.0, wide_b = b * 4097.0;
    precise vec3 upper_a = wide_a - (wide_a - a), upper_b = wide_b - (wide_b - b);
    precise vec3 lower_a = a - upper_a, lower_b = b - upper_b;
    precise vec3 hi = a * b;
    precise vec3 lo = ((upper_a * upper_b - hi) + upper_a * lower_b + lower_a * upper_b) + lower_a * lower_b;
    return Pairs(hi, lo);
}

Pairs normalized(vec3 a, vec3 b) {
    precise vec3 hi = a + b;
    precise vec3 lo = b - (hi - a);
    return Pairs(hi, lo);
}

Pairs sum_of(Pairs a, Pairs b) {
    Pairs s = exact_sum(a.hi, b.hi);
    precise vec3 lo = s.lo + (a.lo + b.lo);
    return normalized(s.hi, lo);
}

Pairs product_of(Pairs a, Pairs b) {
    Pairs p = exact_product(a.hi, b.hi);
    precise vec3 lo = p.lo + (a.hi * b.lo + a.lo * b.hi);
    return normalized(p.hi, lo);
}

Pairs turned(Pairs v) { return Pairs(v.hi.yzx, v.lo.yzx); }

Pairs cross_of(Pairs a, Pairs b) {
    Pairs less = product_of(turned(turned(a)), turned(b));
    return sum_of(product_of(turned(a), turned(turned(b))), Pairs(-less.hi, -less.lo));
}

vec2 dot_of(Pairs a, Pairs b) {
    Pairs p = product_of(a, b);
    return sum_of(sum_of(vec2(p.hi.x, p.lo.x), vec2(p.hi.y, p.lo.y)), vec2(p.hi.z, p.lo.z));
}

// a / b, less than an ulp off: of the quotients of the upper parts, what they leave is divided again.
vec3 quotients(Pairs a, vec2 b) {
    precise vec3 rough = a.hi / b.x;
    Pairs back = exact_product(rough, vec3(b.x));
    precise vec3 rest = (a.hi - back.hi) - back.lo + (a.lo - rough * b.y);
    precise vec3 value = rough + rest / b.x;
    return value;
}

// |a| ⊗ |b|: a cross product with sums in place of differences.
vec3 outer_size(vec3 a, vec3 b) {
    precise vec3 x = abs(a), y = abs(b);
    precise vec3 size = x.yzx * y.zxy + x.zxy * y.yzx;
    return size;
}

float inner_size(vec3 a, vec3 b) {
    precise vec3 products = abs(a) * abs(b);
    precise float size = products.x + (products.y + products.z);
    return size;
}
