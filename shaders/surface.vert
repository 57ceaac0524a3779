// Instanced bodies: unit mesh -> scale -> turn -> place.
#include "common_frame.glsl"

layout(location = 0) in vec3 mesh_position;
layout(location = 1) in vec3 mesh_normal;
layout(location = 2) in vec4 orientation;
layout(location = 3) in vec4 position_roughness;
layout(location = 4) in vec4 scale_metallic;
layout(location = 5) in vec3 color;
layout(location = 6) in vec3 pattern_color;

out vec3 world_position;
out vec3 body_position;
out vec3 world_normal;
flat out vec4 color_roughness;
flat out vec4 pattern_metallic;
flat out vec3 body_scale;

vec3 turned(vec4 q, vec3 x) {
    vec3 t = 2.0 * cross(q.xyz, x);
    return x + q.w * t + cross(q.xyz, t);
}

void main() {
    body_position = mesh_position * scale_metallic.xyz;
    world_position = turned(orientation, body_position) + position_roughness.xyz;
    world_normal = turned(orientation, mesh_normal);
    color_roughness = vec4(color, position_roughness.w);
    pattern_metallic = vec4(pattern_color, scale_metallic.w);
    body_scale = scale_metallic.xyz;
    gl_Position = frame.clip_from_world * vec4(world_position, 1.0);
}
