// Pairs of clusters and the key that orders them: the half area of their common box, its low bits replaced by the
// pair's colour. No two pairs that share a cluster have the same colour, so the pair of globally least key is the
// least of both its clusters: every round merges something, and 4096 coincident triangles take 12 rounds.
// Differs from [PLOC18]: areas are rounded to 2⁻¹⁸ at radius 16 (2⁻¹⁵ at 128); a colour breaks ties, not an index.
#include "lib/box.glsl"

layout(constant_id = SPEC_RADIUS) const uint RADIUS = 8;

const uint COLOUR_BITS = RADIUS <= 1 ? 1 : RADIUS <= 2 ? 2 : RADIUS <= 4 ? 3 : RADIUS <= 8 ? 4 : RADIUS <= 16 ? 5
                       : RADIUS <= 32 ? 6 : RADIUS <= 64 ? 7 : 8;
const uint COLOUR_MASK = (1u << COLOUR_BITS) - 1u;

// Key of the pair (i, i + distance). The colour is 2 (distance − 1) and one bit that tells (i, i + distance) from
// (i − distance, i): the bit of i at distance's lowest set bit.
uint pair_key(Aabb a, Aabb b, uint i, uint distance) {
    uint colour = (distance - 1) * 2 | ((i >> findLSB(distance)) & 1u);
    return (floatBitsToUint(half_area(merged(a, b))) & ~COLOUR_MASK) | colour;
}

// The other cluster of the pair that cluster i holds least.
uint partner_of(uint i, uint key) {
    uint colour = key & COLOUR_MASK;
    uint distance = (colour >> 1) + 1;
    return ((i >> findLSB(distance)) & 1u) == (colour & 1u) ? i + distance : i - distance;
}

// A cluster beyond the ends: farther than any real one, near enough for a finite area.
const Aabb FAR = Aabb(vec3(-1e18), vec3(1e18));
