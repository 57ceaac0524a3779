#include "common_light.glsl"

in vec3 direction;

layout(location = 0) out vec4 pixel;
layout(location = 1) out uint part;

void main() {
    pixel = vec4(tone_mapped(sky_radiance(normalize(direction).z)), 1.0);
    part = 0u;
}
