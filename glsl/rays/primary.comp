// One invocation a ray: through the centre of its pixel, unit direction, t from 0 to ∞. Rays follow pixels in 2-D
// Morton order: whole 8×8 blocks by the Morton code of their place (blocks holds x | y << 16), then the strip right of
// them row by row, then the strip below column by column. Reads blocks.
#include "rays/root.glsl"

uint even_bits(uint m) { return (m & 1u) | (m >> 1 & 2u) | (m >> 2 & 4u); }

uvec2 pixel_of(uint i) {
    uvec2 whole = uvec2(args.width, args.height) & ~7u, rest = uvec2(args.width, args.height) & 7u;
    uint blocks = whole.x * whole.y, right = rest.x * whole.y;
    if (i < blocks) {
        uint block = P(blocks).at[i / 64];
        return uvec2(block & 0xffffu, block >> 16) * 8 + uvec2(even_bits(i & 63u), even_bits(i >> 1 & 31u));
    }
    i -= blocks;
    if (i < right) return uvec2(whole.x + i % rest.x, i / rest.x);
    i -= right;
    return uvec2(i / rest.y, whole.y + i % rest.y);
}

void main() {
    uint i = invocation_index();
    if (i >= args.width * args.height) return;
    precise vec2 at = vec2(pixel_of(i)) + 0.5;
    precise vec3 through = args.corner + (args.across * at.x + args.down * at.y);
    vec3 direction;
    if (!unit(through, direction)) direction = vec3(0.0);
    STORE_Ray(rays, i, Ray(args.eye, 0.0, direction, uintBitsToFloat(0x7f800000u)))
}
