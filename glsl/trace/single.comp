// One invocation a ray: its nearest hit, or with ANY whether there is one. Reads rays, nodes, triangles.
// While-while [AILA09], nearer child first.
#include "lib/walk.glsl"
#include "lib/alone.glsl"
