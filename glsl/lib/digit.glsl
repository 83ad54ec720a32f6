// Digits of a radix sort, and how often each invocation of a tile meets each. Wants args.{count, shift}, keys.
layout(constant_id = SPEC_ITEMS) const uint ITEMS = 1;
layout(constant_id = SPEC_DIGIT_BITS) const uint DIGIT_BITS = 4;
const uint RADIX = 1u << DIGIT_BITS;

shared uint counters[RADIX * WG];  // digit-major

uint digit_of(uint key) { return (key >> args.shift) & (RADIX - 1u); }

// First key of this invocation.
uint first_key(uint tile) { return (tile * WG + gl_LocalInvocationID.x) * ITEMS; }

void count_digits(uint tile) {
    uint me = gl_LocalInvocationID.x;
    for (uint digit = 0; digit < RADIX; ++digit) counters[digit * WG + me] = 0;
    uint begin = first_key(tile);
    uint end = min(begin + ITEMS, args.count);
    for (uint i = begin; i < end; ++i) ++counters[digit_of(P(keys).at[i]) * WG + me];
}
