// Sum of floats over the invocations of a workgroup, in one order. All invocations must call it.
shared vec2 sum_shared[WG];

vec2 workgroup_sum(vec2 x) {
    uint me = gl_LocalInvocationID.x;
    sum_shared[me] = x;
    barrier();
    for (uint count = WG; count > 1;) {
        uint upper = (count + 1) / 2;
        if (me + upper < count) sum_shared[me] += sum_shared[me + upper];
        barrier();
        count = upper;
    }
    return sum_shared[0];
}
