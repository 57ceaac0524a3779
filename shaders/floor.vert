// A plane body: an inner polygon that may lie in shadow, and a ring around it out to the horizon.
#include "common_frame.glsl"

uniform vec3 origin;
uniform vec3 tangent;
uniform vec3 normal;
uniform vec2 corners[16];  // of the inner part [m]
uniform float ring_scale;  // size of the ring over that of the inner part

out vec2 floor_position;   // from origin [m]

void main() {
    // Vertices 0..15 are the inner corners, 16..31 the same moved outwards.
    vec2 center = vec2(0.0);
    for (int i = 0; i < 16; ++i) {
        center += corners[i] / 16.0;
    }
    vec2 corner = corners[gl_VertexID & 15];
    floor_position = gl_VertexID < 16 ? corner : center + (corner - center) * ring_scale;
    vec3 position = origin + tangent * floor_position.x + cross(normal, tangent) * floor_position.y;
    gl_Position = frame.clip_from_world * vec4(position, 1.0);
}
