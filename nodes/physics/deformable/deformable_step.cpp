#include "nodes/physics/deformable/deformable_step.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tactor {

namespace {

constexpr double good_contraction = 1.0 / 3;  // of what an iteration leaves
constexpr int most_halvings_of_way = 6;
constexpr double spare_energy = 0.01;  // of what nodes store, that the midpoint rule may save up

SystemModel by_euler(SystemModel model) {
  model.integrator = Integrator::implicit_euler;
  return model;
}

}  // namespace

DeformableStep::DeformableStep(const SoftScene& soft, SoftContacts& contacts, const ContactBody& tool,
                               const SystemModel& model, const DeformableOptions& options, const Vec3& gravity_W)
    : soft_(soft),
      options_(options),
      rigid_step_(model, RigidStep::most_patch_nodes),
      euler_step_(by_euler(model), RigidStep::most_patch_nodes),
      patch_(soft, tool, options),
      contacts_(soft.model, contacts, tool.radius),
      equation_(soft.model, gravity_W),
      factor_(soft.model, options.solver),
      patch_step_(soft.model, patch_),
      x_(soft.model.rest()),
      v_(Eigen::VectorXd::Zero(soft.model.unknowns())),
      x_i_(x_),
      x_next_(x_),
      x_end_(x_) {
  for (Eigen::VectorXd* v : {&left_, &without_contact_, &d_, &pushed_}) v->setZero(v_.size());
}

void DeformableStep::place(const Eigen::VectorXd& x) {
  place(x, Eigen::VectorXd::Zero(v_.size()));
}

void DeformableStep::place(const Eigen::VectorXd& x, const Eigen::VectorXd& v) {
  x_ = x;
  v_ = v;
  spare_ = 0;
}

bool DeformableStep::by_midpoint(const CouplingParameters& coupling) const {
  return rigid_step_.model().integrator == Integrator::midpoint && coupling.massless == 0;
}

/// Factors A at x_i_ for a step of h seconds. False where that has no factor.
bool DeformableStep::factor(double h, ElasticModel::Tangent tangent) {
  ++counts_.factors;
  return factor_.factor(x_i_, h, tangent);
}

/// N, what may be left: the tolerance of the forces, and what rounding the places leaves.
double DeformableStep::allowed(const Eigen::VectorXd& x) const {
  constexpr double rounding = 4 * std::numeric_limits<double>::epsilon();
  return options_.tolerance * equation_.forces() + rounding * factor_.stiffest() * x.lpNorm<Eigen::Infinity>();
}

/// m, where the nodes are at the end of a step that is solved at x_next_.
const Eigen::VectorXd& DeformableStep::x_end(bool midpoint) {
  if (!midpoint) return x_next_;
  x_end_ = 2 * x_next_ - equation_.x0();
  return x_end_;
}

/// Adds what the contact forces do to the way, to x_next_.
void DeformableStep::push() {
  if (!patch_step_.touches()) return;
  pushed_ = equation_.contact_force();
  factor_.solve(pushed_);
  d_ += pushed_;
  soft_.model.displace(pushed_, 1, x_next_);
}

/// Where more is left at x_next_ than was: halves the way to there while the merit is not lower. Returns the share of
/// it that is gone.
double DeformableStep::halve_way(double was_left, double solved) {
  double share = 1;
  if (!(left_.norm() > was_left)) return share;
  const double had = equation_.merit(x_i_, solved);
  for (int k = 0; k < most_halvings_of_way && equation_.merit(x_next_, solved) > had; ++k) {
    share /= 2;
    x_next_ = x_i_;
    soft_.model.displace(d_, share, x_next_);
  }
  if (share < 1) equation_.residual(x_next_, solved, left_);
  return share;
}

/// Solves the step from x0 and `bodies`; leaves the solved place in x_i_. False where the iterations did not do.
bool DeformableStep::solve(RigidStep& rigid_step, const StepInput& input, BodyStates& bodies, StepResult& result) {
  const bool midpoint = &rigid_step == &rigid_step_ && by_midpoint(input.coupling);
  const double solved = midpoint ? input.h / 2 : input.h;
  const BodyStates start = bodies;
  const auto solve_contacts = [&] {
    bodies = start;
    result = patch_step_.advance(rigid_step, input, contacts_, factor_, x_next_, solved, equation_, bodies);
  };
  result = {.outcome = StepOutcome::stopped};
  x_i_ = equation_.x0();
  equation_.contact_force().setZero();
  bool fresh = !options_.reuse_factors || !factor_.serves(solved);
  if (fresh && !factor(solved, ElasticModel::Tangent::warped)) return false;
  equation_.residual(x_i_, solved, left_);
  double was_left = left_.norm();
  for (int i = 0; i < options_.newton_iterations; ++i) {
    ++counts_.iterations;
    if (i > 0) contacts_.find(x_i_, midpoint ? on_the_way(start, bodies, 0.5) : bodies);
    without_contact_ = left_ - equation_.contact_force();
    d_ = without_contact_;
    factor_.solve(d_);
    x_next_ = x_i_;
    soft_.model.displace(d_, 1, x_next_);
    solve_contacts();
    if (i == 0 && contacts_.look_ahead(start, bodies, equation_.x0(), x_end(midpoint))) solve_contacts();
    // Contacts that have changed are no fault of the factor: what it is to solve has them.
    const double to_solve = std::max(was_left, (without_contact_ + equation_.contact_force()).norm());
    push();
    equation_.residual(x_next_, solved, left_);
    // Nodes may be in balance without the contacts, where those were not solved.
    if (left_.norm() <= allowed(x_next_) && result.outcome == StepOutcome::converged) {
      x_i_ = x_next_;
      return true;
    }
    const double share = halve_way(was_left, solved);
    was_left = left_.norm();
    x_i_ = x_next_;
    const double contraction = was_left / to_solve;
    const int to_go = options_.newton_iterations - i - 1;
    const bool due =
        share < 1 || (options_.reuse_factors ? factor_.is_due(contraction, was_left / allowed(x_i_), to_go, fresh)
                                             : !(contraction <= good_contraction));
    if (due) {
      // The warped tangent lacks what stress adds, so that it may be slow however fresh it is.
      if (!factor(solved, fresh ? ElasticModel::Tangent::projected : ElasticModel::Tangent::warped)) return false;
      fresh = true;
    } else if (options_.reuse_factors) {
      without_contact_ -= left_ - equation_.contact_force();
      if (factor_.learn(contraction, d_, without_contact_)) ++counts_.updates;
    }
  }
  return false;
}

/// Takes the nodes to where `solve` has them; returns the contacts' work on them, J.
double DeformableStep::take(double h, bool midpoint) {
  const Eigen::VectorXd& way = equation_.way_to(x_i_);
  const double work = equation_.contact_force().dot(way);
  if (!midpoint) {
    x_ = x_i_;
    v_ = (1 / h) * way;
    return work;
  }
  x_ = equation_.x0();
  soft_.model.displace(way, 2, x_);
  v_ = (4 / h) * way - equation_.v0();
  equation_.inner_force(x_);
  return 2 * work;
}

/// Where a step was not solved: lets the energy of the nodes be no larger than `before` (J) and the contacts' work.
void DeformableStep::limit_energy(double before, double work) {
  const double moving = equation_.kinetic(v_);
  const double excess = energy() - before - work;
  if (!(excess > 0) || !(moving > 0)) return;
  v_ *= excess < moving ? std::sqrt(1 - excess / moving) : 0.0;
}

/// J, by how much a step may be off by rounding alone.
double DeformableStep::energy_rounding(double work) const {
  constexpr double epsilon = 16 * std::numeric_limits<double>::epsilon();
  const double place = epsilon * x_.lpNorm<Eigen::Infinity>();
  return 1e-10 * (stored() + std::abs(work)) + epsilon * std::abs(energy()) +
         factor_.stiffest() * place * place * static_cast<double>(v_.size());
}

/// Takes a step of the midpoint rule; false, and nothing has changed, where it was not solved or would leave the nodes
/// more energy than they had and contacts gave.
bool DeformableStep::advance_by_midpoint(const StepInput& input, BodyStates& bodies, StepResult& result) {
  const BodyStates start = bodies;
  const double had = energy();
  if (solve(rigid_step_, input, bodies, result)) {
    const double work = take(input.h, true);
    const double spare = spare_ + had + work - energy();
    if (spare >= -energy_rounding(work) && x_.allFinite() && v_.allFinite()) {
      spare_ = std::clamp(spare, 0.0, spare_energy * stored());
      return true;
    }
  }
  bodies = start;
  x_ = equation_.x0();
  v_ = equation_.v0();
  return false;
}

void DeformableStep::refresh(const BodyStates& bodies) {
  if (!contacts_.refresh(x_, bodies)) return;
  // Another patch is eliminated in another order.
  if (patch_.update(x_, bodies.X_WB[0], bodies.V_WB[0], contacts_.found())) factor_.reorder(patch_.last_nodes());
}

StepResult DeformableStep::advance(const CouplingParameters& coupling, const DeviceState& before,
                                   const DeviceState& device, const ContactPlanes& rigid, double h,
                                   BodyStates& bodies) {
  const StepInput input{coupling, before, device, rigid, h};
  const BodyStates start = bodies;
  refresh(bodies);
  equation_.begin(x_, v_, h);
  ++counts_.steps;
  StepResult result;
  if (by_midpoint(coupling)) {
    if (advance_by_midpoint(input, bodies, result)) {
      counts_.left_out += result.left_out;
      return result;
    }
    ++counts_.by_euler;
    contacts_.find(x_, bodies);
  }
  const bool converged = solve(euler_step_, input, bodies, result);
  // The energy costs as much as the forces do, and a step of implicit Euler that is solved gains none.
  const bool is_watched = by_midpoint(coupling) || !converged;
  const double had = is_watched ? energy() : 0;
  const double work = take(h, false);
  if (is_watched) spare_ = std::clamp(spare_ + had + work - energy(), 0.0, spare_energy * stored());
  if (!x_.allFinite() || !v_.allFinite()) {
    x_ = equation_.x0();
    v_.setZero();
    bodies = start;
    for (Twist& V : bodies.V_WB) V = {};
    result = {.outcome = StepOutcome::stopped, .left_out = result.left_out};
    factor_.forget();
  }
  if (!converged) {
    equation_.inner_force(x_);
    ++counts_.damped;
    limit_energy(had, work);
    if (result.outcome == StepOutcome::converged) result.outcome = StepOutcome::damped;
  }
  counts_.left_out += result.left_out;
  return result;
}

}  // namespace tactor
