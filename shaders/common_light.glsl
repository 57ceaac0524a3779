// Sun, sky and tone curve. Radiance in units where a white matte surface shows sun * (n . l).

// Radiance of the sky towards a unit direction: bright above like the lamps of a studio, the horizon's colour behind.
vec3 sky_radiance(float z) {
    float up = clamp(z, 0.0, 1.0);
    return mix(sky_horizon, sky_zenith, up * up);
}

// Mean radiance a matte surface with normal n receives from sky and ground (irradiance / pi). Of the hemisphere it
// sees, the share (1 + n_z) / 2 is sky; the square of z in sky_radiance averages to (1 + n_z)^2 / 8: exact for
// surfaces that look up, down or aside.
vec3 ambient_irradiance(float n_z) {
    float up = 0.5 + 0.5 * n_z;
    return mix(ground_radiance, sky_horizon, up) +
           (sky_zenith - sky_horizon) * (0.5 * up * up);
}

// Radiance a glossy surface of the given roughness mirrors from direction z: sky above, ground below, the
// horizon as blurred as the highlight is.
vec3 mirrored_radiance(float z, float roughness) {
    float blur = 0.02 + roughness;
    vec3 sharp = mix(ground_radiance, sky_radiance(z), smoothstep(-blur, blur, z));
    return mix(sharp, ambient_irradiance(z), roughness * roughness);
}

// Filmic curve (Narkowicz 2015, "ACES Filmic Tone Mapping Curve") with the display's gamma of 2.2 included: one
// rational function of the square root, fitted to it within 0.003 from 0 to 7.
vec3 tone_mapped(vec3 radiance) {
    vec3 s = sqrt(radiance * exposure);
    vec3 top = s * (0.806942 + s * (0.662466 + s * 36.029703));
    return top / (1.0 + s * (5.355845 + s * (-0.989188 + s * 36.029703)));
}
