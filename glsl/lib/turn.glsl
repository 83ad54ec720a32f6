// Which ray an invocation takes. Wants args.{count, threads, order}.

layout(constant_id = SPEC_ORDERED) const uint ORDERED = 0;

// The first ray of this invocation, of `items` a workgroup apart. Software drivers hand each thread one run of
// workgroups; dealing them out in turn instead (args.threads > 1) evens out the threads' work.
uint first_ray(uint items) {
    uint group = group_index();
    if (args.threads > 1) {
        uint groups = (args.count + items * WG - 1) / (items * WG);
        uint share = (groups + args.threads - 1) / args.threads;
        group = (group % share) * args.threads + group / share;
    }
    return group * items * WG + gl_LocalInvocationID.x;
}

// Which ray the i-th is, where they are taken in an order of their own.
uint ray_at(uint i) { return ORDERED != 0 ? P(order).at[i] : i; }
