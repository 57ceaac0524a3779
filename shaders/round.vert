// Instanced bodies of revolution: unit mesh -> scale -> turn -> place.
#include "common_frame.glsl"
#include "common_turn.glsl"

layout(location = 0) in vec3 mesh_position;
layout(location = 1) in vec3 mesh_normal;
layout(location = 2) in uint group;
layout(location = 3) in vec4 orientation;
layout(location = 4) in vec4 position_roughness;
layout(location = 5) in vec4 scale_metallic;
layout(location = 6) in vec3 color;
layout(location = 7) in vec3 pattern_color;
layout(location = 8) in uint first_id;

// Filled share of space (OcclusionVolume): cells, cells of twice and of four times the side; all from one corner.
uniform sampler3D occlusion_0;
uniform sampler3D occlusion_1;
uniform sampler3D occlusion_2;
uniform vec4 occlusion_corner;   // [m]; w: side of a cell [m]

out vec3 to_eye;         // [m]
out vec3 shadow_place;
#if MIRROR
out vec3 world_position;
flat out mat4 shadow_from_world;   // as in Frame
flat out float shadow_offset;      // [m] along the normal
#endif
out vec3 body_position;
out vec3 world_normal;
out float open;
flat out vec4 color_roughness;     // square root of the colour
flat out vec4 pattern_metallic;    // and of the pattern's colour
flat out uint id;

float filled(sampler3D volume, vec3 cells) {
    return max(0.0, texture(volume, cells / vec3(textureSize(volume, 0))).r - 0.03) / 0.97;
}

float open_along(vec3 p, vec3 direction) {
    return (1.0 - 0.60 * filled(occlusion_0, p + direction * 1.8)) *
           (1.0 - 0.50 * filled(occlusion_1, (p + direction * 3.6) * 0.5));
}

// The same samples as OcclusionVolume::open_share.
float open_share(vec3 position, vec3 normal) {
    vec3 p = (position - occlusion_corner.xyz) / occlusion_corner.w;
    vec3 side = abs(normal.z) < 0.7 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0);
    vec3 t = normalize(cross(side, normal));
    vec3 s = cross(normal, t);
    const float lean = 0.70710678;
    float leaning = open_along(p, (normal + t) * lean) + open_along(p, (normal - t) * lean) +
                    open_along(p, (normal + s) * lean) + open_along(p, (normal - s) * lean);
    return 0.25 * leaning * (1.0 - 0.40 * filled(occlusion_2, (p + normal * 6.0) * 0.25));
}

void main() {
    body_position = mesh_position * scale_metallic.xyz;
    vec3 position = turned(orientation, body_position) + position_roughness.xyz;
    to_eye = frame.eye.xyz - position;
    world_normal = turned(orientation, mesh_normal);
    shadow_place = shadow_place_of(position, world_normal);
#if MIRROR
    world_position = position;
    shadow_from_world = frame.shadow_from_world;
    shadow_offset = frame.eye.w * 0.35;
#endif
    open = open_share(position, world_normal);
    color_roughness = vec4(sqrt(color), position_roughness.w);
    pattern_metallic = vec4(sqrt(pattern_color), scale_metallic.w);
    id = first_id + group;
    gl_Position = frame.clip_from_world * vec4(position, 1.0);
}
