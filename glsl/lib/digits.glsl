// x · ((p − o) × (q − o)) of single-precision vectors, exactly, by integers alone: whatever a device rounds
// and flushes. Wants lib/double_single.glsl.

// A sum of products of three floats as signed digits of base 2²⁴, the first of weight 2⁻⁴⁴⁷, that of three of the least
// floats. Of 24 products a digit is less than 2²⁹, so carries wait. The last product ends at bit 3 · 253 + 126 + 72.
const int DIGITS = 41;
const uint DIGIT_MASK = 0x00ffffffu;
int digits[DIGITS];     // all 0 but within exact_triple, once begun
ivec2 digits_used;      // first and last that may not be 0

void begin_digits() {
    for (int i = 0; i < DIGITS; ++i) digits[i] = 0;
}

// Adds x · y · z · 2^scale, or takes it away; `scale` from 0 to 126.
void add_product(float x, float y, float z, int scale, bool away) {
    uvec3 bits = uvec3(floatBitsToUint(x), floatBitsToUint(y), floatBitsToUint(z));
    uvec3 exponent = bits >> 23 & 0xffu;
    uvec3 mantissa = bits & 0x007fffffu | min(exponent, uvec3(1u)) << 23;
    if (mantissa.x == 0u || mantissa.y == 0u || mantissa.z == 0u) return;
    uint hi, lo;
    umulExtended(mantissa.x, mantissa.y, hi, lo);
    uint lower = lo & DIGIT_MASK, upper = hi << 8 | lo >> 24;
    umulExtended(lower, mantissa.z, hi, lo);
    uint first = lo & DIGIT_MASK, carry = hi << 8 | lo >> 24;
    umulExtended(upper, mantissa.z, hi, lo);
    uint second = (lo & DIGIT_MASK) + carry;
    uint third = (hi << 8 | lo >> 24) + (second >> 24);
    second &= DIGIT_MASK;

    exponent = max(exponent, uvec3(1u)) - 1u;
    uint place = exponent.x + exponent.y + exponent.z + uint(scale);
    int at = int(place / 24u), left = int(place % 24u), right = 24 - left;
    ivec4 shifted = ivec4(uvec4(first << left, second << left | first >> right, third << left | second >> right, third >> right)
        & DIGIT_MASK);
    if (away != ((bits.x ^ bits.y ^ bits.z) >> 31 != 0u)) shifted = -shifted;
    digits[at] += shifted.x;
    digits[at + 1] += shifted.y;
    digits[at + 2] += shifted.z;
    digits[at + 3] += shifted.w;
    digits_used = ivec2(min(digits_used.x, at), max(digits_used.y, at + 3));
}

// The digits' value · 2^−exponent, to a share of 2⁻⁴⁶, and 0 in their place. With carries they lie within ±2²³, so that the
// topmost has the sum's sign and outweighs the rest.
vec2 take_digits(out int exponent) {
    int first = 0, second = 0, third = 0, last = 0, before_last = 0, carry = 0;
    exponent = -1000;
    for (int i = digits_used.x; i <= min(digits_used.y + 1, DIGITS - 1); ++i) {
        int digit = digits[i] + carry;
        carry = (digit + 0x800000) >> 24;
        digit -= carry << 24;
        digits[i] = 0;
        if (digit != 0) {
            first = digit;
            second = last;
            third = before_last;
            exponent = 24 * (i - 1) - 447;
        }
        before_last = last;
        last = digit;
    }
    vec2 value = exact_sum(float(first) * 16777216.0, float(second));
    return vec2(value.x, value.y + float(third) / 16777216.0);
}

// The triple product · 2^−exponent, of an origin o · 2^scale; of a point x, with x − o in its place.
vec2 exact_triple(vec3 x, vec3 o, int scale, vec3 p, vec3 q, bool point, out int exponent) {
    digits_used = ivec2(DIGITS, 0);
    // x · (p × q) + x · (q × o) + x · (o × p), and of a point − o · (p × q).
    for (int k = 0; k < (point ? 24 : 18); ++k) {
        bool less = (k & 1) != 0;
        add_product(x.x, less ? p.z : p.y, less ? q.y : q.z, k < 6 ? 0 : scale, less != (k >= 18));
        if (!less) continue;
        x = x.yzx;
        o = o.yzx;
        p = p.yzx;
        q = q.yzx;
        if (k % 6 != 5) continue;
        vec3 first = p;
        p = q;
        q = o;
        o = first;
        if (k == 17) x = o;
    }
    return take_digits(exponent);
}
