// As trace/single, through a binary tree. Reads rays, aabbs, obbs, triangles.
#include "lib/binary.glsl"
#include "lib/alone.glsl"
