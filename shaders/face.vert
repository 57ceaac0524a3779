// Flat patches: four vertices each, all data from a table (Face of draw_list.h, nine texels).
#include "common_frame.glsl"

uniform samplerBuffer faces;

out vec3 world_position;
out vec3 body_position;
out vec2 patch_position;   // 0..1 over the patch
flat out vec3 world_normal;
flat out vec4 color_roughness;
flat out vec4 pattern_metallic;
flat out vec4 open_corners;
flat out uint id;

void main() {
    int first = (gl_VertexID >> 2) * 9;
    vec4 center_roughness = texelFetch(faces, first);
    vec4 u_metallic = texelFetch(faces, first + 1);
    vec4 v_id = texelFetch(faces, first + 2);
    vec2 corner = vec2(gl_VertexID & 1, (gl_VertexID >> 1) & 1) * 2.0 - 1.0;
    world_position = center_roughness.xyz + u_metallic.xyz * corner.x + v_id.xyz * corner.y;
    patch_position = corner * 0.5 + 0.5;
    world_normal = normalize(cross(u_metallic.xyz, v_id.xyz));
    color_roughness = vec4(texelFetch(faces, first + 3).rgb, center_roughness.w);
    pattern_metallic = vec4(texelFetch(faces, first + 4).rgb, u_metallic.w);
    open_corners = texelFetch(faces, first + 5);
    body_position = texelFetch(faces, first + 6).xyz + texelFetch(faces, first + 7).xyz * corner.x +
                    texelFetch(faces, first + 8).xyz * corner.y;
    id = floatBitsToUint(v_id.w);
    gl_Position = frame.clip_from_world * vec4(world_position, 1.0);
}
