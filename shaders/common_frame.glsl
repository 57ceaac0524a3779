// What one frame has in common for all programs; filled by renderer.cpp (FrameBlock). For vertex shaders only: llvmpipe
// reads a uniform anew for each pixel, in as many steps as a dozen sums. What a pixel needs of the frame reaches it from
// the vertices; what is the same in all frames of a scene is a constant in the text (scene_constants in renderer.cpp).
layout(std140) uniform Frame {
    mat4 clip_from_world;
    mat4 world_from_clip;
    mat4 shadow_from_world;   // texture coordinates and depth 0..1 in the shadow map
    vec4 eye;                 // [m]; w: side of a shadow texel [m]
} frame;

// Place in the shadow map of a point whose surface has normal n. The map holds the far sides of bodies, so a small
// offset along the normal suffices.
vec3 shadow_place_of(vec3 position, vec3 n) {
    return (frame.shadow_from_world * vec4(position + n * (frame.eye.w * 0.35), 1.0)).xyz;
}
