// Flat faces of boxes. LIT: 1 if turned towards the sun. LARGE: as in face.vert. PATTERN: 0 plain; 1 stripes,
// 2 checker, counted in shares of the body's size; 3 grid, counted in the lines of the floor from the body's middle.
#define MIRROR 0
#include "common_light.glsl"
#include "common_pattern.glsl"
#include "common_shadow.glsl"
#include "common_surface.glsl"

in vec3 to_eye;
#if LIT
in vec3 shadow_place;
#endif
#if PATTERN
in vec3 body_position;
flat in vec3 pattern_root;
#endif
in vec2 open_place;
flat in vec4 normal_metallic;
flat in vec4 color_roughness;
flat in vec3 ambient;
flat in uvec2 id_open;

uniform sampler2D sky_atlas;

layout(location = 0) out vec4 pixel;
layout(location = 1) out uint part;

#if PATTERN == 1
float pattern_share() {
    float x = body_position.x * 8.0;
    return square_wave(x, pixel_width(x));
}
#elif PATTERN == 2
float pattern_share() {
    // The small offset keeps faces off the wave's edges.
    vec3 c = body_position * 4.0 + 1e-4;
    vec3 w = pixel_width(c);
    return either(either(square_wave(c.x, w.x), square_wave(c.y, w.y)), square_wave(c.z, w.z));
}
#elif PATTERN == 3
float pattern_share() {
    // Lines across the axis that a face is perpendicular to would fill it: only two of the three count.
    vec3 c = body_position;
    vec3 w = pixel_width(c);
    vec2 xy = line_share(c.xy, max(w.xy, 1e-5), 0.03) * step(1e-4, w.xy);
    float z = line_share(c.zz, max(w.zz, 1e-5), 0.03).x * step(1e-4, w.z);
    return joined(joined(xy.x, xy.y), z);
}
#endif

void main() {
    vec3 v = normalize(to_eye);
#if PATTERN
    // Mixed as edges are, close to display values.
    vec3 root = mix(color_roughness.rgb, pattern_root, pattern_share());
    vec3 albedo = root * root;
#else
    vec3 albedo = color_roughness.rgb;
#endif
#if LARGE
    float open = texture(sky_atlas, open_place).r;
#else
    vec4 corners = unpackUnorm4x8(id_open.y);
    vec2 along_v = mix(corners.xy, corners.zw, open_place.y);
    float open = mix(along_v.x, along_v.y, open_place.x);
#endif
#if LIT
    float sunlit = sunlight(shadow_place);
#else
    const float sunlit = 0.0;
#endif
    Surface surface = Surface(albedo, normal_metallic.w, color_roughness.w, normal_metallic.xyz, ambient);
    pixel = vec4(tone_mapped(shaded(surface, v, sunlit, open)), 1.0);
    part = id_open.x;
}
