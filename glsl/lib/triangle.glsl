// Triangles as the scene holds them: nine floats.
bool finite(float x) { return (floatBitsToUint(x) & 0x7f800000u) != 0x7f800000u; }
bool finite(vec3 p) { return finite(p.x) && finite(p.y) && finite(p.z); }

#define CORNER(buffer, triangle, corner)                                                                              \
    vec3(P(buffer).at[9u * (triangle) + 3u * (corner)], P(buffer).at[9u * (triangle) + 3u * (corner) + 1u],           \
         P(buffer).at[9u * (triangle) + 3u * (corner) + 2u])

// False where no ray can hit: a corner is not finite, or two corners coincide. Collinear corners stay: in rounded
// projections such a sliver closes the gap between its neighbours.
bool hittable(vec3 a, vec3 b, vec3 c) {
    return finite(a) && finite(b) && finite(c) && a != b && b != c && c != a;
}
