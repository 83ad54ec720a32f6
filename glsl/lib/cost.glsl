// What a ray that meets a child is expected to cost there. Wants lib/frame.glsl, args.{node_cost, triangle_cost}.
#include "lib/reciprocal.glsl"

float cost_of_visit(uint child, uint triangles) {
    return child < LEAF_BIT ? args.node_cost : args.triangle_cost * float(triangles);
}

// An area in the frame of Rodrigues vector r as it is in unit space.
float unstretched(float area, vec3 r) {
    float over = reciprocal(stretch_of(r));
    precise float unscaled = area * over * over;
    return unscaled;
}
