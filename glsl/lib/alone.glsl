// One invocation a ray, while-while [AILA09]. Wants descend(), lib/visit.glsl and what lib/ray.glsl wants; the buffers
// rays, hits, tests, steps.
void main() {
    uint ray = first_ray(1);
    if (ray >= args.count) return;
    ray = ray_at(ray);
    Setup s = prepare(LOAD_Ray(rays, ray));
    Nearest nearest = none_yet(s);
    Tests tests = Tests(0, 0, 0, 0);
    steps = Steps(0, 0, 0, 0);
    uint node = s.valid ? args.root : INVALID;
    while (node != INVALID) {
        while (node < LEAF_BIT) node = descend(node, s, nearest, tests);
        if (node == INVALID) break;
        node = meet_leaf(node, s, nearest, tests);
    }
    Hit hit = hit_of(s, nearest);
    STORE_Hit(hits, ray, hit)
    if (COUNT != 0) STORE_Tests(tests, ray, tests)
    if (STEPS != 0) STORE_Steps(steps, ray, steps)
}
