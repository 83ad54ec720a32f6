// Handing values from one invocation to others of the same dispatch, by the Vulkan memory model. Wants shared buffers
// (PtrShared) for all that is handed over: what is stored and loaded there is non-private, so that these order it.
//
// Both ends are the same operation. Before it, what this invocation has stored is released and made available to the
// others of the scope; after it, what others have released to this one is acquired and made visible to it. Nobody waits in
// it: who comes too early learns of nothing, and must not look.
const int HAND_OVER = gl_SemanticsAcquireRelease | gl_SemanticsMakeAvailable | gl_SemanticsMakeVisible;

// Adds to a counter in a shared buffer; returns what it was before. Hands over to all who add to it later, in whatever
// workgroup: each of them reads a number that this one wrote, or one that another addition made of it (a release
// sequence), so this one synchronizes with it. All invocations of a dispatch are of one queue, and any device has that
// scope.
#define HAND_OVER_BY_ADDING(counter, n)                                                                               \
    atomicAdd(counter, n, gl_ScopeQueueFamily, gl_StorageSemanticsBuffer, HAND_OVER)

// All invocations of a workgroup to all of it, each of which must come here.
void hand_over_in_workgroup() {
    controlBarrier(gl_ScopeWorkgroup, gl_ScopeWorkgroup, gl_StorageSemanticsBuffer, HAND_OVER);
}
