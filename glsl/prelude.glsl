// What every kernel starts with. build.rs puts the shared structs and the kernel's own arguments after it.
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_vote : require

// WIDE: the device has 64-bit integers and floats.
// Two words loaded or stored at once. A software driver pays for each load of each invocation, whatever its size.
#ifdef WIDE
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#define FLOAT64
#define PAIR uint64_t
uvec2 words_of(PAIR p) { return unpackUint2x32(p); }
PAIR pair_of(uvec2 words) { return packUint2x32(words); }
#else
#define PAIR uvec2
uvec2 words_of(PAIR p) { return p; }
PAIR pair_of(uvec2 words) { return words; }
#endif

layout(local_size_x_id = 0) in;                 // SPEC_WG
layout(constant_id = 0) const uint WG = 64;     // the same number, for arithmetic

// Index of this workgroup: grids of more than 65535 groups are two-dimensional.
uint group_index() { return gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x; }
// Index of this invocation in the whole dispatch.
uint invocation_index() { return group_index() * WG + gl_LocalInvocationID.x; }

// Items of this workgroup one after the other, those of neighbouring invocations side by side: whole cache lines on a
// GPU, and one stream for a software driver's prefetcher instead of one a lane. Wants ITEMS.
#define FOR_ITEMS(i, count)                                                                                           \
    for (uint i = group_index() * WG * ITEMS + gl_LocalInvocationID.x, i##_end = min((group_index() + 1) * WG * ITEMS, count);    \
         i < i##_end; i += WG)

// Minimum and maximum of numbers: no case for NaN, which min() and max() pay for on some drivers.
float least_of(float a, float b) { return a < b ? a : b; }
float greatest_of(float a, float b) { return a > b ? a : b; }
vec3 least_of(vec3 a, vec3 b) { return vec3(least_of(a.x, b.x), least_of(a.y, b.y), least_of(a.z, b.z)); }
vec3 greatest_of(vec3 a, vec3 b) { return vec3(greatest_of(a.x, b.x), greatest_of(a.y, b.y), greatest_of(a.z, b.z)); }
