// Depth of the bodies as the sun sees them.
#include "common_frame.glsl"

layout(location = 0) in vec3 mesh_position;
layout(location = 2) in vec4 orientation;
layout(location = 3) in vec4 position_roughness;
layout(location = 4) in vec4 scale_metallic;

uniform mat4 clip_from_world_sun;

vec3 turned(vec4 q, vec3 x) {
    vec3 t = 2.0 * cross(q.xyz, x);
    return x + q.w * t + cross(q.xyz, t);
}

void main() {
    vec3 p = turned(orientation, mesh_position * scale_metallic.xyz) + position_roughness.xyz;
    gl_Position = clip_from_world_sun * vec4(p, 1.0);
}
