// Triangles as the scene holds them: nine floats.
#include "lib/finite.glsl"

struct Corners {
    vec3 a;
    vec3 b;
    vec3 c;
};

// Nine words that start at an even or odd word of five pairs.
Corners corners_of(bool odd, PAIR p0, PAIR p1, PAIR p2, PAIR p3, PAIR p4) {
    vec2 w0 = uintBitsToFloat(words_of(p0)), w1 = uintBitsToFloat(words_of(p1)), w2 = uintBitsToFloat(words_of(p2));
    vec2 w3 = uintBitsToFloat(words_of(p3)), w4 = uintBitsToFloat(words_of(p4));
    return odd ? Corners(vec3(w0.y, w1), vec3(w2, w3.x), vec3(w3.y, w4))
               : Corners(vec3(w0, w1.x), vec3(w1.y, w2), vec3(w3, w4.x));
}

#define LOAD_CORNERS(b, t)                                                                                            \
    corners_of(((t) & 1u) != 0u, P(b).at[9u * (t) / 2u], P(b).at[9u * (t) / 2u + 1u], P(b).at[9u * (t) / 2u + 2u],     \
               P(b).at[9u * (t) / 2u + 3u], P(b).at[9u * (t) / 2u + 4u])

// False where no ray can hit: a corner is not finite, or two corners coincide. Collinear corners stay: in rounded
// projections such a sliver closes the gap between its neighbours.
bool hittable(Corners t) {
    return finite(t.a) && finite(t.b) && finite(t.c) && t.a != t.b && t.b != t.c && t.c != t.a;
}
