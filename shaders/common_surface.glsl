// Physically based surface: GGX with energy compensation over a matte base.

// Share of uniform light that a surface with F0 = 1 mirrors, split as F0 * x + y.
// Fit of the split-sum integral by Karis 2014, "Physically Based Shading on Mobile".
vec2 mirrored_share(float roughness, float n_v) {
    vec4 r = roughness * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
    float a = min(r.x * r.x, exp2(-9.28 * n_v)) * r.x + r.y;
    return vec2(-1.04, 1.04) * a + r.zw;
}

struct Surface {
    vec3 albedo;
    float metallic;
    float roughness;
    vec3 normal;
};

// Radiance towards v. sunlit: share of the sun; open: share of the sky (ambient occlusion).
// In uniform light with albedo 1 the result is that light: what is not mirrored reaches the base.
vec3 shaded(Surface surface, vec3 v, float sunlit, float open) {
    vec3 n = surface.normal;
    float roughness = surface.roughness;
    float n_v = max(abs(dot(n, v)), 1e-3);
    float n_l = clamp(dot(n, frame.to_sun.xyz), 0.0, 1.0);
    vec3 f0 = mix(vec3(0.04), surface.albedo, surface.metallic);
    vec2 share = mirrored_share(roughness, n_v);
    // Multiple scattering between facets (Turquin 2019): what single scattering loses is given back.
    vec3 compensation = 1.0 + f0 * (1.0 / (share.x + share.y) - 1.0);
    vec3 mirrored = (f0 * share.x + share.y) * compensation;
    vec3 base = surface.albedo * (1.0 - surface.metallic) * (1.0 - mirrored);

    // Direct light: D and V of GGX (Walter et al. 2007; Smith term as approximated by Hammon 2017).
    vec3 h = normalize(v + frame.to_sun.xyz);
    float n_h = clamp(dot(n, h), 0.0, 1.0);
    float l_h = clamp(dot(frame.to_sun.xyz, h), 0.0, 1.0);
    float a = roughness * roughness;
    float a2 = a * a;
    float d = n_h * n_h * (a2 - 1.0) + 1.0;
    float visibility = 0.5 / mix(2.0 * n_l * n_v, n_l + n_v, a);
    float m = 1.0 - l_h;
    float m2 = m * m;
    vec3 fresnel = f0 + (1.0 - f0) * (m2 * m2 * m);
    vec3 direct = base + fresnel * compensation * (a2 * visibility / (d * d));

    vec3 r = reflect(-v, n);
    vec3 ambient = base * ambient_irradiance(n.z) + mirrored * mirrored_radiance(r.z, roughness);
    return frame.sun.rgb * (direct * (n_l * sunlit)) + ambient * open;
}
