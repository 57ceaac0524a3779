// Floor with a metric grid; fades into the sky with distance. SHADOWED: 1 in the inner part.
#include "common_frame.glsl"
#include "common_light.glsl"
#include "common_pattern.glsl"
#include "common_shadow.glsl"

in vec3 world_position;
in vec2 floor_position;
in vec2 grid_position;

uniform vec3 color;
uniform vec3 line_color;
uniform vec3 normal;
uniform sampler2D occlusion;    // open share of the sky
uniform vec4 occlusion_place;   // texture coordinates = floor_position * xy + zw
uniform uint id;

layout(location = 0) out vec4 pixel;
layout(location = 1) out uint part;

float grid_share(vec2 x, vec2 w, float width) {
    vec2 share = line_share(x, w, width);
    return joined(share.x, share.y);
}

void main() {
    vec2 x = grid_position / frame.ground.w;
    vec2 w = max(fwidth(x), 1e-6);
    float fine = grid_share(x, w, 0.02);
    float strong = grid_share(x * 0.1, w * 0.1, 0.004);
    vec3 albedo = mix(color, line_color, min(0.45 * fine + 0.55 * strong, 1.0));

    float n_l = max(dot(normal, frame.to_sun.xyz), 0.0);
#if SHADOWED
    float sunlit = n_l * sunlight(world_position, normal);
    float open = texture(occlusion, floor_position * occlusion_place.xy + occlusion_place.zw).r;
#else
    float sunlit = n_l;
    const float open = 1.0;
#endif
    vec3 radiance = albedo * (frame.sun.rgb * sunlit + ambient_irradiance(normal.z) * open);

    // Aerial perspective: far ground takes the colour of the horizon behind it.
    vec3 to_eye = frame.eye.xyz - world_position;
    float far2 = dot(to_eye, to_eye) / (frame.sky_horizon.w * frame.sky_horizon.w);
    float near = (1.0 - min(far2, 1.0)) / (1.0 + 12.0 * far2);
    pixel = vec4(tone_mapped(mix(frame.sky_horizon.rgb, radiance, near)), 1.0);
    part = id;
}
