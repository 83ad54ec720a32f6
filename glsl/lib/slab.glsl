// Slabs: the boxes of clusters in one basis, as many slabs as memory has room for, wherever it has. Wants slabs.

layout(buffer_reference, scalar, buffer_reference_align = 8) restrict buffer Slab { AabbPairs at[]; };

Slab slab_of(uint k) { return Slab(words_of(P(slabs).at[k])); }

#define LOAD_BOX(slab, i) Aabb_of(slab.at[i].p[0], slab.at[i].p[1], slab.at[i].p[2])
#define STORE_BOX(slab, i, box)                                                                                       \
    {                                                                                                                 \
        slab.at[i].p[0] = Aabb_pair0(box);                                                                            \
        slab.at[i].p[1] = Aabb_pair1(box);                                                                            \
        slab.at[i].p[2] = Aabb_pair2(box);                                                                            \
    }
