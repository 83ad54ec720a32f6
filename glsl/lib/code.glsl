// Bits of a place and a size, interleaved: z, y, x from the top. Each returns (high word, low word).

// Bits 0..10 of x, moved to bits 0, 3, 6, …
uint spread3(uint x) {
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    return (x | x << 2) & 0x09249249u;
}

uint interleave3(uvec3 q) { return spread3(q.x) | spread3(q.y) << 1 | spread3(q.z) << 2; }

// 21 bits an axis: 30 bits as in a 30-bit code, then 33 of which the first goes to the high word.
uvec2 code_63(uvec3 q) {
    uint middle = interleave3(q >> 10 & 1u);
    return uvec2(interleave3(q >> 11) << 1 | middle >> 2, (middle & 3u) << 30 | interleave3(q & 1023u));
}

// Bits 0..7 of x, moved to bits 0, 4, 8, …
uint spread4(uint x) {
    x = (x | x << 12) & 0x000f000fu;
    x = (x | x << 6) & 0x03030303u;
    return (x | x << 3) & 0x11111111u;
}

// Eight groups of z, y, x, size.
uint interleave4(uvec3 q, uint size) {
    return spread4(size) | spread4(q.x) << 1 | spread4(q.y) << 2 | spread4(q.z) << 3;
}

// 16 bits an axis, 15 of size: the sixteenth group has none.
uvec2 code_ext4(uvec3 q, uint size) {
    uint high = interleave4(q >> 8, size >> 7), low = interleave4(q & 255u, (size & 127u) << 1);
    return uvec2(high >> 1, high << 31 | low >> 1);
}

// Four groups of z, y, x, z, y, x, size: 28 bits from eight an axis and four of size.
uint interleave7(uvec3 q, uint size) {
    uint x = interleave3(q);
    x = x << 1 & 0x7eu | x << 2 & 0x3f00u | x << 3 & 0x1f8000u | x << 4 & 0xfc00000u;
    return x | (size | size << 6 | size << 12 | size << 18) & 0x204081u;
}

// 18 bits an axis, nine of size: nine groups.
uvec2 code_ext7(uvec3 q, uint size) {
    uint top = interleave7(q >> 16, size >> 8);
    uint middle = interleave7(q >> 8 & 255u, size >> 4 & 15u), bottom = interleave7(q & 255u, size & 15u);
    return uvec2(top << 24 | middle >> 4, middle << 28 | bottom);
}
