// Averaged over a pixel, so that patterns neither flicker nor crawl.

// Width of a pixel in x: that of the box over which x varies as much, in the mean square, as over the pixel.
float pixel_width(float x) { return length(vec2(dFdx(x), dFdy(x))); }
vec2 pixel_width(vec2 x) { return vec2(pixel_width(x.x), pixel_width(x.y)); }
vec3 pixel_width(vec3 x) { return vec3(pixel_width(x.xy), pixel_width(x.z)); }

// Square wave of period 2 in x, 0 on (0,1) and 1 on (1,2), averaged over the width w of a pixel.
float square_wave(float x, float w) {
    w = max(w, 1e-5);
    vec2 ends = vec2(x - 0.5 * w, x + 0.5 * w) * 0.5;
    // Integral of the wave from 0 to 2 t, t in periods.
    vec2 integral = floor(ends) + max(2.0 * fract(ends) - 1.0, 0.0);
    return clamp((integral.y - integral.x) / w, 0.0, 1.0);
}

// Share of a pixel of width w covered by lines of the given width at whole numbers of x.
vec2 line_share(vec2 x, vec2 w, float width) {
    vec2 a = x + 0.5 * width - 0.5 * w;
    vec2 b = a + w;
    vec2 covered = floor(b) * width + min(fract(b), width) - floor(a) * width - min(fract(a), width);
    return clamp(covered / w, 0.0, 1.0);
}

// Exclusive or, and union, of two averaged patterns.
float either(float a, float b) { return a + b - 2.0 * a * b; }
float joined(float a, float b) { return a + b - a * b; }
