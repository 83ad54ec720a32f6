#include "lib/finite.glsl"
#include "rays/root.glsl"

// Whether a ray has a key: those that the tracer refuses have none, nor have those whose direction is denormal, for
// devices may take that as 0.
bool orderable(Ray ray) {
    return finite(ray.origin) && finite(ray.direction) && !is_nan(ray.t_min) && !is_nan(ray.t_max)
           && floatBitsToUint(largest(ray.direction)) >= 0x00800000u;
}
