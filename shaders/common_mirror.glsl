// What a polished ball sees: other balls, boxes and the floor, once, by following mirrored rays. What it sees is small
// and its edges are sharp: four rays a pixel, a quarter of a pixel from its centre, smooth them.
// MIRRORED_SPHERES, MIRRORED_BOXES: how many there are.

layout(std140, binding = 1) uniform Mirrored {   // MirroredBlock of mirrored.h
    vec4 spheres[32];
    vec4 boxes[3 * 32];
    vec4 looks[32];
} mirrored;
uniform int mirrored_rays;   // 4: known when it runs, so that the loop stays one and is compiled once

struct MirrorHit {
    float distance;
    vec3 normal;   // of any length
    vec4 color_metallic;
};

void meet_spheres(vec3 origin, vec3 ray, inout MirrorHit hit) {
    for (int i = 0; i < MIRRORED_SPHERES; ++i) {
        vec4 sphere = mirrored.spheres[i];
        vec3 o = origin - sphere.xyz;
        float b = dot(o, ray);
        float d = b * b - dot(o, o) + sphere.w * sphere.w;
        float t = -b - sqrt(max(d, 0.0));
        bool is_nearer = d > 0.0 && t > 1e-3 * sphere.w && t < hit.distance;
        hit.distance = is_nearer ? t : hit.distance;
        hit.normal = is_nearer ? o + ray * t : hit.normal;
        hit.color_metallic = is_nearer ? mirrored.looks[i] : hit.color_metallic;
    }
}

void meet_boxes(vec3 origin, vec3 ray, inout MirrorHit hit) {
    for (int i = 0; i < MIRRORED_BOXES; ++i) {
        vec4 x = mirrored.boxes[3 * i];
        vec4 y = mirrored.boxes[3 * i + 1];
        vec4 z = mirrored.boxes[3 * i + 2];
        vec3 o = vec3(dot(x.xyz, origin) + x.w, dot(y.xyz, origin) + y.w, dot(z.xyz, origin) + z.w);
        vec3 r = vec3(dot(x.xyz, ray), dot(y.xyz, ray), dot(z.xyz, ray));
        // Where the ray enters the three slabs, and where it leaves them.
        vec3 inverse = 1.0 / (r + vec3(lessThan(abs(r), vec3(1e-7))) * 1e-7);
        vec3 reach = abs(inverse);
        vec3 enter = -o * inverse - reach;
        vec3 leave = -o * inverse + reach;
        float t = max(max(enter.x, enter.y), enter.z);
        bool is_nearer = t > 0.0 && t < min(min(leave.x, leave.y), leave.z) && t < hit.distance;
        vec3 side = -sign(r) * vec3(greaterThanEqual(enter, vec3(t)));
        hit.distance = is_nearer ? t : hit.distance;
        hit.normal = is_nearer ? x.xyz * side.x + y.xyz * side.y + z.xyz * side.z : hit.normal;
        hit.color_metallic = is_nearer ? mirrored.looks[MIRRORED_SPHERES + i] : hit.color_metallic;
    }
}

// Radiance that arrives at `origin` from the unit direction `ray`.
vec3 radiance_along(vec3 origin, vec3 ray, float roughness) {
    const float nothing = 1e30;
    MirrorHit hit = MirrorHit(nothing, vec3(0.0, 0.0, 1.0), vec4(0.0));
    float toward_floor = dot(floor_plane.xyz, ray);
    if (toward_floor < -1e-4) {
        hit.distance = (floor_plane.w - dot(floor_plane.xyz, origin)) / toward_floor;
        hit.normal = floor_plane.xyz;
        hit.color_metallic = vec4(floor_color, 0.0);
    }
    meet_spheres(origin, ray, hit);
    meet_boxes(origin, ray, hit);
    vec3 normal = normalize(hit.normal);
    vec3 sky = mirrored_radiance(ray.z, roughness);
    float n_l = dot(normal, to_sun);
    vec3 place = origin + ray * hit.distance + normal * shadow_offset;
    float sunlit = n_l > 0.0 ? n_l * sunlight((shadow_from_world * vec4(place, 1.0)).xyz) : 0.0;
    vec3 matte = hit.color_metallic.rgb * (sun_radiance * sunlit + ambient_irradiance(normal.z));
    // A second mirroring sees sky and ground only; a matte surface shows 0.06 of it.
    float again_z = ray.z - 2.0 * dot(ray, normal) * normal.z;
    vec3 again = mirrored_radiance(again_z, 0.3);
    vec3 seen = mix(matte + 0.06 * again, hit.color_metallic.rgb * again, hit.color_metallic.w);
    // The floor fades towards the horizon as it does in the picture.
    float far = min(hit.distance / floor_extent, 1.0);
    return hit.distance < nothing ? mix(seen, sky, 12.0 * far * far / (1.0 + 12.0 * far * far)) : sky;
}

// The mean over the pixel of what arrives at `position` to be mirrored towards v, where the surface has normal n.
vec3 seen_radiance(vec3 position, vec3 n, vec3 v, float roughness) {
    vec3 across = dFdx(position);
    vec3 up = dFdy(position);
    vec3 n_across = dFdx(n);
    vec3 n_up = dFdy(n);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < mirrored_rays; ++i) {
        // A square turned by 27 degrees: each ray has a row and a column of its own.
        vec2 at = 0.125 * vec2(i == 0 ? -1.0 : i == 1 ? 3.0 : i == 2 ? 1.0 : -3.0,
                               i == 0 ? -3.0 : i == 1 ? -1.0 : i == 2 ? 3.0 : 1.0);
        vec3 normal = normalize(n + n_across * at.x + n_up * at.y);
        sum += radiance_along(position + across * at.x + up * at.y, reflect(-v, normal), roughness);
    }
    return sum / float(mirrored_rays);
}
