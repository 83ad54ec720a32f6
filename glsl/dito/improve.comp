// One invocation ITEMS slots: pattern search for a smaller box around the slot's extremal points, from dito/fit's on: turns
// by 0.1 rad about the box's axes one after the other, both ways; by half of that once none helps. Reads points, ranges.
// Writes frames where a box is smaller. Keeps: the same bits everywhere.
#include "lib/points.glsl"
#include "lib/box.glsl"
#include "lib/within.glsl"
#include "lib/rotation.glsl"

layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;

// The first turns' tangent of half the angle.
const float STEP = 0.05;

vec3 e[POINTS];  // less the first

// How far points reach along an axis.
float width(vec3 axis) {
    float lo = 3.4028235e38, hi = -3.4028235e38;
    [[unroll]] for (uint k = 0; k < POINTS; ++k) {
        float x = along(axis, e[k]);
        lo = least_of(lo, x);
        hi = greatest_of(hi, x);
    }
    return hi - lo;
}

float area_of(vec3 s) {
    precise float area = s.x * (s.y + s.z) + s.y * s.z;
    return area;
}

// Turned about the first axis by the angle of tangent t of its half.
Frame turned(Frame f, float t) {
    precise float square = t * t, sum = 1.0 + square;
    float over = reciprocal(sum);
    precise float c = (1.0 - square) * over, s = (t + t) * over;
    precise vec3 y = f.y * c + f.z * s, z = f.z * c - f.y * s;
    return Frame(f.x, y, z);
}

// The words of a frame of a smaller box, else the same.
uvec2 improved(uvec2 words) {
    vec3 r = rodrigues_of(words);
    Frame f = frame_of(r);
    float over = reciprocal(stretch_of(r));
    precise vec3 x = f.x * over, y = f.y * over, z = f.z * over;
    f = Frame(x, y, z);
    vec3 sizes = vec3(width(f.x), width(f.y), width(f.z));
    float least_area = area_of(sizes), step = STEP;
    bool better = false;
    uint failed = 0;
    for (uint n = 0; n < args.evaluations; ++n) {
        Frame tried = turned(f, step);
        vec3 its = vec3(sizes.x, width(tried.y), width(tried.z));
        float area = area_of(its);
        if (area < least_area) {
            least_area = area;
            sizes = its;
            f = tried;
            better = true;
            failed = 0;
            continue;
        }
        ++failed;
        step = -step;
        // Both ways failed: the next axis.
        if (failed % 2 == 0) {
            f = Frame(f.y, f.z, f.x);
            sizes = sizes.yzx;
        }
        if (failed == 6) {
            step *= 0.5;
            failed = 0;
        }
    }
    return better ? frame_words(f) : words;
}

void main() {
    FOR_ITEMS(slot, args.slots) {
        uint count = LOAD_Range(ranges, slot).count;
        if (count == 0 || count > args.most) continue;
        LOAD_POINTS(e, slot)
        vec3 first = e[0];
        [[unroll]] for (uint k = 0; k < POINTS; ++k) {
            precise vec3 p = e[k] - first;
            e[k] = p;
        }
        P(frames).at[slot] = pair_of(improved(words_of(P(frames).at[slot])));
    }
}
