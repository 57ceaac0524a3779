// A plane body: an inner polygon that may lie in shadow, and a ring around it out to the horizon.
// SHADOWED: 1 for the inner polygon.
#include "common_frame.glsl"
#include "common_light.glsl"

uniform vec3 origin;
uniform vec3 tangent;
uniform vec3 normal;
uniform vec2 grid_origin;        // of floor_position = 0 in the grid [m]
uniform vec2 corners[16];        // of the inner part [m]
uniform float ring_scale;        // size of the ring over that of the inner part
uniform vec3 color;
uniform vec3 line_color;
uniform vec4 occlusion_place_of; // texture coordinates = floor_position * xy + zw
uniform uint id;

out vec2 floor_position;         // from origin [m]
flat out vec3 eye_place;         // x, y as floor_position [m]; square of the height over the floor [m^2]
#if SHADOWED
out vec3 shadow_place;
out vec2 occlusion_place;
#endif
flat out vec2 grid_shift;        // [lines]
flat out vec3 color_root;        // square roots of the colours
flat out vec3 line_color_root;
flat out vec3 sunlit_radiance;   // of a white floor in the sun alone
flat out vec3 ambient;
flat out uint part_id;

void main() {
    // Vertices 0..15 are the inner corners, 16..31 the same moved outwards.
    vec2 center = vec2(0.0);
    for (int i = 0; i < 16; ++i) {
        center += corners[i] / 16.0;
    }
    vec2 corner = corners[gl_VertexID & 15];
    floor_position = gl_VertexID < 16 ? corner : center + (corner - center) * ring_scale;
    vec3 across = cross(normal, tangent);
    vec3 position = origin + tangent * floor_position.x + across * floor_position.y;
    vec3 to_eye = frame.eye.xyz - origin;
    float height = dot(to_eye, normal);
    eye_place = vec3(dot(to_eye, tangent), dot(to_eye, across), height * height);
#if SHADOWED
    // Nothing lies below a floor: its place is as deep as that of any texel that the filter sees, three around, so that a
    // body that stands flush on it lets no light through.
    float cosine = max(dot(normal, to_sun), 0.1);
    float depth = frame.eye.w * (3.0 * sqrt(1.0 - cosine * cosine) / cosine + 0.5);
    shadow_place = (frame.shadow_from_world * vec4(position - to_sun * depth, 1.0)).xyz;
    occlusion_place = floor_position * occlusion_place_of.xy + occlusion_place_of.zw;
#endif
    grid_shift = grid_origin / grid_spacing;
    color_root = sqrt(color);
    line_color_root = sqrt(line_color);
    sunlit_radiance = sun_radiance * max(dot(normal, to_sun), 0.0);
    ambient = ambient_irradiance(normal.z);
    part_id = id;
    gl_Position = frame.clip_from_world * vec4(position, 1.0);
}
