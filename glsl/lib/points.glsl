// Points of a set that are least and greatest along k / 2 directions [LARSSON11]: point 2j is the least along direction
// j, 2j + 1 the greatest. Wants the buffer points. Differs: of equal ones the first in the order of triangles counts.
layout(constant_id = SPEC_POINTS) const uint POINTS = 14;
const uint PAIRS = POINTS * 3 / 2;

const float A = 0.618033989;  // (√5 − 1) / 2
const float B = 1.618033989;
// Unscaled: only which point is least and greatest matters.
const vec3 N6[6] = vec3[](vec3(0, 1, A), vec3(0, 1, -A), vec3(1, A, 0), vec3(-1, A, 0), vec3(A, 0, 1), vec3(A, 0, -1));
const vec3 N10[10] = vec3[](vec3(0, A, B), vec3(0, A, -B), vec3(A, B, 0), vec3(A, -B, 0), vec3(B, 0, A), vec3(B, 0, -A),
                            vec3(1, 1, 1), vec3(1, 1, -1), vec3(1, -1, 1), vec3(1, -1, -1));
// The first 7 are N7.
const vec3 N13[13] = vec3[](vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1), vec3(1, 1, 1), vec3(1, 1, -1), vec3(1, -1, 1),
                            vec3(1, -1, -1), vec3(1, 1, 0), vec3(1, -1, 0), vec3(1, 0, 1), vec3(1, 0, -1),
                            vec3(0, 1, 1), vec3(0, 1, -1));

vec3 direction_of(uint j) { return POINTS == 12 ? N6[min(j, 5)] : POINTS == 20 ? N10[min(j, 9)] : N13[j]; }

#define LOAD_POINTS(e, slot)                                                                                          \
    [[unroll]] for (uint pair = 0; pair < POINTS / 2; ++pair) {                                                       \
        uint at = PAIRS * (slot) + 3 * pair;                                                                          \
        vec2 w0 = uintBitsToFloat(words_of(P(points).at[at])), w1 = uintBitsToFloat(words_of(P(points).at[at + 1]));  \
        vec2 w2 = uintBitsToFloat(words_of(P(points).at[at + 2]));                                                    \
        e[2 * pair] = vec3(w0, w1.x);                                                                                 \
        e[2 * pair + 1] = vec3(w1.y, w2);                                                                             \
    }

#define STORE_POINTS(e, slot)                                                                                         \
    [[unroll]] for (uint pair = 0; pair < POINTS / 2; ++pair) {                                                       \
        uint at = PAIRS * (slot) + 3 * pair;                                                                          \
        vec3 least = e[2 * pair], greatest = e[2 * pair + 1];                                                         \
        P(points).at[at] = pair_of(floatBitsToUint(least.xy));                                                        \
        P(points).at[at + 1] = pair_of(floatBitsToUint(vec2(least.z, greatest.x)));                                   \
        P(points).at[at + 2] = pair_of(floatBitsToUint(greatest.yz));                                                 \
    }

// Point i alone; wants the buffer coordinates, the same memory.
#define STORE_POINT(slot, i, p)                                                                                       \
    {                                                                                                                 \
        uint at = 3 * (POINTS * (slot) + (i));                                                                        \
        P(coordinates).at[at] = p.x;                                                                                  \
        P(coordinates).at[at + 1] = p.y;                                                                              \
        P(coordinates).at[at + 2] = p.z;                                                                              \
    }
