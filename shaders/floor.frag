// Floor with a metric grid; fades into the sky with distance.
#include "common_frame.glsl"
#include "common_light.glsl"

in vec3 world_position;
in vec2 grid_position;

uniform vec3 color;
uniform vec3 line_color;
uniform vec3 normal;

layout(location = 0) out vec4 pixel;

// Share of a pixel of width w covered by lines of the given width at whole numbers of x (box filter).
vec2 line_share(vec2 x, vec2 w, float width) {
    vec2 a = x + 0.5 * width - 0.5 * w;
    vec2 b = x + 0.5 * width + 0.5 * w;
    vec2 covered = floor(b) * width + min(fract(b), width) - floor(a) * width - min(fract(a), width);
    return clamp(covered / w, 0.0, 1.0);
}

float grid_share(vec2 x, vec2 w, float width) {
    vec2 share = line_share(x, w, width);
    return 1.0 - (1.0 - share.x) * (1.0 - share.y);
}

void main() {
    vec3 to_eye = frame.eye.xyz - world_position;
    float distance = length(to_eye);
    float spacing = frame.ground.w;
    vec2 x = grid_position / spacing;
    vec2 w = max(fwidth(x), 1e-6);
    float fine = grid_share(x, w, 0.02);
    float strong = grid_share(x * 0.1, w * 0.1, 0.004);
    vec3 albedo = mix(color, line_color, clamp(0.45 * fine + 0.55 * strong, 0.0, 1.0));

    float n_l = dot(normal, frame.to_sun.xyz);
    float sunlit = sunlight(world_position, normal, n_l);
    vec3 radiance = albedo * (frame.sun.rgb * (max(n_l, 0.0) * sunlit) + ambient_irradiance(normal.z));

    // Aerial perspective: far ground takes the colour of the sky behind it.
    vec3 behind = sky_radiance(-to_eye.z / distance);
    float fade = smoothstep(0.1, 1.0, distance / frame.sky_horizon.w);
    pixel = vec4(tone_mapped(mix(radiance, behind, fade)), 1.0);
}
