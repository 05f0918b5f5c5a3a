// The equations of one step of rigid bodies (rigid_step.hpp), with their derivatives.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <type_traits>

#include <Eigen/LU>

#include "nodes/physics/mechanics/eigen.hpp"
#include "nodes/physics/mechanics/free_rotation.hpp"
#include "nodes/physics/mechanics/plane_forces.hpp"
#include "nodes/physics/mechanics/rigid_step.hpp"

namespace tactor {

/// The equations of one step. The unknown is the velocity of all bodies, linear before angular: at the end of the step
/// of h seconds by implicit Euler, in the middle of the step of 2 h seconds by the midpoint rule. `device`: the handle
/// at that time. Dofs: 3 for one body that does not rotate, 6 for one that does, else Eigen::Dynamic. Nodes: how many a
/// patch of deforming surfaces may have, whose velocities follow those of the bodies; then Dofs is Eigen::Dynamic.
template <int Dofs, Integrator integrator, int Nodes = 0>
class StepEquations {
  using Matrix3d = Eigen::Matrix3d;
  using Vector3d = Eigen::Vector3d;
  using Plane = RigidStep::Plane;
  static constexpr double bound_tolerance = 1e-4;  // of the friction bounds, where they stop to follow
  static constexpr double unsettled = 1e-3;        // of a plane's power: of a lift that has settled it is less
  static constexpr double most_answer = 0.3;       // of lifts to their own change, where they may follow the velocities
  static constexpr double whole = integrator == Integrator::midpoint ? 2 : 1;  // the step, in h
  static constexpr bool one = Dofs != Eigen::Dynamic;
  static constexpr bool soft = Nodes > 0;
  static_assert(!(soft && one));
  static constexpr int small = 6 * static_cast<int>(max_moving_bodies);
  static constexpr int most = one ? Dofs : small + 3 * Nodes;

 public:
  static constexpr bool midpoint = integrator == Integrator::midpoint;
  using Vector = Eigen::Matrix<double, Dofs, 1, 0, most, 1>;
  using Matrix = std::conditional_t<soft, Eigen::MatrixXd,
                                    Eigen::Matrix<double, Dofs, Dofs, 0, one ? most : small, one ? most : small>>;

  StepEquations(const SystemModel& model, const CouplingParameters& coupling, const DeviceState& device, double h,
                const BodyStates& bodies, std::span<Plane> planes, const SoftPatch* patch = nullptr)
      : model_(model),
        device_(device),
        h_(h),
        bodies_(bodies),
        planes_(planes),
        patch_(patch),
        massless_(coupling.massless != 0),
        k_t_(h * coupling.k_t),
        k_r_(h * coupling.k_r),
        b_t_(massless_ ? 0 : coupling.b_t),
        b_r_(massless_ ? 0 : coupling.b_r) {
    for (int i = 0; i < count(); ++i) {
      Body& b = body_[index(i)];
      b.offset = dofs_;
      dofs_ += rotates(i) ? 6 : 3;
      prepare(i, b);
    }
    if constexpr (soft) {
      patch_offset_ = dofs_;
      dofs_ += 3 * static_cast<int>(patch_->p_W.size());
      patch_momentum_.resize(patch_->free_velocity.size());
      take_momentum(patch_->free_velocity, patch_momentum_);
    }
    if (lifts_) choose_cones();
  }

  /// Where Newton's method begins: the velocities of now, which at rest are the solution.
  [[nodiscard]] Vector start() const {
    Vector v(dofs_);
    for (int i = 0; i < count(); ++i) {
      const bool balance = massless_ && i == 0;
      linear(v, i) = balance ? Vector3d::Zero() : eigen(bodies_.V_WB[index(i)].v);
      if (rotates(i)) angular(v, i) = balance ? Vector3d::Zero() : eigen(body_[index(i)].free.w_WB);
    }
    if constexpr (soft) of_patch(v) = patch_->velocity;
    return v;
  }

  /// Sets the relative velocities of the planes for body velocities v.
  void set_velocities(const Vector& v, Vec3 Plane::*target) const {
    for (Plane& p : planes_) p.*target = velocity_of(p, v);
  }

  /// What is left of the equations at v, N s and N m s; sets the planes' forces. Needs the planes' velocities.
  void residual(const Vector& v, Vector& left) {
    left.resize(dofs_);
    for (int i = 0; i < count(); ++i) {
      Body& b = body_[index(i)];
      linear(left, i) = b.mass * linear(v, i) - b.momentum;
      b.linear_terms = b.linear_scale;
      if (rotates(i)) {
        angular(left, i) = b.inertia * angular(v, i) - b.angular_momentum;
        b.angular_terms = b.angular_scale;
      }
    }
    add_coupling(v, left);
    if constexpr (soft) {
      take_momentum(of_patch(v), of_patch(left));
      patch_terms_ = of_patch(left).norm() + patch_momentum_.norm();
      of_patch(left) -= patch_momentum_;
    }
    for (Plane& p : planes_) {
      p.force = force(p, p.u);
      apply_both(p, left);
    }
  }

  /// True where every body's equation is met, given the residual and the terms that it was summed from.
  [[nodiscard]] bool met(const Vector& left) const {
    for (int i = 0; i < count(); ++i) {
      const Body& b = body_[index(i)];
      if (!(linear(left, i).norm() <= model_.tolerance * b.linear_terms)) return false;
      if (rotates(i) && !(angular(left, i).norm() <= model_.tolerance * b.angular_terms)) return false;
    }
    if constexpr (soft) return of_patch(left).norm() <= model_.tolerance * patch_terms_;
    return true;
  }

  /// The derivative of the residual by v: the masses, the coupling, and the planes by `slopes(plane)`.
  template <class M, class Slopes>
  void derivative(M& H, Slopes slopes) const {
    H.setZero();
    for (int i = 0; i < count(); ++i) {
      const Body& b = body_[index(i)];
      const bool tool = i == 0;
      H.template block<3, 3>(b.offset, b.offset).diagonal().array() = b.mass + (tool ? h_ * (k_t_ + b_t_) : 0);
      if (!rotates(i)) continue;
      H.template block<3, 3>(b.offset + 3, b.offset + 3) = b.inertia;
      if (tool) H.template block<3, 3>(b.offset + 3, b.offset + 3).diagonal().array() += h_ * (k_r_ + b_r_);
    }
    if constexpr (soft) {
      const auto n = static_cast<Eigen::Index>(3 * patch_->p_W.size());
      H.block(patch_offset_, patch_offset_, n, n) = patch_->inertia;
    }
    Matrix3d S;
    for (const Plane& p : planes_) {
      if (!slopes(p, S)) continue;
      S *= h_;
      if (moves(p)) add(H, S, p.body, p.r_body, p.body, p.r_body);
      if constexpr (soft) {
        if (p.other == Plane::on_patch) add_on_patch(H, S, p);
      }
      if constexpr (!one) {
        if (p.other < 0) continue;
        add(H, S, p.other, p.r_other, p.other, p.r_other);
        const Matrix3d opposite = -S;
        // Only the lower triangle is read.
        if (p.body > p.other) {
          add(H, opposite, p.body, p.r_body, p.other, p.r_other);
        } else {
          add(H, opposite, p.other, p.r_other, p.body, p.r_body);
        }
      }
    }
  }

  /// Of the size that `derivative` fills. One with a patch is too large for the stack: it lies in `workspace`.
  [[nodiscard]] auto matrix(double* workspace) const {
    if constexpr (soft) {
      return Eigen::Map<Eigen::MatrixXd>(workspace, dofs_, dofs_);
    } else {
      return Matrix(dofs_, dofs_);
    }
  }

  /// Whether sliding lifts at contacts.
  [[nodiscard]] bool lifts() const { return lifts_; }
  /// Whether contacts have inertia.
  [[nodiscard]] bool carries() const { return carries_; }
  /// Sets the forces of their inertia. Needs the planes' `u_start`.
  void carry() const {
    for (Plane& p : planes_) p.carried = p.inertia * dot(p.n, p.u_start);
  }

  /// How the derivative of the convex function along v + a d depends on a. Needs the planes' `u` and `du`.
  class Line {
   public:
    Line(StepEquations& equations, const Vector& v, const Vector& d) : equations_(equations) {
      // The part without planes is linear in a.
      Vector at_v, at_end;
      equations.smooth_residual(v, at_v);
      const Vector end = v + d;
      equations.smooth_residual(end, at_end);
      constant_ = d.dot(at_v);
      slope_ = d.dot(at_end) - constant_;
    }
    [[nodiscard]] double operator()(double a) const {
      double sum = constant_ + a * slope_;
      for (const Plane& p : equations_.planes_) sum -= equations_.h_ * dot(p.du, equations_.force(p, p.u + a * p.du));
      return sum;
    }

   private:
    StepEquations& equations_;
    double constant_ = 0, slope_ = 0;
  };

  /// The force of a plane on its moving body at relative velocity u, with its friction bound.
  [[nodiscard]] Vec3 force(const Plane& p, const Vec3& u) const { return law_.force(p, u); }

  /// Lets the friction bounds, and what sliding lifts, follow the normal forces; returns true where they hardly
  /// changed.
  bool follow() const {
    double change = 0, sum = 0;
    for (Plane& p : planes_) {
      if (p.lift > 0) change += p.friction * law_.follow_lift(p);
      const double bound = p.friction * law_.normal(p);
      change += std::abs(bound - p.bound);
      sum += bound;
      p.bound = bound;
    }
    // Where nothing pushes yet there is nothing to hold.
    return sum > 0 && change <= bound_tolerance * sum;
  }

  /// Where the lift has not settled, takes the last that was too small.
  void hold_lifts() const {
    for (Plane& p : planes_) {
      if (p.lift > 0) p.lifted = std::min(p.lifted, p.lifted_below);
    }
  }
  /// Leaves out the lift of planes that put energy in, as only one that has not settled can; true where there are such.
  /// Needs the planes' forces.
  bool drop_lifts() const {
    bool dropped = false;
    for (Plane& p : planes_) {
      if (!(p.lift > 0)) continue;
      if (!(law_.power(p) > unsettled * norm(p.force) * norm(p.u))) continue;
      p.lift = p.lifted = 0;
      p.coned = false;
      dropped = true;
    }
    return dropped;
  }

  /// The slopes of a plane's force, as Newton's method wants them.
  [[nodiscard]] auto newton() const {
    return [this](const Plane& p, Matrix3d& S) { return law_.slope(p, S); };
  }

  /// The slopes with springs of both signs where bodies overlap, and friction viscous.
  [[nodiscard]] auto damped() const {
    return [this](const Plane& p, Matrix3d& S) {
      if (p.push <= 0) return false;
      const Vector3d n = eigen(p.n);
      const double across = law_.viscosity(p);
      S = (p.spring + p.damping - across) * n * n.transpose();
      S.diagonal().array() += across;
      return true;
    };
  }
  /// The residual at v of the same coupling; sets the planes' forces.
  void damped_residual(const Vector& v, Vector& left) {
    smooth_residual(v, left);
    for (Plane& p : planes_) {
      p.force = {};
      if (p.push <= 0) continue;
      const double speed = dot(p.n, p.u);
      p.force = (p.push - (p.spring + p.damping) * speed + p.carried) * p.n - law_.viscosity(p) * (p.u - speed * p.n);
      apply_both(p, left);
    }
  }

  /// Moves the bodies with velocities v, by the midpoint rule over the whole step; returns the farthest turn, rad. The
  /// momenta come from the forces, which are equal and opposite to the last digit, and not from v, which is met to a
  /// tolerance.
  double finish(const Vector& v, BodyStates& bodies) {
    double turn = 0;
    Vector left(dofs_);
    left.setZero();
    for (Plane& p : planes_) apply_both(p, left);
    add_coupling(v, left);
    for (int i = 0; i < count(); ++i) {
      const Body& b = body_[index(i)];
      Pose& X = bodies.X_WB[index(i)];
      Twist& V = bodies.V_WB[index(i)];
      const bool balance = massless_ && i == 0;
      const Vec3 v_solved = plain(balance ? Vector3d(linear(v, i)) : Vector3d((b.momentum - linear(left, i)) / b.mass));
      X.p += whole * h_ * v_solved;
      V.v = midpoint ? 2 * v_solved - V.v : v_solved;
      V.w = {};
      if (!rotates(i)) continue;
      const Vec3 w = plain(angular(v, i));
      const Matrix3d& inertia_B = model_.body[index(i)].inertia_B;
      const Rotation free = midpoint ? free_rotation(inertia_B, b.free.R_WB, b.free.w_WB, h_) : b.free;
      X.R = normalized(from_rotation_vector(whole * h_ * (w - b.free.w_WB)) * free.R_WB);
      // The tool without mass turns as far as the handle does, and its next step corrects what was not linear.
      if (!balance) turn = std::max({turn, whole * h_ * norm(w), whole * h_ * norm(b.free.w_WB)});
      V.w = balance ? w : plain(inertia_W(inertia_B, X.R).inverse() * (b.angular_momentum - whole * angular(left, i)));
    }
    return turn;
  }

  /// The force that a plane has at the end of the step, given its velocity and its force for that. Of implicit Euler it
  /// is the same.
  [[nodiscard]] Vec3 force_at_end(const Plane& p) const { return law_.force_at_end(p); }

  /// What became of the patch, given the velocities and the forces of the planes for them.
  void finish_patch(const Vector& v, SoftPatchMotion& motion) const requires soft {
    motion.velocity = of_patch(v);
    motion.force.setZero();
    for (const Plane& p : planes_) {
      if (p.other != Plane::on_patch) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        if (p.node[k] < 0) continue;
        motion.force.template segment<3>(3 * p.node[k]) -= p.share[k] * eigen(p.force);
      }
    }
  }

  [[nodiscard]] int dofs() const { return dofs_; }

 private:
  using Patch = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, soft ? 3 * Nodes : 3, 1>;
  struct Body {
    int offset = 0;
    double mass = 0;                               // kg
    Vector3d momentum = Vector3d::Zero();          // N s, before the step, with the impulse of the weight
    Matrix3d inertia = Matrix3d::Zero();           // kg m^2, in W, as free rotation leaves it
    Vector3d angular_momentum = Vector3d::Zero();  // N m s
    Rotation free;                                 // after the step, without torque
    double linear_scale = 0, angular_scale = 0;    // the sizes of the terms that do not depend on v
    double linear_terms = 0, angular_terms = 0;    // the sizes of all terms
  };

  void prepare(int i, Body& b) const {
    const BodyModel& model = model_.body[index(i)];
    const Pose& X = bodies_.X_WB[index(i)];
    const Twist& V = bodies_.V_WB[index(i)];
    if (massless_ && i == 0) {
      b.free = {X.R, {}};
      return;
    }
    b.mass = model.mass;
    b.momentum = model.mass * eigen(V.v + h_ * model_.gravity_W);
    b.linear_scale = model.mass * (norm(V.v) + h_ * norm(model_.gravity_W));
    if (!rotates(i)) return;
    b.angular_momentum = inertia_W(model.inertia_B, X.R) * eigen(V.w);
    b.free = free_rotation(model.inertia_B, X.R, V.w, h_);
    b.inertia = inertia_W(model.inertia_B, b.free.R_WB);
    b.angular_scale = b.angular_momentum.norm();
  }

  /// Lifts follow the velocities as friction bounds do, unless they would answer to that too much.
  void choose_cones() {
    double answer = 0;
    for (const Plane& p : planes_) {
      if (!(p.lift > 0)) continue;
      double mobility = moves(p) ? mobility_of(p.body, p.r_body) : 0;
      if (!one && p.other >= 0) mobility += mobility_of(p.other, p.r_other);
      answer += p.lift * p.friction * whole * h_ * mobility;
      // Of the patch nobody knows.
      if (p.other == Plane::on_patch) answer += 2 * most_answer;
    }
    for (Plane& p : planes_) p.coned = p.lift > 0 && answer > most_answer;
  }
  /// 1/kg, at least that of a body's point at lever r.
  [[nodiscard]] double mobility_of(int i, const Vec3& r) const {
    const Body& b = body_[index(i)];
    return 1 / b.mass + (rotates(i) ? dot(r, r) * b.inertia.inverse().trace() : 0);
  }

  [[nodiscard]] int count() const { return one ? 1 : model_.count; }
  [[nodiscard]] static std::size_t index(int i) { return one ? 0 : static_cast<std::size_t>(i); }
  [[nodiscard]] bool rotates(int i) const {
    if constexpr (one) return Dofs == 6;
    return model_.body[index(i)].rotates;
  }
  [[nodiscard]] int offset(int i) const { return one ? 0 : body_[index(i)].offset; }

  template <class V>
  [[nodiscard]] auto linear(V& v, int i) const {
    return v.template segment<3>(offset(i));
  }
  template <class V>
  [[nodiscard]] auto angular(V& v, int i) const {
    // With 3 degrees of freedom this is never called, and must compile all the same.
    return v.template segment<3>(Dofs == 3 ? 0 : offset(i) + 3);
  }

  [[nodiscard]] Vec3 velocity_of(const Plane& p, const Vector& v) const {
    Vec3 u = moves(p) ? velocity_at(v, p.body, p.r_body) : Vec3{};
    if constexpr (!one) {
      if (p.other >= 0) u -= velocity_at(v, p.other, p.r_other);
      if constexpr (soft) {
        if (p.other == Plane::on_patch) u -= velocity_on_patch(v, p);
      }
    }
    return u;
  }
  [[nodiscard]] Vec3 velocity_at(const Vector& v, int i, const Vec3& r) const {
    const double* at = v.data() + offset(i);
    const Vec3 u{at[0], at[1], at[2]};
    return rotates(i) ? u + cross({at[3], at[4], at[5]}, r) : u;
  }

  template <class V>
  [[nodiscard]] auto of_patch(V& v) const {
    return v.segment(patch_offset_, static_cast<Eigen::Index>(3 * patch_->p_W.size()));
  }
  /// Whether the plane's rigid body moves; fixed ones touch patches too.
  [[nodiscard]] static bool moves(const Plane& p) {
    if constexpr (soft) return p.body >= 0;
    return true;
  }
  /// Sets `momentum`, N s, to that of the nodes at velocities v, m/s. Where a patch has no nodes there is nothing to
  /// set, and its inertia may have no memory, whose first element Eigen's product would refer to.
  template <class V, class M>
  void take_momentum(const V& v, M&& momentum) const {
    if (patch_->p_W.empty()) return;
    momentum.noalias() = patch_->inertia.template selfadjointView<Eigen::Lower>() * v;
  }
  [[nodiscard]] Vec3 velocity_on_patch(const Vector& v, const Plane& p) const {
    Vec3 u;
    for (std::size_t k = 0; k < 3; ++k) {
      if (p.node[k] < 0) continue;
      const double* at = v.data() + patch_offset_ + 3 * p.node[k];
      u += p.share[k] * Vec3{at[0], at[1], at[2]};
    }
    return u;
  }
  /// Adds what the slope S of a force between a body and the patch gives, to the lower triangle. The patch comes after
  /// all bodies.
  template <class M>
  void add_on_patch(M& H, const Matrix3d& S, const Plane& p) const {
    for (std::size_t k = 0; k < 3; ++k) {
      if (p.node[k] < 0) continue;
      const int row = patch_offset_ + 3 * p.node[k];
      const Matrix3d with_body = -p.share[k] * S;
      if (moves(p)) H.template block<3, 3>(row, offset(p.body)) += with_body;
      if (moves(p) && rotates(p.body))
        H.template block<3, 3>(row, offset(p.body) + 3) -= with_body * skew(eigen(p.r_body));
      for (std::size_t l = 0; l < 3; ++l) {
        if (p.node[l] < 0 || p.node[k] < p.node[l]) continue;
        H.template block<3, 3>(row, patch_offset_ + 3 * p.node[l]) += p.share[k] * p.share[l] * S;
      }
    }
  }

  /// The force of a plane, on both that it is between, into what is left of their equations.
  void apply_both(const Plane& p, Vector& left) {
    if (moves(p)) apply(p, p.body, p.r_body, -h_, left);
    if constexpr (!one) {
      if (p.other >= 0) apply(p, p.other, p.r_other, h_, left);
    }
    if constexpr (soft) {
      if (p.other != Plane::on_patch || p.force == Vec3{}) return;
      for (std::size_t k = 0; k < 3; ++k) {
        if (p.node[k] < 0) continue;
        left.template segment<3>(patch_offset_ + 3 * p.node[k]) += h_ * p.share[k] * eigen(p.force);
      }
    }
  }

  void apply(const Plane& p, int i, const Vec3& r, double share, Vector& left) {
    if (p.force == Vec3{}) return;
    Body& b = body_[index(i)];
    const double size = h_ * norm(p.force);
    linear(left, i) += share * eigen(p.force);
    b.linear_terms += size;
    if (rotates(i)) {
      angular(left, i) += share * eigen(cross(r, p.force));
      b.angular_terms += size * norm(r);
    }
  }

  void add_coupling(const Vector& v, Vector& left) {
    Body& tool = body_[0];
    // The parts of the impulse are terms of their own: in balance the impulse itself vanishes.
    const Vector3d pull = k_t_ * eigen(device_.X_WD.p - bodies_.X_WB[0].p), drag = h_ * b_t_ * eigen(device_.V_WD.v);
    const Vector3d give = h_ * (k_t_ + b_t_) * linear(v, 0);
    linear(left, 0) -= pull + drag - give;
    tool.linear_terms += pull.norm() + drag.norm() + give.norm();
    if (!rotates(0)) return;
    const Vector3d turn = k_r_ * turn_, brake = h_ * b_r_ * eigen(device_.V_WD.w);
    const Vector3d yield = h_ * (k_r_ + b_r_) * angular(v, 0);
    angular(left, 0) -= turn + brake - yield;
    tool.angular_terms += turn.norm() + brake.norm() + yield.norm();
  }

  /// The residual without the planes.
  void smooth_residual(const Vector& v, Vector& left) {
    left.resize(dofs_);
    for (int i = 0; i < count(); ++i) {
      const Body& b = body_[index(i)];
      linear(left, i) = b.mass * linear(v, i) - b.momentum;
      if (rotates(i)) angular(left, i) = b.inertia * angular(v, i) - b.angular_momentum;
    }
    add_coupling(v, left);
    if constexpr (soft) {
      take_momentum(of_patch(v), of_patch(left));
      of_patch(left) -= patch_momentum_;
    }
  }

  /// Adds what the slope S, symmetric, of a force between bodies i and j gives with their levers, to the lower
  /// triangle.
  template <class M>
  void add(M& H, const Matrix3d& S, int i, const Vec3& r_i, int j, const Vec3& r_j) const {
    const int row = offset(i), column = offset(j);
    for (int b = 0; b < 3; ++b) {
      for (int a = 0; a < 3; ++a) H(row + a, column + b) += S(a, b);
    }
    if constexpr (Dofs != 3) {
      // A diagonal block's mirror image is above the diagonal, and nobody reads it.
      if (rotates(j) && row != column) H.template block<3, 3>(row, column + 3) -= S * skew(eigen(r_j));
      if (!rotates(i)) return;
      // skew(r_i) S, column by column.
      std::array<Vec3, 3> lever;
      for (int b = 0; b < 3; ++b) lever[static_cast<std::size_t>(b)] = cross(r_i, {S(0, b), S(1, b), S(2, b)});
      for (int b = 0; b < 3; ++b) {
        for (int a = 0; a < 3; ++a) H(row + 3 + a, column + b) += lever[static_cast<std::size_t>(b)][a];
      }
      if (!rotates(j)) return;
      // - (skew(r_i) S) skew(r_j), row by row.
      for (int a = 0; a < 3; ++a) {
        const Vec3 turned = cross(r_j, {lever[0][a], lever[1][a], lever[2][a]});
        for (int b = 0; b < 3; ++b) H(row + 3 + a, column + 3 + b) += turned[b];
      }
    }
  }

  const SystemModel& model_;
  PlaneForces<integrator> law_{model_.stick_velocity};
  const DeviceState& device_;
  double h_;
  const BodyStates& bodies_;
  std::span<Plane> planes_;
  const SoftPatch* patch_;
  bool massless_;
  bool lifts_ = std::any_of(planes_.begin(), planes_.end(), [](const Plane& p) { return p.lift > 0; });
  bool carries_ = std::any_of(planes_.begin(), planes_.end(), [](const Plane& p) { return p.inertia > 0; });
  double k_t_, k_r_, b_t_, b_r_;  // k times h
  Vector3d turn_ = model_.body[0].rotates ? eigen(to_rotation_vector(device_.X_WD.R * inverse(bodies_.X_WB[0].R)))
                                          : Vector3d(Vector3d::Zero());
  int dofs_ = 0;
  int patch_offset_ = 0;    // of the nodes' velocities
  Patch patch_momentum_;    // N s, without contacts
  double patch_terms_ = 0;  // N s, the sizes of the terms of their equation
  std::array<Body, one ? 1 : max_moving_bodies> body_;
};

}  // namespace tactor
