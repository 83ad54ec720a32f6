// One invocation ITEMS slots: the frame in which the box of the slot's extremal points is least, of those that DiTO
// tries [LARSSON11]: a face or an edge of the box lies along a large triangle of the points, or of the two tetrahedra
// on it. None where there are no points. Reads points, ranges. Keeps: the same bits everywhere. Differs: tolerances are
// relative; a line keeps a box along it, and a flat set that of its triangle; the large triangle begins with the point
// farthest from the first and the one farthest from that, for corners of small leaves come in no pairs; the frame is
// rounded (lib/frame.glsl).
#include "lib/points.glsl"
#include "lib/box.glsl"
#include "lib/within.glsl"
#include "lib/rotation.glsl"
#include "rays/root.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

// Squared, of the longest distance: points this near to a line or a plane lie in it.
const float FLAT = 1e-12;

vec3 e[POINTS];  // less the first
float least_area;
Frame best;

void try_frame(Frame f) {
    Aabb box = NOWHERE;
    [[unroll]] for (uint k = 0; k < POINTS; ++k) take_in(box, within(f, e[k]));
    float area = half_area(box);
    if (area < least_area) {
        least_area = area;
        best = f;
    }
}

// The frame of an edge, of unit length, and a normal, which of a narrow triangle may lean towards it.
void try_edge(vec3 normal, vec3 edge) {
    vec3 across;
    if (unit(outer(normal, edge), across)) try_frame(Frame(outer(edge, across), edge, across));
}

vec3 farthest_from(vec3 p, out float distance) {
    vec3 far = p;
    distance = -1.0;
    [[unroll]] for (uint k = 0; k < POINTS; ++k) {
        precise vec3 v = e[k] - p;
        float square = along(v, v);
        if (square > distance) {
            distance = square;
            far = e[k];
        }
    }
    return far;
}

vec3 farthest_from_line(vec3 p, vec3 edge, out float distance) {
    vec3 far = e[0];
    distance = -1.0;
    [[unroll]] for (uint k = 0; k < POINTS; ++k) {
        precise vec3 v = e[k] - p;
        precise vec3 off = v - edge * along(edge, v);
        float square = along(off, off);
        if (square > distance) {
            distance = square;
            far = e[k];
        }
    }
    return far;
}

// Leaves the axes of the scene where nothing is less.
void search_frames() {
    // Farther apart than the extremal points of any direction, or hardly nearer.
    float longest;
    vec3 p0 = farthest_from(e[0], longest);
    vec3 p1 = farthest_from(p0, longest);
    precise vec3 base = p0 - p1;
    vec3 edge;
    if (!unit(base, edge)) return;
    float off_line;
    vec3 p2 = farthest_from_line(p0, edge, off_line);
    precise vec3 v1 = p1 - p2, v2 = p2 - p0;
    vec3 normal;
    if (off_line <= FLAT * longest || !unit(outer(v1, v2), normal)) {
        vec3 size = abs(edge);
        vec3 other = size.x <= size.y && size.x <= size.z ? vec3(1, 0, 0)
                   : size.y <= size.z ? vec3(0, 1, 0) : vec3(0, 0, 1);
        if (unit(outer(edge, other), normal)) try_edge(normal, edge);
        return;
    }
    // The tips of the tetrahedra.
    vec3 above = p0, below = p0;
    float highest = 0.0, lowest = 0.0;
    [[unroll]] for (uint k = 0; k < POINTS; ++k) {
        precise vec3 v = e[k] - p0;
        float height = along(normal, v);
        if (height > highest) {
            highest = height;
            above = e[k];
        }
        if (height < lowest) {
            lowest = height;
            below = e[k];
        }
    }
    for (uint face = 0; face < 7; ++face) {
        vec3 a = p0, b = p1, c = p2;
        if (face > 0) {
            float height = face < 4 ? highest : lowest;
            if (height * height <= FLAT * longest) continue;
            uint side = (face - 1) % 3;
            a = face < 4 ? above : below;
            b = side == 0 ? p0 : side == 1 ? p1 : p2;
            c = side == 0 ? p1 : side == 1 ? p2 : p0;
        }
        precise vec3 x = b - a, y = c - b, z = a - c;
        if (!unit(outer(x, y), normal)) continue;
        for (uint k = 0; k < 3; ++k) {
            if (unit(k == 0 ? x : k == 1 ? y : z, edge)) try_edge(normal, edge);
        }
    }
}

void main() {
    FOR_ITEMS(slot, args.slots) {
        uvec2 words = uvec2(0);
        uint count = LOAD_Range(ranges, slot).count;
        if (count > 0 && count <= args.most) {
            LOAD_POINTS(e, slot)
            vec3 first = e[0];
            [[unroll]] for (uint k = 0; k < POINTS; ++k) {
                precise vec3 p = e[k] - first;
                e[k] = p;
            }
            Frame axes = Frame(vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1));
            best = axes;
            least_area = 3.4028235e38;
            try_frame(axes);
            search_frames();
            words = frame_words(best);
        }
        P(frames).at[slot] = pair_of(words);
    }
}
