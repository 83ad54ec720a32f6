#include "lib/finite.glsl"
#include "rays/root.glsl"

// Whether a ray has a key: those that the tracer refuses have none, nor have those whose direction is denormal, for
// devices may take that as 0.
bool orderable(Ray ray) {
    return finite(ray.origin) && finite(ray.direction) && !is_nan(ray.t_min) && !is_nan(ray.t_max)
           && floatBitsToUint(largest(ray.direction)) >= 0x00800000u;
}

// 0 for denormal numbers: devices may take them as that.
vec3 settled(vec3 p) { return mix(p, vec3(0.0), lessThan(floatBitsToUint(p) & 0x7fffffffu, uvec3(0x00800000u))); }
