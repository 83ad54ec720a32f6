// Points of the unit square in 24-bit fixed point, turned (Cranley–Patterson) by two hashes of the primary's index, and
// what makes directions of them. Wants the buffer points.
#include "rays/root.glsl"

// [Wellons18] lowbias32.
uint hash(uint x) {
    x = (x ^ x >> 16) * 0x7feb352du;
    x = (x ^ x >> 15) * 0x846ca68bu;
    return x ^ x >> 16;
}

float root(float x) {
    precise float y = x * inverse_root(x);
    return y;
}

// Cosine and sine of 2π · turn / 2²⁴, within 2⁻²²: the nearest quarter turn, and Taylor's polynomials within π/4.
vec2 turned(uint turn) {
    uint from = turn + 0x200000u;
    precise float x = float(int(from & 0x3fffffu) - 0x200000) * 3.7450702829239286e-7;
    precise float q = x * x;
    precise float s = x + x * q * (-0.16666667 + q * (0.0083333333 + q * (-0.00019841270 + q * 2.7557319e-6)));
    precise float c = 1.0 - q * (0.5 - q * (0.041666667 - q * (0.0013888889 - q * 0.000024801587)));
    uint quarter = from >> 22 & 3u;
    vec2 t = (quarter & 1u) != 0u ? vec2(-s, c) : vec2(c, s);
    return (quarter & 2u) != 0u ? -t : t;
}

// Point `i` as primary `primary` has it.
uvec2 point_of(uint i, uint primary) {
    uvec2 turn = uvec2(hash(2 * primary), hash(2 * primary + 1)) >> 8;
    return words_of(P(points).at[i]) + turn & 0xffffffu;
}
