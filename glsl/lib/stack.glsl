// Children still to visit, each with the key that sorted it (see lib/node.glsl). A level adds WIDTH − 1 of them at
// most, and STACK is no less than that times the tree's levels.
layout(constant_id = SPEC_STACK) const uint STACK = 64;

PAIR stack[STACK];
uint top = 0;

// All that were met but the nearest, which is returned; INVALID where none was met.
uint push_farther(Node n, ivec4 keys) {
    if (keys.w < MISSED) stack[top++] = pair_of(uvec2(keys.w, child_of(n, keys.w)));
    if (keys.z < MISSED) stack[top++] = pair_of(uvec2(keys.z, child_of(n, keys.z)));
    if (keys.y < MISSED) stack[top++] = pair_of(uvec2(keys.y, child_of(n, keys.y)));
    return keys.x < MISSED ? child_of(n, keys.x) : INVALID;
}

// t where a child is entered, or a little less.
float entered(int key) { return intBitsToFloat(key < 0 ? key | 3 : key & ~3); }
