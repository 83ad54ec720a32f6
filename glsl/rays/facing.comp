// One invocation a candidate: sums[workgroup] is how many of them are rays. Reads surfaces, points, taken, lights.
#include "rays/light.glsl"

void main() {
    Ray ray;
    uint total;
    row_scan(ray_to_light(candidate(), ray), total);
    // A grid of two dimensions has workgroups beyond the last: sums has no room for theirs.
    if (lane() == 0 && group_index() < args.groups) P(sums).at[group_index()] = total;
}
