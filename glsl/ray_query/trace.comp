// One invocation a ray: what the driver's own traversal of its own structure meets first, or with ANY whether there is
// anything. Reads rays, order, triangles.
// Differs from trace/*: what is a hit is the driver's to say, and Vulkan has no t below 0: such rays begin at 0.
#extension GL_EXT_ray_query : require
#include "lib/finite.glsl"
#include "lib/turn.glsl"

layout(constant_id = SPEC_ANY) const uint ANY = 0;

// What Vulkan lets a query begin with, and a direction to go.
bool valid(Ray ray) {
    return finite(ray.origin) && finite(ray.direction) && ray.direction != vec3(0.0) && max(ray.t_min, 0.0) <= ray.t_max;
}

void main() {
    uint ray_index = first_ray(1);
    if (ray_index >= args.count) return;
    ray_index = ray_at(ray_index);
    Ray ray = LOAD_Ray(rays, ray_index);
    Hit hit = Hit(uintBitsToFloat(0x7f800000u), INVALID, 0.0, 0.0);
    if (valid(ray)) {
        uint flags = gl_RayFlagsOpaqueEXT | (ANY != 0 ? gl_RayFlagsTerminateOnFirstHitEXT : 0u);
        rayQueryEXT query;
        rayQueryInitializeEXT(query, accelerationStructureEXT(args.structure), flags, 0xffu, ray.origin,
                              max(ray.t_min, 0.0), ray.direction, ray.t_max);
        while (rayQueryProceedEXT(query)) {}
        if (rayQueryGetIntersectionTypeEXT(query, true) == gl_RayQueryCommittedIntersectionTriangleEXT) {
            if (ANY != 0) {
                hit.t = 0.0;
            } else {
                uint met = uint(rayQueryGetIntersectionPrimitiveIndexEXT(query, true));
                vec2 uv = rayQueryGetIntersectionBarycentricsEXT(query, true);
                bool listed = uvec2(args.triangles) != uvec2(0u);
                hit = Hit(rayQueryGetIntersectionTEXT(query, true), listed ? P(triangles).at[met] : met, uv.x, uv.y);
            }
        }
    }
    STORE_Hit(hits, ray_index, hit)
}
