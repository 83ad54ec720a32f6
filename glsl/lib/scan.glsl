// Sum over the invocations of a workgroup before this one, and over all. Shared memory only: holds for any subgroup
// size and any mapping of invocations to subgroups. All invocations must call it.
shared uint scan_shared[2 * WG];

uint workgroup_scan(uint x, out uint total) {
    uint me = gl_LocalInvocationID.x;
    uint from = 0;
    barrier();  // an earlier call's readers are done
    scan_shared[me] = x;
    barrier();
    for (uint step = 1; step < WG; step *= 2) {
        uint to = WG - from;
        uint sum = scan_shared[from + me];
        if (me >= step) sum += scan_shared[from + me - step];
        scan_shared[to + me] = sum;
        from = to;
        barrier();
    }
    total = scan_shared[from + WG - 1];
    return scan_shared[from + me] - x;
}

// The order of this invocation in its workgroup, as row_scan counts.
uint lane() { return gl_NumSubgroups == 1 ? gl_SubgroupInvocationID : gl_LocalInvocationID.x; }

// As workgroup_scan, without shared memory where the workgroup is one subgroup, for lane() order.
uint row_scan(uint x, out uint total) {
    if (gl_NumSubgroups > 1) return workgroup_scan(x, total);
    total = subgroupAdd(x);
    return subgroupExclusiveAdd(x);
}

uint row_scan(bool x, out uint total) {
    if (gl_NumSubgroups > 1) return workgroup_scan(uint(x), total);
    uvec4 votes = subgroupBallot(x);
    total = subgroupBallotBitCount(votes);
    return subgroupBallotExclusiveBitCount(votes);
}
