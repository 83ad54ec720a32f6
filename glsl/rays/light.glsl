// Rays from surfaces to lights. Wants args.{samples, limit, t_max}, surfaces, points, taken, lights.
#include "rays/points.glsl"
#include "lib/scan.glsl"

// Ray i of those that there would be if every surface faced every light, its direction from the surface to a point of
// its light: sample s goes to light s mod LIGHTS. False behind the last surface, and where that point lies in or behind
// the triangle's plane.
bool ray_to_light(uint i, out Ray ray) {
    uint which = i / args.samples;
    if (which >= min(P(taken).at[0], args.limit)) return false;
    uint sample_index = i - which * args.samples;
    Surface surface = LOAD_Surface(surfaces, which);
    vec4 light = P(lights).at[sample_index % LIGHTS];
    uvec2 uv = point_of(sample_index / LIGHTS, surface.primary);
    // The heights of a sphere's points are uniform: z = 1 − 2u, r = 2 √(u (1 − u)).
    float u = float(uv.x) * (1.0 / 16777216.0);
    float w = float(16777216u - uv.x) * (1.0 / 16777216.0);
    precise float square = u * w;
    precise float r = 2.0 * root(square);
    precise vec3 point = vec3(turned(uv.y) * r, w - u);
    precise vec3 direction = light.xyz + point * light.w - surface.origin;
    ray = Ray(surface.origin, 0.0, direction, args.t_max);
    return inner(surface.normal, levelled(direction)) > 0.0;
}

// The candidate of this invocation, in row_scan's order.
uint candidate() { return group_index() * WG + lane(); }
