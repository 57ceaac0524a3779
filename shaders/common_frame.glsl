// What one frame has in common for all programs; filled by renderer.cpp (FrameBlock).
layout(std140) uniform Frame {
    mat4 clip_from_world;
    mat4 world_from_clip;
    mat4 shadow_from_world;   // texture coordinates and depth 0..1 in the shadow map
    vec4 eye;                 // [m]; w: exposure
    vec4 to_sun;              // unit; w: side of a shadow texel [m]
    vec4 sun;                 // irradiance / pi; w: side of the shadow map [texels]
    vec4 sky_zenith;          // radiance
    vec4 sky_horizon;         // radiance; w: floor extent [m]
    vec4 ground;              // radiance below the horizon; w: grid spacing [m]
} frame;
