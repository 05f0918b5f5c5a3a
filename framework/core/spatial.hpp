// Small trivially copyable vectors and rotations for messages, with the few operations every node needs.
#pragma once

#include <cmath>

namespace tactor {

/// A vector of three. The unit and the frame stand in the name of the variable that holds it (`p_WT`, `F_W`).
struct Vec3 {
  double x = 0, y = 0, z = 0;

  constexpr double& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
  constexpr double operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
  constexpr Vec3& operator+=(const Vec3& b) {
    x += b.x, y += b.y, z += b.z;
    return *this;
  }
  constexpr Vec3& operator-=(const Vec3& b) {
    x -= b.x, y -= b.y, z -= b.z;
    return *this;
  }
  constexpr Vec3& operator*=(double s) {
    x *= s, y *= s, z *= s;
    return *this;
  }
  constexpr bool operator==(const Vec3&) const = default;
};

constexpr Vec3 operator+(Vec3 a, const Vec3& b) {
  return a += b;
}
constexpr Vec3 operator-(Vec3 a, const Vec3& b) {
  return a -= b;
}
constexpr Vec3 operator-(const Vec3& a) {
  return {-a.x, -a.y, -a.z};
}
constexpr Vec3 operator*(Vec3 a, double s) {
  return a *= s;
}
constexpr Vec3 operator*(double s, Vec3 a) {
  return a *= s;
}
constexpr Vec3 operator/(Vec3 a, double s) {
  return a *= 1.0 / s;
}
constexpr double dot(const Vec3& a, const Vec3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
constexpr Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double norm(const Vec3& a) {
  return std::sqrt(dot(a, a));
}
/// `a` shortened to the length `most` where it is longer.
inline Vec3 limited(const Vec3& a, double most) {
  const double length = norm(a);
  return length > most ? (most / length) * a : a;
}
inline bool is_finite(const Vec3& a) {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}

/// A unit quaternion: the rotation R_AB that takes vectors expressed in B to A.
struct Quat {
  double w = 1, x = 0, y = 0, z = 0;
  constexpr bool operator==(const Quat&) const = default;
};

/// Composition: R_AC = R_AB R_BC.
constexpr Quat operator*(const Quat& a, const Quat& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}
constexpr Quat inverse(const Quat& q) {
  return {q.w, -q.x, -q.y, -q.z};
}

/// R_AB v_B: the vector expressed in A.
constexpr Vec3 rotate(const Quat& q, const Vec3& v) {
  const Vec3 u{q.x, q.y, q.z};
  const Vec3 t = 2.0 * cross(u, v);
  return v + q.w * t + cross(u, t);
}

inline Quat normalized(const Quat& q) {
  const double n = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return {q.w / n, q.x / n, q.y / n, q.z / n};
}

/// The rotation by |r| radians about r (exponential map).
inline Quat from_rotation_vector(const Vec3& r) {
  const double angle = norm(r);
  // sin(a/2)/a by its series near zero, where the quotient loses its digits.
  const double s = angle < 1e-4 ? 0.5 - angle * angle / 48.0 : std::sin(0.5 * angle) / angle;
  return normalized({std::cos(0.5 * angle), s * r.x, s * r.y, s * r.z});
}

/// The rotation vector in rad of the shorter way round, |r| <= pi (logarithm map).
inline Vec3 to_rotation_vector(Quat q) {
  if (q.w < 0) q = {-q.w, -q.x, -q.y, -q.z};
  const Vec3 u{q.x, q.y, q.z};
  const double s = norm(u);
  const double k = s < 1e-8 ? 2.0 / q.w : 2.0 * std::atan2(s, q.w) / s;
  return k * u;
}

/// Where frame B is in A: p_AB in m and R_AB.
struct Pose {
  Vec3 p;
  Quat R;
  constexpr bool operator==(const Pose&) const = default;
};

/// X_AC = X_AB X_BC.
constexpr Pose operator*(const Pose& a, const Pose& b) {
  return {a.p + rotate(a.R, b.p), a.R * b.R};
}
constexpr Pose inverse(const Pose& a) {
  return {rotate(inverse(a.R), -a.p), inverse(a.R)};
}
/// p_AQ from p_BQ.
constexpr Vec3 transform(const Pose& X_AB, const Vec3& p_BQ) {
  return X_AB.p + rotate(X_AB.R, p_BQ);
}

/// Linear velocity in m/s and angular velocity in rad/s, both expressed in the frame the motion is measured in.
struct Twist {
  Vec3 v;
  Vec3 w;
};

/// Force in N and torque in N m.
struct Wrench {
  Vec3 force;
  Vec3 torque;
};

constexpr Wrench operator+(const Wrench& a, const Wrench& b) {
  return {a.force + b.force, a.torque + b.torque};
}
constexpr Wrench operator-(const Wrench& a, const Wrench& b) {
  return {a.force - b.force, a.torque - b.torque};
}
constexpr Wrench operator*(double s, const Wrench& a) {
  return {s * a.force, s * a.torque};
}
inline bool is_finite(const Wrench& a) {
  return is_finite(a.force) && is_finite(a.torque);
}

}  // namespace tactor
