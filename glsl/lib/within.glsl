// Extents of points in frames, to the same bits everywhere. Wants lib/box.glsl.
#include "lib/frame.glsl"

float along(vec3 axis, vec3 p) {
    precise vec3 product = axis * p;
    precise float sum = product.x + product.y + product.z;
    return sum;
}

vec3 within(Frame frame, vec3 p) { return vec3(along(frame.x, p), along(frame.y, p), along(frame.z, p)); }

const Aabb NOWHERE = Aabb(vec3(3.4028235e38), vec3(-3.4028235e38));

void take_in(inout Aabb box, vec3 p) { box = Aabb(least_of(box.lo, p), greatest_of(box.hi, p)); }
