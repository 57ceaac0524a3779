// Flat patches of boxes. LIT: 1 if turned towards the sun. PATTERN: 0 plain; 1 stripes, 2 checker, counted in shares
// of the body's size; 3 grid, counted in the lines of the floor from the body's middle.
#include "common_frame.glsl"
#include "common_light.glsl"
#include "common_pattern.glsl"
#include "common_shadow.glsl"
#include "common_surface.glsl"

in vec3 world_position;
in vec3 body_position;
in vec2 patch_position;
flat in vec3 world_normal;
flat in vec4 color_roughness;
flat in vec4 pattern_metallic;
flat in vec4 open_corners;
flat in uint id;

layout(location = 0) out vec4 pixel;
layout(location = 1) out uint part;

float pattern_share() {
#if PATTERN == 0
    return 0.0;
#elif PATTERN == 1
    float x = body_position.x * 8.0;
    return square_wave(x, fwidth(x));
#elif PATTERN == 2
    // The small offset keeps faces off the wave's edges.
    vec3 c = body_position * 4.0 + 1e-4;
    vec3 w = fwidth(c);
    return either(either(square_wave(c.x, w.x), square_wave(c.y, w.y)), square_wave(c.z, w.z));
#else
    // Lines across the axis that a face is perpendicular to would fill it: only two of the three count.
    vec3 c = body_position;
    vec3 w = fwidth(c);
    vec2 xy = line_share(c.xy, max(w.xy, 1e-5), 0.03) * step(1e-4, w.xy);
    float z = line_share(c.zz, max(w.zz, 1e-5), 0.03).x * step(1e-4, w.z);
    return joined(joined(xy.x, xy.y), z);
#endif
}

void main() {
    vec3 v = normalize(frame.eye.xyz - world_position);
    vec3 albedo = mix(color_roughness.rgb, pattern_metallic.rgb, pattern_share());
    vec2 open_v = mix(open_corners.xy, open_corners.zw, patch_position.y);
    float open = mix(open_v.x, open_v.y, patch_position.x);
#if LIT
    float sunlit = sunlight(world_position, world_normal);
#else
    const float sunlit = 0.0;
#endif
    vec3 radiance = shaded(Surface(albedo, pattern_metallic.w, color_roughness.w, world_normal), v, sunlit, open);
    pixel = vec4(tone_mapped(radiance), 1.0);
    part = id;
}
