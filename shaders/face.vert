// Flat faces: four vertices each, all data from a table (Face of draw_list.h, nine texels).
// LARGE: 1 if the share of the sky is told in the atlas, 0 if at the corners alone.
#include "common_frame.glsl"
#include "common_light.glsl"

uniform samplerBuffer faces;

out vec3 to_eye;         // [m]
#if LIT
out vec3 shadow_place;
#endif
#if PATTERN
out vec3 body_position;
flat out vec3 pattern_root;   // square root of the pattern's colour
#endif
out vec2 open_place;   // in the atlas, or 0..1 over the face
flat out vec4 normal_metallic;
flat out vec4 color_roughness;   // with a pattern: square root of the colour
flat out vec3 ambient;
flat out uvec2 id_open;

void main() {
    int first = (gl_VertexID >> 2) * 9;
    vec4 center_roughness = texelFetch(faces, first);
    vec4 u_metallic = texelFetch(faces, first + 1);
    vec4 v_id = texelFetch(faces, first + 2);
    vec4 color_open = texelFetch(faces, first + 3);
    vec2 share = vec2(gl_VertexID & 1, (gl_VertexID >> 1) & 1);
    vec2 corner = share * 2.0 - 1.0;
    vec3 position = center_roughness.xyz + u_metallic.xyz * corner.x + v_id.xyz * corner.y;
#if LARGE
    vec4 place = texelFetch(faces, first + 5);
    open_place = mix(place.xy, place.zw, share);
#else
    open_place = share;
#endif
    vec3 normal = normalize(cross(u_metallic.xyz, v_id.xyz));
    to_eye = frame.eye.xyz - position;
#if LIT
    shadow_place = shadow_place_of(position, normal);
#endif
    normal_metallic = vec4(normal, u_metallic.w);
    ambient = ambient_irradiance(normal.z);
    color_roughness = vec4(color_open.rgb, center_roughness.w);
    id_open = floatBitsToUint(vec2(v_id.w, color_open.w));
#if PATTERN
    color_roughness.rgb = sqrt(color_roughness.rgb);
    pattern_root = sqrt(texelFetch(faces, first + 4).rgb);
    body_position = texelFetch(faces, first + 6).xyz + texelFetch(faces, first + 7).xyz * corner.x +
                    texelFetch(faces, first + 8).xyz * corner.y;
#endif
    gl_Position = frame.clip_from_world * vec4(position, 1.0);
}
