// Bodies. PATTERN: 0 plain, 1 stripes, 2 checker, 3 grid, in body coordinates so that turning is seen.
// ROUND: 1 for bodies of revolution, patterned around z; 0 for boxes.
#include "common_frame.glsl"
#include "common_light.glsl"
#include "common_surface.glsl"

in vec3 world_position;
in vec3 body_position;
in vec3 world_normal;
flat in vec4 color_roughness;
flat in vec4 pattern_metallic;
flat in vec3 body_scale;

layout(location = 0) out vec4 pixel;

// Square wave of period 2 in x, 0 on (0,1) and 1 on (1,2), averaged over the width w of a pixel.
float square_wave(float x, float w) {
    w = max(w, 1e-5);
    vec2 ends = (vec2(x - 0.5 * w, x + 0.5 * w)) * 0.5;
    // Integral of the wave from 0 to 2 t, t in periods.
    vec2 integral = floor(ends) + max(2.0 * fract(ends) - 1.0, 0.0);
    return clamp((integral.y - integral.x) / w, 0.0, 1.0);
}

// Exclusive or of two averaged waves.
float either(float a, float b) { return a + b - 2.0 * a * b; }

float pattern_share() {
#if PATTERN == 0
    return 0.0;
#else
#if ROUND
    // Sectors around z; at the jump of the angle from pi to -pi the derivative is taken from the other half.
    const float sectors = 4.0;
    float angle = atan(body_position.y, body_position.x) * (sectors / 3.14159265);
    float other = atan(-body_position.y, -body_position.x) * (sectors / 3.14159265);
    float w = min(fwidth(angle), fwidth(other));
    float radius = max(length(body_position), 1e-9);
    float height = body_position.z / radius;
#if PATTERN == 1
    return square_wave(angle, w);
#elif PATTERN == 2
    float z = (height + 4.0) * 2.0;
    return either(square_wave(angle, w), square_wave(z, fwidth(z)));
#else
    float line = square_wave(angle * 2.0, 2.0 * w);
    return line * 0.0 + square_wave((height + 4.0) * 4.0, fwidth(height) * 4.0);
#endif
#else
    vec3 p = body_position / (2.0 * body_scale) + 0.5;
#if PATTERN == 1
    float x = p.x * 8.0;
    return square_wave(x, fwidth(x));
#elif PATTERN == 2
    vec3 c = p * 4.0 + 1e-4;
    vec3 w = fwidth(c);
    return either(either(square_wave(c.x, w.x), square_wave(c.y, w.y)), square_wave(c.z, w.z));
#else
    // Lines of a sixteenth of a cell, four cells a side: two waves overlap only in the lines.
    vec3 c = p * 4.0;
    vec3 w = fwidth(c);
    vec3 line = clamp((0.5 * w + 0.06 - abs(fract(c + 0.5) - 0.5)) / max(w, 1e-5), 0.0, 1.0);
    vec3 across = 1.0 - smoothstep(0.999, 1.0, abs(body_position / body_scale));
    line *= across;
    return 1.0 - (1.0 - line.x) * (1.0 - line.y) * (1.0 - line.z);
#endif
#endif
#endif
}

void main() {
    vec3 n = normalize(world_normal);
    vec3 v = normalize(frame.eye.xyz - world_position);
    vec3 albedo = mix(color_roughness.rgb, pattern_metallic.rgb, pattern_share());
    float n_l = dot(n, frame.to_sun.xyz);
    float sunlit = sunlight(world_position, n, n_l);
    vec3 radiance = shaded(albedo, pattern_metallic.w, color_roughness.w, n, v, sunlit, 1.0);
    pixel = vec4(tone_mapped(radiance), 1.0);
}
