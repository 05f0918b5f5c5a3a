#include "nodes/dynamics/rigid_step.hpp"

#include <algorithm>

#include <Eigen/LU>

namespace tactor {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Vector3d eigen(const Vec3& v) {
  return {v.x, v.y, v.z};
}
Vec3 plain(const Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

Matrix3d skew(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Matrix3d matrix(const Quat& q) {
  Matrix3d m;
  m << 1 - 2 * (q.y * q.y + q.z * q.z), 2 * (q.x * q.y - q.w * q.z), 2 * (q.x * q.z + q.w * q.y),  //
      2 * (q.x * q.y + q.w * q.z), 1 - 2 * (q.x * q.x + q.z * q.z), 2 * (q.y * q.z - q.w * q.x),   //
      2 * (q.x * q.z - q.w * q.y), 2 * (q.y * q.z + q.w * q.x), 1 - 2 * (q.x * q.x + q.y * q.y);
  return m;
}

Matrix3d inertia_W(const ToolModel& model, const Quat& R_WT) {
  const Matrix3d R = matrix(R_WT);
  return R * model.inertia_T * R.transpose();
}

/// The force of one contact on the tool, and how it falls with the velocity of the contact point.
struct ContactForce {
  Vec3 force;
  double normal_slope = 0;      // N s/m along the normal
  double tangential_slope = 0;  // N s/m across it
};

ContactForce contact_force(const Contact& c, const Vec3& moved, const Vec3& u, double h, double stick_velocity) {
  const double k = c.stiffness * c.weight, b = c.damping * c.weight;
  const double speed = dot(c.n_W, u);
  const double normal = -k * (c.distance + dot(c.n_W, moved)) - b * speed;
  if (normal <= 0) return {};
  const Vec3 u_t = u - speed * c.n_W;
  const double viscosity = c.friction * normal / std::max(norm(u_t), stick_velocity);
  return {normal * c.n_W - viscosity * u_t, h * k + b, viscosity};
}

/// The unknown is the velocity at the end of the step: Size 3, or 6 with rotation.
template <int Size>
class Solver {
  using Matrix = Eigen::Matrix<double, Size, Size>;
  using Vector = Eigen::Matrix<double, Size, 1>;
  static constexpr bool rotates = Size == 6;

 public:
  Solver(const ToolModel& model, const CouplingLaw& law, const DeviceState& device, const ContactPlanes& contacts,
         double h, const ToolState& before)
      : model_(model), law_(law), device_(device), contacts_(contacts), h_(h), before_(before) {
    if constexpr (rotates) {
      if (law.massless == 0) momentum_ = inertia_W(model, before.X_WT.R) * eigen(before.V_WT.w);
    }
  }

  StepResult run(ToolState& tool) {
    Vector velocity;
    velocity.template head<3>() = eigen(before_.V_WT.v);
    if constexpr (rotates) velocity.template tail<3>() = eigen(before_.V_WT.w);
    bool converged = false;
    for (int i = 0; i < model_.iterations; ++i) {
      evaluate(velocity);
      const Vector change = jacobian_.partialPivLu().solve(residual_);
      if (!change.allFinite()) return {};
      velocity -= change;
      const double relative = change.cwiseAbs().maxCoeff() / (1e-3 + velocity.cwiseAbs().maxCoeff());
      converged = relative <= 1e-4;
      if (relative <= 1e-12) break;
    }
    evaluate(velocity);
    if (!residual_.allFinite()) return {};
    tool = after_;
    return {true, converged, contact_, touching_};
  }

 private:
  /// Sets the state after the step, the residual and its Jacobian for this velocity.
  void evaluate(const Vector& velocity) {
    after_.V_WT.v = plain(velocity.template head<3>());
    after_.X_WT.p = before_.X_WT.p + h_ * after_.V_WT.v;
    after_.X_WT.R = before_.X_WT.R;
    if constexpr (rotates) {
      after_.V_WT.w = plain(velocity.template tail<3>());
      after_.X_WT.R = normalized(from_rotation_vector(h_ * after_.V_WT.w) * before_.X_WT.R);
    }
    jacobian_.setZero();
    residual_.setZero();
    add_inertia(velocity);
    add_coupling();
    add_contacts();
  }

  void add_inertia(const Vector& velocity) {
    if (law_.massless != 0) return;
    jacobian_.template topLeftCorner<3, 3>().diagonal().array() += model_.mass / h_;
    residual_.template head<3>() +=
        model_.mass * (eigen(after_.V_WT.v - before_.V_WT.v) / h_ - eigen(model_.gravity_W));
    if constexpr (rotates) {
      const Matrix3d inertia = inertia_W(model_, after_.X_WT.R);
      const Vector3d w = velocity.template tail<3>();
      const Vector3d momentum = inertia * w;
      residual_.template tail<3>() += (momentum - momentum_) / h_;
      jacobian_.template bottomRightCorner<3, 3>() += inertia / h_ + inertia * skew(w) - skew(momentum);
    }
  }

  void add_coupling() {
    const Vec3 force = law_.k_t * (device_.X_WD.p - after_.X_WT.p) + law_.b_t * (device_.V_WD.v - after_.V_WT.v);
    residual_.template head<3>() -= eigen(force);
    jacobian_.template topLeftCorner<3, 3>().diagonal().array() += h_ * law_.k_t + law_.b_t;
    if constexpr (rotates) {
      const Vec3 turn = to_rotation_vector(device_.X_WD.R * inverse(after_.X_WT.R));
      residual_.template tail<3>() -= eigen(law_.k_r * turn + law_.b_r * (device_.V_WD.w - after_.V_WT.w));
      jacobian_.template bottomRightCorner<3, 3>().diagonal().array() += h_ * law_.k_r + law_.b_r;
    }
  }

  void add_contacts() {
    contact_ = {};
    touching_ = 0;
    for (const Contact& c : contacts_.planes) {
      const Vec3 r = rotate(after_.X_WT.R, c.p_TC);
      const Vec3 moved = after_.X_WT.p + r - transform(contacts_.X_WT, c.p_TC);
      Vec3 u = after_.V_WT.v;
      if constexpr (rotates) u += cross(after_.V_WT.w, r);
      const ContactForce f = contact_force(c, moved, u, h_, model_.stick_velocity);
      if (f.normal_slope == 0) continue;
      ++touching_;
      contact_.force += f.force;
      const Vector3d n = eigen(c.n_W);
      const Matrix3d slope =
          f.tangential_slope * Matrix3d::Identity() + (f.normal_slope - f.tangential_slope) * n * n.transpose();
      residual_.template head<3>() -= eigen(f.force);
      jacobian_.template topLeftCorner<3, 3>() += slope;
      if constexpr (rotates) {
        const Vec3 torque = cross(r, f.force);
        contact_.torque += torque;
        residual_.template tail<3>() -= eigen(torque);
        const Matrix3d lever = skew(eigen(r));
        const Matrix3d coupled = slope * lever;
        jacobian_.template topRightCorner<3, 3>() -= coupled;
        jacobian_.template bottomLeftCorner<3, 3>() += lever * slope;
        jacobian_.template bottomRightCorner<3, 3>() -= lever * coupled;
      }
    }
  }

  const ToolModel& model_;
  const CouplingLaw& law_;
  const DeviceState& device_;
  const ContactPlanes& contacts_;
  double h_;
  const ToolState& before_;
  Vector3d momentum_ = Vector3d::Zero();
  ToolState after_;
  Matrix jacobian_;
  Vector residual_;
  Wrench contact_;
  int touching_ = 0;
};

}  // namespace

StepResult rigid_step(const ToolModel& model, const CouplingLaw& law, const DeviceState& device,
                      const ContactPlanes& contacts, double h, ToolState& tool) {
  const ToolState before = tool;
  const StepResult result = model.rotates ? Solver<6>(model, law, device, contacts, h, before).run(tool)
                                          : Solver<3>(model, law, device, contacts, h, before).run(tool);
  if (!result.solved) tool = {before.X_WT, {}};
  return result;
}

}  // namespace tactor
