// What a float is, by its bits: drivers may take comparisons with NaN and infinity as they like.
bool finite(float x) { return (floatBitsToUint(x) & 0x7f800000u) != 0x7f800000u; }
bool finite(vec3 p) { return finite(p.x) && finite(p.y) && finite(p.z); }
bool is_nan(float x) { return (floatBitsToUint(x) & 0x7fffffffu) > 0x7f800000u; }
