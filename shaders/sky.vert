// One triangle over the whole picture, at the far end of the depth range.
#include "common_frame.glsl"

out vec3 direction;

void main() {
    vec2 corner = vec2((gl_VertexID & 1) * 4 - 1, (gl_VertexID >> 1) * 4 - 1);
    gl_Position = vec4(corner, 0.0, 1.0);
    vec4 far_point = frame.world_from_clip * vec4(corner, 0.5, 1.0);
    direction = far_point.xyz / far_point.w - frame.eye.xyz;
}
