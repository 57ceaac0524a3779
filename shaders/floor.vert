// A plane body: one large quad around the point the camera looks at.
#include "common_frame.glsl"

layout(location = 0) in vec2 corner;   // +-1

uniform vec3 origin;
uniform vec3 tangent;
uniform vec3 normal;
uniform vec2 grid_origin;

out vec3 world_position;
out vec2 grid_position;   // [m]

void main() {
    vec2 offset = corner * (2.0 * frame.sky_horizon.w);
    world_position = origin + tangent * offset.x + cross(normal, tangent) * offset.y;
    grid_position = grid_origin + offset;
    gl_Position = frame.clip_from_world * vec4(world_position, 1.0);
}
