// One invocation ITEMS triangles of the packed tree: its corners in unit scale and its input index.
// Reads source, sequence.
#include "lib/triangle.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

// p · scale; what would be denormal is 0, as it is on some devices.
vec3 unit_scale(vec3 p) {
    vec3 q = p * args.scale;
    return mix(q, uintBitsToFloat(floatBitsToUint(q) & 0x80000000u), lessThan(abs(q), vec3(1.17549435e-38)));
}

void main() {
    FOR_ITEMS(i, args.count) {
        uint t = P(sequence).at[i];
        Corners corners = LOAD_CORNERS(source, t);
        PackedTriangle packed =
            PackedTriangle(unit_scale(corners.a), unit_scale(corners.b), unit_scale(corners.c), t);
        STORE_PackedTriangle(triangles, i, packed)
    }
}
