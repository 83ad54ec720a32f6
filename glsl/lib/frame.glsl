// Frames of oriented nodes: a rotation by its Rodrigues vector r, 21 bits a component in steps of 2⁻²¹; 0 is none. Its
// matrix is scaled by 1 + r·r, below 1.52: that saves a division and a root, and changes no t.
// Builders and tracers must take the same matrix, so its entries are rounded alike everywhere; how a point is then
// taken there is rounded as the device likes (see PAD_ORIENTED in lib/ray.glsl).
struct Frame {
    vec3 x;
    vec3 y;
    vec3 z;
};

bool is_oriented(uvec2 frame) { return (frame.x | frame.y) != 0u; }

vec3 rodrigues_of(uvec2 frame) {
    uint y = frame.x >> 21 | frame.y << 11;
    ivec3 steps = ivec3(int(frame.x << 11), int(y << 11), int(frame.y << 1)) >> 11;
    return vec3(steps) * (1.0 / 2097152.0);
}

// How much larger lengths are in the frame: 1 + r·r.
float stretch_of(vec3 r) {
    precise vec3 square = r * r;
    precise float stretch = 1.0 + (square.x + square.y + square.z);
    return stretch;
}

Frame frame_of(vec3 r) {
    precise vec3 square = r * r, twice = r * 2.0;
    precise float s = 1.0 - (square.x + square.y + square.z);
    precise float xy = twice.x * r.y, xz = twice.x * r.z, yz = twice.y * r.z;
    precise vec3 x = vec3(s + twice.x * r.x, xy - twice.z, xz + twice.y);
    precise vec3 y = vec3(xy + twice.z, s + twice.y * r.y, yz - twice.x);
    precise vec3 z = vec3(xz - twice.y, yz + twice.x, s + twice.z * r.z);
    return Frame(x, y, z);
}
