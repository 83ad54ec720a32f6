// A packed node's own grid: 256 planes an axis, a power of two apart, the first at the least corner of the node's box
// [YLITIE17]. Planes are chosen outward; that their distances from the corner are rounded once moves none by more than
// 2⁻¹⁷ of a step, below 2⁻²⁴ of the node (see PAD in lib/ray.glsl).

// Biased exponent of the least step of a grid from lo to hi. Steps below 2⁻¹⁰⁰ gain nothing, and their inverses would
// overflow.
uint step_exponent(float lo, float hi) {
    precise float extent = hi - lo;
    uint exponent = max(floatBitsToUint(extent) >> 23, 34u) - 7u;  // 128 to 256 steps
    return exponent + uint(ceil(extent * uintBitsToFloat((254u - exponent) << 23)) > 255.0);
}

uvec3 step_exponents(Aabb box) {
    return uvec3(step_exponent(box.lo.x, box.hi.x), step_exponent(box.lo.y, box.hi.y),
                 step_exponent(box.lo.z, box.hi.z));
}

// Steps an axis of unit length.
vec3 steps_of(uvec3 exponents) { return uintBitsToFloat((254u - exponents) << 23); }

uvec3 least_planes(vec3 lo, vec3 origin, vec3 steps) {
    precise vec3 distance = (lo - origin) * steps;
    return uvec3(floor(distance));
}

uvec3 greatest_planes(vec3 hi, vec3 origin, vec3 steps) {
    precise vec3 distance = (hi - origin) * steps;
    return uvec3(ceil(distance));
}
