// Floor with a metric grid in a pool of light; fades into the sky with distance. SHADOWED: 1 in the inner part.
// Most of a picture is floor: what is linear in the place on the floor, or the same all over it, comes as a uniform.
#include "common_frame.glsl"
#include "common_light.glsl"
#include "common_shadow.glsl"

in vec2 floor_position;         // [m]

uniform vec4 grid_place;        // place in the grid [lines] = floor_position * xy + zw
uniform vec3 color_root;        // square roots of the colours
uniform vec3 line_color_root;
uniform vec3 sun_radiance;      // that a white floor shows of the sun alone
uniform vec3 ambient_radiance;  // and of the sky alone
uniform vec3 shadow_origin;     // place in the shadow map of floor_position = 0, and its change per metre
uniform vec3 shadow_along;
uniform vec3 shadow_across;
uniform vec3 eye_place;         // floor_position below the eye [m], and its height squared [m^2]
uniform sampler2D occlusion;    // open share of the sky
uniform vec4 occlusion_place;   // texture coordinates = floor_position * xy + zw
uniform uint id;

layout(location = 0) out vec4 pixel;
layout(location = 1) out uint part;

// Share of a pixel of width w that lines of the given width cover at whole numbers of x. Only the nearest line
// counts: where a pixel holds several, lines fade, without a pattern of their own.
vec2 near_line_share(vec2 x, vec2 w, vec2 inverse_w, float width) {
    vec2 distance = abs(x - floor(x + 0.5));
    return clamp((0.5 * (width + w) - distance) * inverse_w, vec2(0.0), min(vec2(1.0), width * inverse_w));
}

void main() {
    vec2 x = floor_position * grid_place.xy + grid_place.zw;
    vec2 w = max(fwidth(x), 1e-6);
    vec2 inverse_w = 1.0 / w;
    vec2 fine = near_line_share(x, w, inverse_w, 0.02);
    vec2 strong = near_line_share(x * 0.1, w * 0.1, inverse_w * 10.0, 0.004);
    vec2 lines = min(0.45 * fine + 0.55 * strong, 1.0);
    // Mixed as edges are, close to display values.
    vec3 root = mix(color_root, line_color_root, max(lines.x, lines.y));
    vec3 albedo = root * root;

#if SHADOWED
    float sunlit = sunlight_at(shadow_origin + shadow_along * floor_position.x + shadow_across * floor_position.y);
    float open = texture(occlusion, floor_position * occlusion_place.xy + occlusion_place.zw).r;
    vec3 radiance = albedo * (sun_radiance * sunlit + ambient_radiance * open);
#else
    vec3 radiance = albedo * (sun_radiance + ambient_radiance);
#endif

    // A pool of light around what the camera looks at, half as bright at 0.2 of the floor's extent; and aerial
    // perspective: far ground takes the colour of the horizon behind it.
    float per_extent2 = 1.0 / (frame.sky_horizon.w * frame.sky_horizon.w);
    vec2 from_eye = floor_position - eye_place.xy;
    float far2 = min((dot(from_eye, from_eye) + eye_place.z) * per_extent2, 1.0);
    float pool = 1.0 + 25.0 * per_extent2 * dot(floor_position, floor_position);
    float near = (1.0 - far2) / (pool * (1.0 + 12.0 * far2));
    pixel = vec4(tone_mapped(frame.sky_horizon.rgb * (1.0 - near * pool) + radiance * near), 1.0);
    part = id;
}
