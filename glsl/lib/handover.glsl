// Handing values from one invocation to others of the same dispatch, by the Vulkan memory model (its appendix in the
// specification). What is handed over lies in shared buffers (PtrShared), whose loads and stores are non-private: only
// those are ordered by what follows.
//
// Both ends are one operation. Before it, what this invocation has stored is made available to the scope's memory domain
// and released; after it, what others have released to it is acquired and made visible. Only an invocation's own stores
// are made available, so who passes on another's must store it again. Nobody waits here: an invocation learns that it is
// too early, and leaves.
//
// No hand-over: sums, least and greatest values by atomics that only later dispatches read, for which the recorder's
// barriers care; nor sums whose result gives an invocation places of its own.
const int HAND_OVER = gl_SemanticsAcquireRelease | gl_SemanticsMakeAvailable | gl_SemanticsMakeVisible;

// Adds to a counter in a shared buffer; returns what it was before. Hands over to all invocations that add to it later, in
// whatever workgroup: what they read was written by this addition or by one that follows it without a gap, its release
// sequence, so that this one synchronizes with theirs. A queue family's scope has all invocations of a dispatch.
#define HAND_OVER_BY_ADDING(counter, n)                                                                               \
    atomicAdd(counter, n, gl_ScopeQueueFamily, gl_StorageSemanticsBuffer, HAND_OVER)

// Hands over from all invocations of a workgroup to all of it. Each must come here.
void hand_over_in_workgroup() {
    controlBarrier(gl_ScopeWorkgroup, gl_ScopeWorkgroup, gl_StorageSemanticsBuffer, HAND_OVER);
}
