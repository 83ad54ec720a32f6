// Lengths and directions from additions and products alone, so that every device computes the same bits: sqrt, division,
// dot and normalize round as the device likes. The twin in src/oracle/rays.rs follows each step.

// 1 / √x for normal x, relative error below 2⁻²²: a first guess from the exponent [Lomont03], three Newton steps.
float inverse_root(float x) {
    precise float y = uintBitsToFloat(0x5f375a86u - (floatBitsToUint(x) >> 1));
    precise float h = 0.5 * x;
    y = y * (1.5 - h * y * y);
    y = y * (1.5 - h * y * y);
    y = y * (1.5 - h * y * y);
    return y;
}

float inner(vec3 a, vec3 b) {
    precise vec3 p = a * b;
    precise float sum = p.x + p.y + p.z;
    return sum;
}

vec3 outer(vec3 a, vec3 b) {
    precise vec3 n = a.yzx * b.zxy - a.zxy * b.yzx;
    return n;
}

float largest(vec3 v) { return max(abs(v.x), max(abs(v.y), abs(v.z))); }

// The power of two that takes v's largest component to [1, 2), where that is a normal number below 2¹²⁷.
float level_of(vec3 v) {
    int exponent = int(floatBitsToUint(largest(v)) >> 23) - 127;
    return uintBitsToFloat(uint(127 - clamp(exponent, -127, 126)) << 23);
}

vec3 levelled(vec3 v) {
    precise vec3 l = v * level_of(v);
    return l;
}

// The unit vector along v; false where v has no direction.
bool unit(vec3 v, out vec3 along) {
    vec3 l = levelled(v);
    float square = inner(l, l);
    precise vec3 u = l * inverse_root(square);
    along = u;
    return square >= 1.0 && square <= 64.0;
}
