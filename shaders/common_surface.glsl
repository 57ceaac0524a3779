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
    vec3 ambient;   // ambient_irradiance of the normal
};

// What is mirrored has one value for all colours unless the surface is a metal (METAL 1).
#if METAL
#define REFLECTANCE vec3
#else
#define REFLECTANCE float
#endif

// Radiance towards v. sunlit: share of the sun; open: share of the sky (ambient occlusion).
// In uniform light with albedo 1 the result is that light: what is not mirrored reaches the base.
vec3 shaded(Surface surface, vec3 v, float sunlit, float open) {
    vec3 n = surface.normal;
    vec3 l = to_sun;
    float roughness = surface.roughness;
    float n_dot_v = dot(n, v);
    float n_v = max(abs(n_dot_v), 1e-3);
    float n_l = clamp(dot(n, l), 0.0, 1.0);
    vec2 share = mirrored_share(roughness, n_v);
    float coat = 0.04 * share.x + share.y;
#if METAL
    vec3 f0 = mix(vec3(0.04), surface.albedo, surface.metallic);
    // Multiple scattering between a metal's facets (Turquin 2019): what single scattering loses is given back.
    vec3 gain = 1.0 + surface.albedo * (1.0 / (share.x + share.y) - 1.0);
    vec3 compensation = mix(vec3(1.0), gain, surface.metallic);
    vec3 mirrored = mix(vec3(coat), (surface.albedo * share.x + share.y) * gain, surface.metallic);
    vec3 base = surface.albedo * ((1.0 - surface.metallic) * (1.0 - coat));
#else
    const float f0 = 0.04;
    const float compensation = 1.0;
    float mirrored = coat;
    vec3 base = surface.albedo * (1.0 - coat);
#endif

    // Direct light: D and V of GGX (Walter et al. 2007; Smith term as approximated by Hammon 2017), with the half
    // vector h = (v + l) / |v + l| written out: |v + l|^2 = 2 + 2 v.l and l.h = |v + l| / 2.
    float half_length2 = max(2.0 + 2.0 * dot(v, l), 1e-4);
    float n_h = n_dot_v + dot(n, l);
    float a = roughness * roughness;
    float a2 = a * a;
    float d = n_h * n_h / half_length2 * (a2 - 1.0) + 1.0;
    float highlight = 0.5 * a2 / (mix(2.0 * n_l * n_v, n_l + n_v, a) * d * d + 1e-7);
    float m = 1.0 - 0.5 * sqrt(half_length2);
    float m2 = m * m;
    REFLECTANCE fresnel = (f0 + (1.0 - f0) * (m2 * m2 * m)) * compensation;

#if MIRROR
    vec3 seen = seen_radiance(world_position, n, v, roughness);
#else
    vec3 seen = mirrored_radiance(2.0 * n_dot_v * n.z - v.z, roughness);
#endif
    vec3 sun = sun_radiance * (n_l * sunlit);
    // What stands close by is in the mirrored view already.
    float seen_open = MIRROR == 1 ? 1.0 : open;
    vec3 from_base = base * (sun + surface.ambient * open);
    return from_base + sun * (fresnel * highlight) + seen * (mirrored * seen_open);
}
