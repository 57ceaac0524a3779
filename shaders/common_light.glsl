// Sun, sky and tone curve. Radiance in units where a white matte surface shows sun * (n . l).

// Radiance of the sky towards a unit direction with z >= 0.
vec3 sky_radiance(float z) {
    float t = 1.0 - clamp(z, 0.0, 1.0);
    return mix(frame.sky_zenith.rgb, frame.sky_horizon.rgb, t * t);
}

// Mean radiance a matte surface with normal n receives from sky and ground (irradiance / pi).
vec3 ambient_irradiance(float n_z) {
    // Cosine-weighted mean of sky_radiance over the upper hemisphere: (1 - z)^2 averages to 1/6.
    vec3 sky = mix(frame.sky_zenith.rgb, frame.sky_horizon.rgb, 1.0 / 6.0);
    return mix(frame.ground.rgb, sky, 0.5 + 0.5 * n_z);
}

// Radiance a glossy surface of the given roughness mirrors from direction z: sky above, ground below, the
// horizon as blurred as the highlight is.
vec3 mirrored_radiance(float z, float roughness) {
    float blur = 0.02 + roughness;
    vec3 sharp = mix(frame.ground.rgb, sky_radiance(z), smoothstep(-blur, blur, z));
    return mix(sharp, ambient_irradiance(z), roughness * roughness);
}

// Filmic curve (Narkowicz 2015, "ACES Filmic Tone Mapping Curve") with the display's gamma of 2.2 included: one
// rational function of the square root, fitted to it within 0.003 from 0 to 7.
vec3 tone_mapped(vec3 radiance) {
    vec3 s = sqrt(radiance * frame.eye.w);
    vec3 top = s * (0.806942 + s * (0.662466 + s * 36.029703));
    return top / (1.0 + s * (5.355845 + s * (-0.989188 + s * 36.029703)));
}
