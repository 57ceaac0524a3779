#include "sim/base/math.h"

#include <cmath>

namespace sim {

Quat rotation_between(const Vec3& from, const Vec3& to) {
    constexpr double opposite = 1e-12; // of 1 + cosine
    const Vec3 a = from.normalized();
    const Vec3 b = to.normalized();
    const double cosine = b.dot(a);
    Quat q;
    if (cosine < -1.0 + opposite) {
        q.w() = 0.0;
        q.vec() = a.unitOrthogonal();
        return q;
    }
    const double twice_w = std::sqrt(2.0 * (1.0 + cosine));
    q.vec() = a.cross(b) * (1.0 / twice_w);
    q.w() = 0.5 * twice_w;
    return q;
}

} // namespace sim
