// Rotations as nodes hold them. Wants lib/frame.glsl.
#include "lib/reciprocal.glsl"

// The rotation to axes like these, in an order and of signs that make it least.
uvec2 frame_words(Frame f) {
    vec3 axes[3] = vec3[](f.x, f.y, f.z);
    float most = -1.0;
    Frame turned = f;
    for (uint order = 0; order < 6; ++order) {
        uint i = order >> 1, j = (i + 1 + (order & 1u)) % 3, k = 3 - i - j;
        precise float trace = abs(axes[i].x) + abs(axes[j].y) + abs(axes[k].z);
        if (trace > most) {
            most = trace;
            turned = Frame(axes[i].x < 0.0 ? -axes[i] : axes[i], axes[j].y < 0.0 ? -axes[j] : axes[j],
                           axes[k].z < 0.0 ? -axes[k] : axes[k]);
        }
    }
    precise float sum = 1.0 + most;
    float over = reciprocal(sum);
    precise vec3 r = vec3(turned.z.y - turned.y.z, turned.x.z - turned.z.x, turned.y.x - turned.x.y) * over;
    precise vec3 steps = floor(r * 2097152.0 + 0.5);
    uvec3 bits = uvec3(ivec3(clamp(steps, vec3(-1048575.0), vec3(1048575.0)))) & 0x1fffffu;
    return uvec2(bits.x | bits.y << 21, bits.y >> 11 | bits.z << 10);
}
