// Depth of boxes as the sun sees them: eight vertices each, poses from a table (Instance of draw_types.h).
#include "common_turn.glsl"

uniform samplerBuffer boxes;
uniform mat4 clip_from_world_sun;

void main() {
    int first = (gl_VertexID >> 3) * 5;
    vec3 corner = vec3(gl_VertexID & 1, (gl_VertexID >> 1) & 1, (gl_VertexID >> 2) & 1) * 2.0 - 1.0;
    vec3 p = turned(texelFetch(boxes, first), corner * texelFetch(boxes, first + 2).xyz);
    gl_Position = clip_from_world_sun * vec4(p + texelFetch(boxes, first + 1).xyz, 1.0);
}
