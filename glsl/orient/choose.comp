// One invocation ITEMS packed nodes: the frame in which its children's boxes are expected to cost least, of its own
// box's and its children's; none where the axes of the scene cost no more. Reads nodes, parents, points, ranges,
// frames. None of nodes of more than `most` triangles. Keeps: an estimate from extremal points; orient/pack decides by
// the exact boxes.
#include "lib/points.glsl"
#include "lib/box.glsl"
#include "lib/within.glsl"
#include "lib/cost.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

const uint CANDIDATES = 2 + WIDTH;  // axes of the scene, own, children's

void main() {
    FOR_ITEMS(i, args.count) {
        uint own = P(parents).at[i];
        if (LOAD_Range(ranges, own).count > args.most) {
            P(chosen).at[i] = pair_of(uvec2(0));
            continue;
        }
        uvec4 children = LOAD_Node(nodes, i).children;
        uvec2 candidates[CANDIDATES];
        float costs[CANDIDATES];
        for (uint c = 0; c < CANDIDATES; ++c) {
            candidates[c] = uvec2(0);
            costs[c] = 0.0;
        }
        candidates[1] = words_of(P(frames).at[own]);
        for (uint k = 0; k < WIDTH && children[k] != INVALID; ++k) {
            candidates[2 + k] = words_of(P(frames).at[4 * i + k]);
        }
        Aabb all = NOWHERE;
        for (uint k = 0; k < WIDTH && children[k] != INVALID; ++k) {
            vec3 e[POINTS];
            LOAD_POINTS(e, 4 * i + k)
            float cost = cost_of_visit(children[k], LOAD_Range(ranges, 4 * i + k).count);
            for (uint c = 0; c < CANDIDATES; ++c) {
                if (c > 0 && !is_oriented(candidates[c])) continue;
                vec3 r = rodrigues_of(candidates[c]);
                Frame f = frame_of(r);
                Aabb box = NOWHERE;
                [[unroll]] for (uint j = 0; j < POINTS; ++j) take_in(box, within(f, e[j]));
                precise float part = cost * unstretched(half_area(box), r);
                precise float sum = costs[c] + part;
                costs[c] = sum;
                if (c == 0) all = merged(all, box);
            }
        }
        precise float dearer = (args.oriented_cost - args.node_cost) * half_area(all);
        float least = costs[0];
        uvec2 words = uvec2(0);
        for (uint c = 1; c < CANDIDATES; ++c) {
            precise float cost = costs[c] + dearer;
            if (is_oriented(candidates[c]) && cost < least) {
                least = cost;
                words = candidates[c];
            }
        }
        P(chosen).at[i] = pair_of(words);
        if (is_oriented(words)) {
            atomicAdd(P(oriented).at[0], 1u);
            for (uint k = 0; k < WIDTH; ++k) P(extents).at[4 * i + k] = OrderedBounds(uvec3(INVALID), uvec3(0));
        }
    }
}
