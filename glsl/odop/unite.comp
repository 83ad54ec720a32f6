// One workgroup its share of the pairs that merged: in each basis the first one's box becomes that of both, in its slot.
// Reads pairs, state, slabs.
#include "lib/box.glsl"
#include "lib/slab.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

#include "lib/share.glsl"

void main() {
    uvec2 share = share_of_pairs();
    for (uint k = 0; k < args.count; ++k) {
        Slab slab = slab_of(k);
        for (uint i = share.x; i < share.y; i += WG) {
            uvec2 slots = words_of(P(pairs).at[i]);
            Aabb box = merged(LOAD_BOX(slab, slots.x), LOAD_BOX(slab, slots.y));
            STORE_BOX(slab, slots.x, box)
        }
    }
}
