// One workgroup a tile of WG · ITEMS keys, one invocation ITEMS consecutive ones, in order: each key goes to the next
// place of its digit, and its value with it. Reads keys, values, offsets. Keeps: stable, so four of these sort.
#include "lib/digit.glsl"

void main() {
    uint me = gl_LocalInvocationID.x;
    uint tile = group_index();
    count_digits(tile);
    barrier();
    // Counters become the place of the invocation's first key of each digit.
    for (uint digit = me; digit < RADIX; digit += WG) {
        uint place = tile < args.tiles ? P(offsets).at[digit * args.tiles + tile] : 0;
        for (uint i = 0; i < WG; ++i) {
            uint n = counters[digit * WG + i];
            counters[digit * WG + i] = place;
            place += n;
        }
    }
    barrier();
    uint begin = first_key(tile);
    uint end = min(begin + ITEMS, args.count);
    for (uint i = begin; i < end; ++i) {
        uint key = P(keys).at[i];
        uint slot = digit_of(key) * WG + me;
        uint place = counters[slot];
        counters[slot] = place + 1;
        P(keys_out).at[place] = key;
        P(values_out).at[place] = P(values).at[i];
    }
}
