// What a polished ball sees: other balls, boxes and the floor, once, by following the mirrored ray.

uniform samplerBuffer mirrored_parts;   // Instance of draw_types.h, five texels each: spheres first, then boxes
uniform int mirrored_spheres;
uniform int mirrored_count;

struct MirrorHit {
    float distance;
    vec3 normal;
    vec4 color_metallic;
};

void meet_sphere(int first, vec3 origin, vec3 ray, inout MirrorHit hit) {
    vec4 place = texelFetch(mirrored_parts, first + 1);
    vec4 scale_metallic = texelFetch(mirrored_parts, first + 2);
    vec3 o = origin - place.xyz;
    float b = dot(o, ray);
    float d = b * b - dot(o, o) + scale_metallic.x * scale_metallic.x;
    float t = -b - sqrt(max(d, 0.0));
    if (d > 0.0 && t > 1e-3 * scale_metallic.x && t < hit.distance) {
        hit.distance = t;
        hit.normal = (o + ray * t) / scale_metallic.x;
        hit.color_metallic = vec4(texelFetch(mirrored_parts, first + 3).rgb, scale_metallic.w);
    }
}

void meet_box(int first, vec3 origin, vec3 ray, inout MirrorHit hit) {
    vec4 q = texelFetch(mirrored_parts, first);
    vec4 q_back = vec4(-q.xyz, q.w);
    vec4 scale_metallic = texelFetch(mirrored_parts, first + 2);
    vec3 o = turned(q_back, origin - texelFetch(mirrored_parts, first + 1).xyz);
    vec3 r = turned(q_back, ray);
    // Where the ray enters the three slabs, and where it leaves them.
    vec3 inverse = 1.0 / (r + vec3(lessThan(abs(r), vec3(1e-7))) * 1e-7);
    vec3 reach = scale_metallic.xyz * abs(inverse);
    vec3 enter = -o * inverse - reach;
    vec3 leave = -o * inverse + reach;
    float t = max(max(enter.x, enter.y), enter.z);
    if (t > 0.0 && t < min(min(leave.x, leave.y), leave.z) && t < hit.distance) {
        hit.distance = t;
        hit.normal = turned(q, -sign(r) * vec3(greaterThanEqual(enter, vec3(t))));
        hit.color_metallic = vec4(texelFetch(mirrored_parts, first + 3).rgb, scale_metallic.w);
    }
}

// Radiance that arrives at `origin` from direction `ray`.
vec3 seen_radiance(vec3 origin, vec3 ray, float roughness) {
    const float nothing = 1e30;
    MirrorHit hit = MirrorHit(nothing, vec3(0.0, 0.0, 1.0), vec4(0.0));
    float toward_floor = dot(floor_plane.xyz, ray);
    if (toward_floor < -1e-4) {
        hit.distance = (floor_plane.w - dot(floor_plane.xyz, origin)) / toward_floor;
        hit.normal = floor_plane.xyz;
        hit.color_metallic = vec4(floor_color, 0.0);
    }
    for (int i = 0; i < mirrored_spheres; ++i) {
        meet_sphere(5 * i, origin, ray, hit);
    }
    for (int i = mirrored_spheres; i < mirrored_count; ++i) {
        meet_box(5 * i, origin, ray, hit);
    }
    vec3 sky = mirrored_radiance(ray.z, roughness);
    float n_l = dot(hit.normal, to_sun);
    vec3 place = origin + ray * hit.distance + hit.normal * shadow_offset;
    float sunlit = n_l > 0.0 ? n_l * sunlight((shadow_from_world * vec4(place, 1.0)).xyz) : 0.0;
    vec3 matte = hit.color_metallic.rgb * (sun_radiance * sunlit + ambient_irradiance(hit.normal.z));
    // A second mirroring sees sky and ground only; a matte surface shows 0.06 of it.
    float again_z = ray.z - 2.0 * dot(ray, hit.normal) * hit.normal.z;
    vec3 again = mirrored_radiance(again_z, 0.3);
    vec3 seen = mix(matte + 0.06 * again, hit.color_metallic.rgb * again, hit.color_metallic.w);
    // The floor fades towards the horizon as it does in the picture.
    float far = min(hit.distance / floor_extent, 1.0);
    return hit.distance < nothing ? mix(seen, sky, 12.0 * far * far / (1.0 + 12.0 * far * far)) : sky;
}
