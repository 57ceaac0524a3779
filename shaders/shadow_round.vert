// Depth of bodies of revolution and hulls as the sun sees them. A hull's corner between three sides away from the sun is moved
// into the hull, as of boxes: see shadow_box.vert.
#include "common_turn.glsl"

layout(location = 0) in vec3 mesh_position;
layout(location = 3) in vec4 orientation;
layout(location = 4) in vec4 position_roughness;
layout(location = 5) in vec4 scale_metallic;
layout(location = 9) in vec3 face_0;   // of such a corner; else zero
layout(location = 10) in vec3 face_1;
layout(location = 11) in vec3 face_2;
layout(location = 12) in vec3 inside;

uniform mat4 clip_from_world_sun;

void main() {
    vec3 sun = turned(vec4(-orientation.xyz, orientation.w), to_sun);
    bool is_far = max(max(dot(face_0, sun), dot(face_1, sun)), dot(face_2, sun)) < 0.0;
    vec3 p = turned(orientation, (is_far ? inside : mesh_position) * scale_metallic.xyz) + position_roughness.xyz;
    gl_Position = clip_from_world_sun * vec4(p, 1.0);
}
