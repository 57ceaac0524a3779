// Floor with a metric grid in a pool of light; fades into the sky with distance. SHADOWED: 1 in the inner part.
#include "common_light.glsl"
#include "common_pattern.glsl"
#include "common_shadow.glsl"

in vec2 floor_position;
flat in vec3 eye_place;
#if SHADOWED
in vec3 shadow_place;
in vec2 occlusion_place;
#endif
flat in vec2 grid_shift;
flat in vec3 color_root;
flat in vec3 line_color_root;
flat in vec3 sunlit_radiance;
flat in vec3 ambient;
flat in uint part_id;

uniform sampler2D occlusion;    // open share of the sky

layout(location = 0) out vec4 pixel;
layout(location = 1) out uint part;

// Share of a pixel of width w that lines of the given width cover at whole numbers of x. Only the nearest line
// counts: where a pixel holds several, lines fade, without a pattern of their own.
vec2 near_line_share(vec2 x, vec2 w, vec2 inverse_w, float width) {
    vec2 distance = abs(x - floor(x + 0.5));
    return clamp((0.5 * (width + w) - distance) * inverse_w, vec2(0.0), min(vec2(1.0), width * inverse_w));
}

void main() {
    vec2 x = floor_position / grid_spacing + grid_shift;
    vec2 w = max(pixel_width(x), 1e-6);
    vec2 inverse_w = 1.0 / w;
    vec2 fine = near_line_share(x, w, inverse_w, 0.02);
    vec2 strong = near_line_share(x * 0.1, w * 0.1, inverse_w * 10.0, 0.004);
    vec2 lines = min(0.45 * fine + 0.55 * strong, 1.0);
    // Mixed as edges are, close to display values.
    vec3 root = mix(color_root, line_color_root, max(lines.x, lines.y));
    vec3 albedo = root * root;

#if SHADOWED
    float open = texture(occlusion, occlusion_place).r;
    vec3 radiance = albedo * (sunlit_radiance * sunlight(shadow_place) + ambient * open);
#else
    vec3 radiance = albedo * (sunlit_radiance + ambient);
#endif

    // A pool of light around what the camera looks at, half as bright at 0.2 of the floor's extent; and aerial
    // perspective: far ground takes the colour of the horizon behind it.
    const float per_extent2 = 1.0 / (floor_extent * floor_extent);
    vec2 to_eye = eye_place.xy - floor_position;
    float far2 = min((dot(to_eye, to_eye) + eye_place.z) * per_extent2, 1.0);
    float pool = 1.0 + 25.0 * per_extent2 * dot(floor_position, floor_position);
    float near = (1.0 - far2) / (pool * (1.0 + 12.0 * far2));
    pixel = vec4(tone_mapped(sky_horizon * (1.0 - near * pool) + radiance * near), 1.0);
    part = part_id;
}
