// One invocation ITEMS triangles of the packed tree: its corners in unit scale and its input index.
// Reads source, sequence.
#include "lib/triangle.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

void main() {
    FOR_ITEMS(i, args.count) {
        uint t = P(sequence).at[i];
        Corners corners = LOAD_CORNERS(source, t);
        PackedTriangle packed =
            PackedTriangle(corners.a * args.scale, corners.b * args.scale, corners.c * args.scale, t);
        STORE_PackedTriangle(triangles, i, packed)
    }
}
