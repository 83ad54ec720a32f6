// How full subgroups are as their invocations walk. A step is a node, or a triangle, that a subgroup goes through at once,
// for as many rays as are active there. Each ray counts what it has part in, and one of them the step itself: sums over
// all rays need no atomics, and hold however a subgroup's invocations part and meet.
layout(constant_id = SPEC_STEPS) const uint STEPS = 0;

Steps steps;

// `part`: whether this invocation's ray has part in it.
void count_node(bool part) {
    if (part) steps.nodes += 1;
    if (subgroupElect()) steps.node_steps += 1;
}

void count_triangle(bool part) {
    if (part) steps.triangles += 1;
    if (subgroupElect()) steps.triangle_steps += 1;
}
