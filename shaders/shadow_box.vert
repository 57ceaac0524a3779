// Depth of boxes as the sun sees them: eight vertices each, poses from a table (Instance of draw_types.h). Of the sides
// away from the sun, whose outline is all that a shadow shows, the middle corner is moved half way through the box towards
// the sun: a side that lies flush on a surface would let light through along its edges.
#include "common_turn.glsl"

uniform samplerBuffer boxes;
uniform mat4 clip_from_world_sun;

void main() {
    int first = (gl_VertexID >> 3) * 5;
    vec3 corner = vec3(gl_VertexID & 1, (gl_VertexID >> 1) & 1, (gl_VertexID >> 2) & 1) * 2.0 - 1.0;
    vec4 orientation = texelFetch(boxes, first);
    vec3 half_size = texelFetch(boxes, first + 2).xyz;
    vec3 sun = turned(vec4(-orientation.xyz, orientation.w), to_sun);
    vec3 through = half_size / max(abs(sun), 1e-6);
    bool is_far = all(equal(greaterThan(corner, vec3(0.0)), lessThanEqual(sun, vec3(0.0))));
    vec3 p = turned(orientation, corner * half_size + sun * (is_far ? min(min(through.x, through.y), through.z) : 0.0));
    gl_Position = clip_from_world_sun * vec4(p + texelFetch(boxes, first + 1).xyz, 1.0);
}
