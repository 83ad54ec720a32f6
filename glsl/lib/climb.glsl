// Climbing a packed tree from its leaves: nobody waits, the last inner child to arrive at a node goes on. Wants
// lib/reference.glsl and the buffer arrived, all 0 before; what is handed over lies in shared buffers.

// Hands over what was written of a child of `node`. Whether that was the last, so that all others' can be read.
bool arrive_last(uint node, uvec4 children) {
    memoryBarrierBuffer();  // release: what is written is there before the count
    if (atomicAdd(P(arrived).at[node], 1u) + 1 < inner_children(children)) return false;
    memoryBarrierBuffer();  // acquire: all others' counts were there before what is read
    return true;
}
