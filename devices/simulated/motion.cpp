#include "devices/simulated/motion.hpp"

namespace tactor {

namespace {

struct Curve {
  Vec3 value;
  Vec3 rate;
};

/// The cubic from y0 with rate m0 to y1 with rate m1 over dt seconds.
Curve hermite(const Vec3& y0, const Vec3& m0, const Vec3& y1, const Vec3& m1, double dt, double s) {
  const double r = 1.0 - s;
  const Vec3 value =
      (r * r * (1.0 + 2.0 * s)) * y0 + (s * s * (3.0 - 2.0 * s)) * y1 + dt * ((s * r * r) * m0 - (s * s * r) * m1);
  const Vec3 rate = (6.0 * s * r / dt) * (y1 - y0) + (r * (1.0 - 3.0 * s)) * m0 + (s * (3.0 * s - 2.0)) * m1;
  return {value, rate};
}

}  // namespace

MotionState interpolate(const MotionState& a, const MotionState& b, double dt, double s, bool rotate) {
  if (dt <= 0) return b;
  const Curve p = hermite(a.X.p, a.V.v, b.X.p, b.V.v, dt, s);
  MotionState result{{p.value, b.X.R}, {p.rate, {}}};
  if (rotate) {
    const Vec3 arc_W = to_rotation_vector(b.X.R * inverse(a.X.R));
    const Curve r = hermite({}, a.V.w, arc_W, b.V.w, dt, s);
    result.X.R = from_rotation_vector(r.value) * a.X.R;
    result.V.w = r.rate;
  }
  return result;
}

}  // namespace tactor
