// One invocation a candidate: the rays to lights, without gaps and in order. Reads surfaces, points, taken, lights, sums
// (scanned).
#include "rays/light.glsl"

void main() {
    Ray ray;
    uint total;
    bool wanted = ray_to_light(candidate(), ray);
    uint place = row_scan(wanted, total);
    if (wanted) STORE_Ray(rays, P(sums).at[group_index()] + place, ray)
}
