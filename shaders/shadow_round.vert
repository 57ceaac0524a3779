// Depth of bodies of revolution as the sun sees them.
#include "common_turn.glsl"

layout(location = 0) in vec3 mesh_position;
layout(location = 3) in vec4 orientation;
layout(location = 4) in vec4 position_roughness;
layout(location = 5) in vec4 scale_metallic;

uniform mat4 clip_from_world_sun;

void main() {
    vec3 p = turned(orientation, mesh_position * scale_metallic.xyz) + position_roughness.xyz;
    gl_Position = clip_from_world_sun * vec4(p, 1.0);
}
