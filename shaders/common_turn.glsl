// x turned by the unit quaternion q (x y z w).
vec3 turned(vec4 q, vec3 x) {
    vec3 t = 2.0 * cross(q.xyz, x);
    return x + q.w * t + cross(q.xyz, t);
}
