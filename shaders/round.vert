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

// Filled share of space (OcclusionVolume): cells and 4 x 4 x 4 of them; all from one corner.
uniform sampler3D occlusion_fine;
uniform sampler3D occlusion_coarse;
uniform vec4 occlusion_corner;   // [m]; w: side of a cell [m]

out vec3 world_position;
out vec3 body_position;
out vec3 world_normal;
out float open;
flat out vec4 color_roughness;
flat out vec4 pattern_metallic;
flat out uint id;

float filled(sampler3D volume, vec3 cells) { return texture(volume, cells / vec3(textureSize(volume, 0))).r; }

// The same samples as OcclusionVolume::open_share.
float open_share(vec3 position, vec3 normal) {
    vec3 p = (position - occlusion_corner.xyz) / occlusion_corner.w;
    float near = 1.0 - 0.45 * max(0.0, filled(occlusion_fine, p + normal * 0.8) - 0.1) / 0.9;
    float middle = 1.0 - 0.35 * filled(occlusion_fine, p + normal * 2.0);
    float far = 1.0 - 0.45 * filled(occlusion_coarse, (p + normal * 5.0) * 0.25);
    return near * middle * far;
}

void main() {
    body_position = mesh_position * scale_metallic.xyz;
    world_position = turned(orientation, body_position) + position_roughness.xyz;
    world_normal = turned(orientation, mesh_normal);
    open = open_share(world_position, world_normal);
    color_roughness = vec4(color, position_roughness.w);
    pattern_metallic = vec4(pattern_color, scale_metallic.w);
    id = first_id + group;
    gl_Position = frame.clip_from_world * vec4(world_position, 1.0);
}
