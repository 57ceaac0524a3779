// Bodies of revolution. PATTERN: 0 plain, 1 stripes, 2 checker, 3 grid, in body coordinates around z, so that
// turning is seen. MIRROR: 1 where polished bodies show what is around them.
#include "common_light.glsl"
#include "common_pattern.glsl"
#include "common_shadow.glsl"

in vec3 to_eye;
in vec3 shadow_place;
#if MIRROR
in vec3 world_position;
flat in mat4 shadow_from_world;
flat in float shadow_offset;
#include "common_mirror.glsl"
#endif
#include "common_surface.glsl"

in vec3 body_position;
in vec3 world_normal;
in float open;
flat in vec4 color_roughness;
flat in vec4 pattern_metallic;
flat in uint id;

layout(location = 0) out vec4 pixel;
layout(location = 1) out uint part;

float pattern_share() {
#if PATTERN == 0
    return 0.0;
#else
    // Eight sectors around z; where the angle jumps from pi to -pi its change is taken from the mirrored angle.
    const float sectors_per_radian = 4.0 / 3.14159265;
    float angle = atan(body_position.y, body_position.x) * sectors_per_radian;
    float mirrored = atan(body_position.y, -body_position.x) * sectors_per_radian;
    float w = min(pixel_width(angle), pixel_width(mirrored));
    float height = body_position.z / max(length(body_position), 1e-9);
#if PATTERN == 1
    return square_wave(angle, w);
#elif PATTERN == 2
    float z = (height + 1.0) * 2.0;
    return either(square_wave(angle, w), square_wave(z, pixel_width(z)));
#else
    vec2 x = vec2(angle, height * 4.0);
    vec2 share = line_share(x, max(vec2(w, pixel_width(x.y)), 1e-5), 0.08);
    return joined(share.x, share.y);
#endif
#endif
}

void main() {
    vec3 n = normalize(world_normal);
    vec3 root = mix(color_roughness.rgb, pattern_metallic.rgb, pattern_share());
    Surface surface = Surface(root * root, pattern_metallic.w, color_roughness.w, n, ambient_irradiance(n.z));
    pixel = vec4(tone_mapped(shaded(surface, normalize(to_eye), sunlight(shadow_place), open)), 1.0);
    part = id;
}
