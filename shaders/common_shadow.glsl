// The shadow map: depths of the far sides of all bodies, seen from the sun.

uniform sampler2DShadow shadow_map;

#if !SOFT_SHADOWS
// Share 0..1 of the sun that reaches a place in the map, p: texture coordinates and depth. Four texels, interpolated.
float sunlight(vec3 p) {
    return texture(shadow_map, vec3(p.xy, min(p.z, 1.0)));
}
#else
// The same by a tent filter over 4 x 4 texels from four gathers: continuous in position, so edges do not crawl.
float sunlight(vec3 p) {
    vec2 texel = p.xy * shadow_map_size - 0.5;
    vec2 f = fract(texel);
    vec2 base = (floor(texel) + 0.5) / shadow_map_size;
    float step_size = 1.0 / shadow_map_size;
    float depth = min(p.z, 1.0);
    // Gathers at the corners of four 2 x 2 blocks; components: (0,1) (1,1) (1,0) (0,0).
    vec2 at = base + 0.5 * step_size;
    vec4 a = textureGather(shadow_map, at + vec2(-1.0, -1.0) * step_size, depth);
    vec4 b = textureGather(shadow_map, at + vec2(1.0, -1.0) * step_size, depth);
    vec4 c = textureGather(shadow_map, at + vec2(-1.0, 1.0) * step_size, depth);
    vec4 d = textureGather(shadow_map, at + vec2(1.0, 1.0) * step_size, depth);
    // Tent weights of columns and rows: 1 - f, 2 - f, 1 + f, f.
    vec4 wx = vec4(1.0 - f.x, 2.0 - f.x, 1.0 + f.x, f.x);
    vec4 wy = vec4(1.0 - f.y, 2.0 - f.y, 1.0 + f.y, f.y);
    float row0 = a.w * wx.x + a.z * wx.y + b.w * wx.z + b.z * wx.w;
    float row1 = a.x * wx.x + a.y * wx.y + b.x * wx.z + b.y * wx.w;
    float row2 = c.w * wx.x + c.z * wx.y + d.w * wx.z + d.z * wx.w;
    float row3 = c.x * wx.x + c.y * wx.y + d.x * wx.z + d.y * wx.w;
    return dot(vec4(row0, row1, row2, row3), wy) * (1.0 / 16.0);
}
#endif
