// Climbing a tree from its leaves. Wants the shared buffer arrived, one a node, all 0 before; what is handed over lies in
// shared buffers.
#include "lib/handover.glsl"

// Hands what this invocation has stored over to those who arrive at `node` after it; returns how many came before, whose
// stores it sees from here on. Nobody waits: who is not the last must leave, and the last goes on for all.
uint arrive(uint node) { return HAND_OVER_BY_ADDING(P(arrived).at[node], 1u); }
