#include "nodes/physics/deformable/deformable_step.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "nodes/physics/mechanics/eigen.hpp"

namespace tactor {

namespace {

constexpr double good_contraction = 1.0 / 3;     // of what an iteration leaves
constexpr double fresh_contraction = 0.1;        // of what one leaves with a factor of where it is
constexpr double least_to_learn = 0.05;          // of what one leaves, where the factor learns from it
constexpr double slowest_contraction = 0.95;     // taken for iterations that leave more, or all
constexpr double largest_change_of_step = 0.15;  // that a factor serves
// Of a step, in multiplications as fast as those of a factorisation: of an entry of the factor in a solution, which
// waits for memory, and of a tetrahedron in forces and in an assembly.
constexpr double cost_of_entry = 12, cost_of_forces = 2500, cost_of_assembly = 2500;
constexpr int most_halvings_of_way = 6;
constexpr int most_looks_ahead = 16;
constexpr double spare_energy = 0.01;  // of what nodes store, that the midpoint rule may save up

Vec3 at(const Eigen::VectorXd& x, int first) {
  return {x[first], x[first + 1], x[first + 2]};
}

/// The bodies at that share of their way.
BodyStates on_the_way(const BodyStates& start, const BodyStates& end, double share) {
  BodyStates there = start;
  for (std::size_t i = 0; i < static_cast<std::size_t>(start.count); ++i) {
    const Pose &X0 = start.X_WB[i], &X1 = end.X_WB[i];
    there.X_WB[i] = {X0.p + share * (X1.p - X0.p),
                     from_rotation_vector(share * to_rotation_vector(X1.R * inverse(X0.R))) * X0.R};
  }
  return there;
}

/// Whether the same bodies are at the same places with the same velocities, to the bit.
bool are_same(const BodyStates& a, const BodyStates& b) {
  const auto count = static_cast<std::size_t>(a.count);
  return a.count == b.count && std::memcmp(a.X_WB.data(), b.X_WB.data(), count * sizeof(a.X_WB[0])) == 0 &&
         std::memcmp(a.V_WB.data(), b.V_WB.data(), count * sizeof(a.V_WB[0])) == 0;
}

bool of_tool(const SoftContact& contact) {
  return contact.body == 0;
}

SystemModel by_euler(SystemModel model) {
  model.integrator = Integrator::implicit_euler;
  return model;
}

}  // namespace

DeformableStep::DeformableStep(const SoftScene& soft, SoftContacts& contacts, const ContactBody& tool,
                               const SystemModel& model, const DeformableOptions& options, const Vec3& gravity_W)
    : soft_(soft),
      contacts_(contacts),
      options_(options),
      rigid_step_(model, RigidStep::most_patch_nodes),
      euler_step_(by_euler(model), RigidStep::most_patch_nodes),
      tool_radius_(tool.radius),
      patch_(soft, tool, options.patch),
      factor_(make_factor(options.factor, soft.model.elements())),
      weight_(soft.model.weight(gravity_W)),
      x_(soft.model.rest()),
      v_(Eigen::VectorXd::Zero(soft.model.unknowns())) {
  const Eigen::Index n = soft.model.unknowns();
  for (Eigen::VectorXd* v : {&force_, &inertia_force_, &damper_force_, &contact_force_, &left_, &without_contact_, &d_,
                             &scratch_, &product_, &way_}) {
    v->setZero(n);
  }
  x0_ = x_i_ = x_free_ = x_query_ = x_;
  x_force_.setConstant(x_.size(), std::numeric_limits<double>::quiet_NaN());
  constexpr Eigen::Index patch = 3 * RigidStep::most_patch_nodes;
  for (Eigen::VectorXd* v : {&patch_velocity_, &patch_free_, &patch_solved_, &patch_force_}) v->setZero(patch);
  nodes_W_.resize(static_cast<std::size_t>(soft.model.nodes()));
  patch_p_W_.resize(RigidStep::most_patch_nodes);
  patch_query_.resize(RigidStep::most_patch_nodes);
  found_.reserve(ContactSet::capacity);
  ahead_.reserve(ContactSet::capacity);
  touching_.reserve(ContactSet::capacity);
}

void DeformableStep::place(const Eigen::VectorXd& x) {
  place(x, Eigen::VectorXd::Zero(v_.size()));
}

void DeformableStep::place(const Eigen::VectorXd& x, const Eigen::VectorXd& v) {
  x_ = x;
  v_ = v;
  spare_ = 0;
}

double DeformableStep::mass_share(int body, double h) const {
  return 1 / (h * h) + soft_.model.bodies()[static_cast<std::size_t>(body)].drag / h;
}

double DeformableStep::stiffness_share(int body, double h) const {
  return 1 + soft_.model.bodies()[static_cast<std::size_t>(body)].damping / h;
}

/// x += share * by_unknown.
void DeformableStep::add(const Eigen::VectorXd& values, double share, Eigen::VectorXd& x) const {
  const ElasticModel& model = soft_.model;
  for (int u = 0; u < model.unknowns(); u += 3) {
    x.segment<3>(3 * model.node_of(u)) += share * values.segment<3>(u);
  }
}

void DeformableStep::by_unknown(const Eigen::VectorXd& x, Eigen::VectorXd& values) const {
  const ElasticModel& model = soft_.model;
  for (int u = 0; u < model.unknowns(); u += 3) values.segment<3>(u) = x.segment<3>(3 * model.node_of(u));
}

/// Assembles K at x_i_ and factors A for a step of h seconds. False where that has no factor.
bool DeformableStep::factor(double h, ElasticModel::Tangent tangent) {
  const ElasticModel& model = soft_.model;
  model.assemble(x_i_, tangent, K_, scratch_);
  if (A_.rows() == 0) A_ = K_;
  const Eigen::SparseMatrix<double>& M = model.mass();
  for (Eigen::Index column = 0; column < A_.outerSize(); ++column) {
    const int body = model.body_of(static_cast<int>(column));
    const double m = mass_share(body, h), k = stiffness_share(body, h);
    for (Eigen::Index i = A_.outerIndexPtr()[column]; i < A_.outerIndexPtr()[column + 1]; ++i) {
      A_.valuePtr()[i] = m * M.valuePtr()[i] + k * K_.valuePtr()[i];
    }
  }
  if (!analysed_) {
    factor_.analyze(A_, patch_.last_nodes());
    analysed_ = true;
  }
  // Of finite numbers it has one; 0: nothing is factored.
  ++counts_.factors;
  wasted_ = 0;
  factored_h_ = factor_.factor(A_) ? h : 0;
  if (factored_h_ == 0) return false;
  stiffest_ = A_.diagonal().norm();
  return true;
}

/// Whether to factor anew after an iteration that left this share of what the factor was to solve, with so many to go.
bool DeformableStep::is_factor_due(double contraction, int to_go, bool fresh) {
  if (!std::isfinite(contraction)) return true;
  const double speed = -std::log(std::clamp(contraction, 1e-12, slowest_contraction));
  if (std::log(left_.norm() / allowed(x_i_)) > speed * to_go) return true;
  if (fresh) return false;
  wasted_ += std::clamp(1 - std::log(contraction) / std::log(fresh_contraction), 0.0, 2.0);
  return wasted_ > iterations_a_factor_is_worth();
}

double DeformableStep::iterations_a_factor_is_worth() const {
  const double tetrahedra = soft_.model.elements();
  // Two solutions, and one where the factor learns.
  const double iteration =
      3 * cost_of_entry * static_cast<double>(factor_.base().entries()) + cost_of_forces * tetrahedra;
  return (factor_.base().multiplications() + cost_of_assembly * tetrahedra) / iteration;
}

/// The stiffness that damps over h seconds, of where the nodes are halfway at their velocities: there a way that turns
/// strains nothing.
void DeformableStep::prepare_damping(double h) {
  for (const SoftBody& body : soft_.model.bodies()) {
    if (body.damping > 0) {
      x_i_ = x0_;
      add(v_, h / 2, x_i_);
      soft_.model.assemble(x_i_, ElasticModel::Tangent::warped, damping_K_, scratch_);
      return;
    }
  }
}

/// What is left of the nodes' equation at x, with the contact forces in contact_force_; fills the forces that make it
/// up.
void DeformableStep::residual(const Eigen::VectorXd& x, double h, Eigen::VectorXd& left) {
  const ElasticModel& model = soft_.model;
  take_force(x);
  take_way(x);
  scratch_ = way_ - h * v_;
  inertia_force_.noalias() = model.mass().selfadjointView<Eigen::Lower>() * scratch_;
  inertia_force_ /= -h * h;
  damp(way_, damper_force_);
  damper_force_ /= -h;
  left = force_ + inertia_force_ + damper_force_ + contact_force_;
}

/// Sets way_ to that of the unknowns from x0_ to x.
void DeformableStep::take_way(const Eigen::VectorXd& x) {
  by_unknown(x, way_);
  by_unknown(x0_, scratch_);
  way_ -= scratch_;
}

/// Sets force_ to elasticity and weight at x, unless it is.
void DeformableStep::take_force(const Eigen::VectorXd& x) {
  if (x == x_force_) return;
  soft_.model.force(x, force_);
  force_ += weight_;
  x_force_ = x;
}

/// Sets `sum` to D way, N s. `way` is not scratch_.
void DeformableStep::damp(const Eigen::VectorXd& way, Eigen::VectorXd& sum) {
  const ElasticModel& model = soft_.model;
  sum.setZero();
  const auto add = [&](double SoftBody::*of, const Eigen::SparseMatrix<double>& matrix) {
    bool any = false;
    for (const SoftBody& body : model.bodies()) any = any || body.*of > 0;
    if (!any) return;
    for (int u = 0; u < model.unknowns(); u += 3) {
      scratch_.segment<3>(u) = model.bodies()[static_cast<std::size_t>(model.body_of(u))].*of * way.segment<3>(u);
    }
    sum.noalias() += matrix.selfadjointView<Eigen::Lower>() * scratch_;
  };
  add(&SoftBody::damping, damping_K_);
  add(&SoftBody::drag, model.mass());
}

/// N, what may be left: the tolerance of the forces, and what rounding the places leaves.
double DeformableStep::allowed(const Eigen::VectorXd& x) const {
  const double forces =
      force_.norm() + weight_.norm() + inertia_force_.norm() + damper_force_.norm() + contact_force_.norm();
  constexpr double rounding = 4 * std::numeric_limits<double>::epsilon();
  return options_.tolerance * forces + rounding * stiffest_ * x.lpNorm<Eigen::Infinity>();
}

/// What a step lowers, by the nodes alone, with the contact forces held, J.
double DeformableStep::merit(const Eigen::VectorXd& x, double h) {
  const ElasticModel& model = soft_.model;
  double sum = model.energy(x);
  take_way(x);
  scratch_ = way_ - h * v_;
  product_.noalias() = model.mass().selfadjointView<Eigen::Lower>() * scratch_;
  sum += scratch_.dot(product_) / (2 * h * h);
  damp(way_, product_);
  sum += way_.dot(product_) / (2 * h);
  return sum - (contact_force_ + weight_).dot(way_);
}

void DeformableStep::find_contacts(const Eigen::VectorXd& x, const BodyStates& bodies) {
  for (std::size_t i = 0; i < nodes_W_.size(); ++i) nodes_W_[i] = at(x, static_cast<int>(3 * i));
  query_ = bodies;
  x_query_ = x;
  is_refreshed_ = false;
  contacts_.find(nodes_W_, bodies, found_);
}

/// Where the tool touched nothing at the start: goes along its way, and the nodes' to x_end, until it does, so that the
/// step knows what would stop it. True where there is something.
bool DeformableStep::look_ahead(const BodyStates& start, const BodyStates& end, const Eigen::VectorXd& x_end) {
  if (std::any_of(found_.begin(), found_.end(), of_tool)) return false;
  const double way = norm(end.X_WB[0].p - start.X_WB[0].p);
  const double looks = std::clamp(std::ceil(4 * way / tool_radius_), 1.0, static_cast<double>(most_looks_ahead));
  for (double k = 1; k <= looks; ++k) {
    const BodyStates there = on_the_way(start, end, k / looks);
    scratch_x_ = x0_ + (k / looks) * (x_end - x0_);
    for (std::size_t i = 0; i < nodes_W_.size(); ++i) nodes_W_[i] = at(scratch_x_, static_cast<int>(3 * i));
    contacts_.find(nodes_W_, there, ahead_);
    if (!std::any_of(ahead_.begin(), ahead_.end(), of_tool)) continue;
    std::swap(found_, ahead_);
    query_ = there;
    x_query_ = scratch_x_;
    is_refreshed_ = false;
    return true;
  }
  return false;
}

/// The contacts' convex problem about x_i_, with x_free_ known; sets contact_force_ and moves the bodies.
StepResult DeformableStep::solve_contacts(RigidStep& rigid_step, const CouplingParameters& coupling,
                                          const DeviceState& before, const DeviceState& device,
                                          const ContactPlanes& rigid, double h, double solved, BodyStates& bodies) {
  const ElasticModel& model = soft_.model;
  touching_.clear();
  int left_out = 0;
  for (SoftContact contact : found_) {
    bool known = true;
    for (std::int32_t& node : contact.node) {
      const bool fixed = model.unknown_of(node) < 0;
      node = fixed ? -1 : patch_.place_of(node);
      known = known && (fixed || node >= 0);
    }
    if (known) {
      touching_.push_back(contact);
    } else if (contact.contact.distance < 0) {
      ++left_out;
    }
  }
  contact_force_.setZero();
  StepResult result;
  if (touching_.empty()) {
    result = rigid_step.advance(coupling, before, device, rigid, h, bodies);
  } else {
    const std::vector<int>& nodes = patch_.nodes();
    const auto size = static_cast<Eigen::Index>(3 * nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const int x_at = 3 * nodes[i], u = model.unknown_of(nodes[i]);
      const auto row = static_cast<Eigen::Index>(3 * i);
      patch_p_W_[i] = at(x0_, x_at);
      patch_query_[i] = at(x_query_, x_at);
      patch_velocity_.segment<3>(row) = v_.segment<3>(u);
      patch_free_.segment<3>(row) = (x_free_.segment<3>(x_at) - x0_.segment<3>(x_at)) / solved;
    }
    patch_inertia_ = solved * solved * factor_.schur();
    const SoftPatch patch{.p_W = std::span(patch_p_W_).first(nodes.size()),
                          .inertia = patch_inertia_,
                          .velocity = patch_velocity_.head(size),
                          .free_velocity = patch_free_.head(size),
                          .contacts = touching_,
                          .query_p_W = std::span(patch_query_).first(nodes.size()),
                          .query_X_WB = std::span(query_.X_WB).first(static_cast<std::size_t>(query_.count))};
    result = rigid_step.advance(patch, coupling, before, device, rigid, h, bodies,
                                {patch_solved_.head(size), patch_force_.head(size)});
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      contact_force_.segment<3>(model.unknown_of(nodes[i])) = patch_force_.segment<3>(static_cast<Eigen::Index>(3 * i));
    }
  }
  result.left_out += left_out;
  return result;
}

/// Where a step was not solved: lets the energy of the nodes be no larger than `before` (J) and the contacts' work.
void DeformableStep::limit_energy(double before, double work) {
  const double moving = kinetic();
  const double excess = energy() - before - work;
  if (!(excess > 0) || !(moving > 0)) return;
  v_ *= excess < moving ? std::sqrt(1 - excess / moving) : 0.0;
}

double DeformableStep::energy() const {
  const ElasticModel& model = soft_.model;
  double lifted = 0;
  for (int u = 0; u < model.unknowns(); u += 3) {
    const Eigen::Index at = 3 * model.node_of(u);
    lifted += weight_.segment<3>(u).dot(x_.segment<3>(at) - model.rest().segment<3>(at));
  }
  return stored() - lifted;
}

double DeformableStep::kinetic() const {
  return 0.5 * v_.dot(soft_.model.mass().selfadjointView<Eigen::Lower>() * v_);
}

double DeformableStep::stored() const {
  return kinetic() + soft_.model.energy(x_);
}

/// J, by how much a step may be off by rounding alone.
double DeformableStep::energy_rounding(double work) const {
  constexpr double epsilon = 16 * std::numeric_limits<double>::epsilon();
  const double place = epsilon * x_.lpNorm<Eigen::Infinity>();
  return 1e-10 * (stored() + std::abs(work)) + epsilon * std::abs(energy()) +
         stiffest_ * place * place * static_cast<double>(v_.size());
}

bool DeformableStep::by_midpoint(const CouplingParameters& coupling) const {
  return rigid_step_.model().integrator == Integrator::midpoint && coupling.massless == 0;
}

/// Solves the step from x0_ and `bodies` over h seconds; leaves the solved place in x_i_. False where the iterations
/// did not do.
bool DeformableStep::solve(RigidStep& rigid_step, const CouplingParameters& coupling, const DeviceState& before,
                           const DeviceState& device, const ContactPlanes& rigid, double h, BodyStates& bodies,
                           StepResult& result) {
  const bool midpoint = &rigid_step == &rigid_step_ && by_midpoint(coupling);
  const double solved = midpoint ? h / 2 : h;
  const BodyStates start = bodies;
  result = {.outcome = StepOutcome::stopped};
  x_i_ = x0_;
  contact_force_.setZero();
  bool fresh = !options_.reuse || !(std::abs(factored_h_ - solved) <= largest_change_of_step * solved);
  if (fresh && !factor(solved, ElasticModel::Tangent::warped)) return false;
  residual(x_i_, solved, left_);
  double was_left = left_.norm();
  for (int i = 0; i < options_.iterations; ++i) {
    ++counts_.iterations;
    if (i > 0) find_contacts(x_i_, midpoint ? on_the_way(start, bodies, 0.5) : bodies);
    // Without contacts: what is left but for their force.
    without_contact_ = left_ - contact_force_;
    d_ = without_contact_;
    factor_.solve(d_);
    x_free_ = x_i_;
    add(d_, 1, x_free_);
    bodies = start;
    result = solve_contacts(rigid_step, coupling, before, device, rigid, h, solved, bodies);
    if (i == 0 && look_ahead(start, bodies, midpoint ? Eigen::VectorXd(2 * x_free_ - x0_) : x_free_)) {
      bodies = start;
      result = solve_contacts(rigid_step, coupling, before, device, rigid, h, solved, bodies);
    }
    // Contacts that have changed are no fault of the factor: what it is to solve has them.
    const double to_solve = std::max(was_left, (without_contact_ + contact_force_).norm());
    Eigen::VectorXd& x_next = x_free_;
    if (!touching_.empty()) {
      way_ = contact_force_;
      factor_.solve(way_);
      d_ += way_;
      add(way_, 1, x_next);
    }
    residual(x_next, solved, left_);
    // Nodes may be in balance without the contacts, where those were not solved.
    if (left_.norm() <= allowed(x_next) && result.outcome == StepOutcome::converged) {
      x_i_ = x_next;
      return true;
    }
    // The merit of what the way promises; halved where it does not keep it.
    double share = 1;
    if (left_.norm() > was_left) {
      const double had = merit(x_i_, solved);
      for (int k = 0; k < most_halvings_of_way && merit(x_next, solved) > had; ++k) {
        share /= 2;
        x_next = x_i_;
        add(d_, share, x_next);
      }
      if (share < 1) residual(x_next, solved, left_);
    }
    was_left = left_.norm();
    x_i_ = x_next;
    const double contraction = was_left / to_solve;
    const bool due = share < 1 || (options_.reuse ? is_factor_due(contraction, options_.iterations - i - 1, fresh)
                                                  : !(contraction <= good_contraction));
    if (due) {
      // The warped tangent lacks what stress adds, so that it may be slow however fresh it is.
      if (!factor(solved, fresh ? ElasticModel::Tangent::projected : ElasticModel::Tangent::warped)) return false;
      fresh = true;
    } else if (options_.reuse && contraction > least_to_learn) {
      without_contact_ -= left_ - contact_force_;
      if (factor_.update(d_, without_contact_)) ++counts_.updates;
    }
  }
  return false;
}

/// Takes the nodes to where `solve` has them; returns the contacts' work on them, J.
double DeformableStep::take(double h, bool midpoint) {
  const double whole = midpoint ? 2 : 1;
  take_way(x_i_);
  if (midpoint) {
    x_ = x0_;
    add(way_, whole, x_);
  } else {
    x_ = x_i_;
  }
  v_ = (whole * whole / h) * way_ - (midpoint ? v_ : Eigen::VectorXd::Zero(v_.size()));
  if (midpoint) take_force(x_);
  return whole * contact_force_.dot(way_);
}

/// Takes a step of the midpoint rule; false, and nothing has changed, where it was not solved or would leave the nodes
/// more energy than they had and contacts gave.
bool DeformableStep::advance_by_midpoint(const CouplingParameters& coupling, const DeviceState& before,
                                         const DeviceState& device, const ContactPlanes& rigid, double h,
                                         BodyStates& bodies, StepResult& result) {
  const BodyStates start = bodies;
  const Eigen::VectorXd v = v_;
  const double had = energy();
  if (solve(rigid_step_, coupling, before, device, rigid, h, bodies, result)) {
    const double work = take(h, true);
    const double spare = spare_ + had + work - energy();
    if (spare >= -energy_rounding(work) && x_.allFinite() && v_.allFinite()) {
      spare_ = std::clamp(spare, 0.0, spare_energy * stored());
      return true;
    }
  }
  bodies = start;
  x_ = x0_;
  v_ = v;
  return false;
}

void DeformableStep::refresh(const BodyStates& bodies) {
  if (is_refreshed_ && x_ == x_query_ && are_same(bodies, query_)) return;
  find_contacts(x_, bodies);
  is_refreshed_ = true;
  if (!patch_.update(x_, bodies.X_WB[0], bodies.V_WB[0], found_)) return;
  // Another patch is eliminated in another order.
  analysed_ = false;
  factored_h_ = 0;
}

StepResult DeformableStep::advance(const CouplingParameters& coupling, const DeviceState& before,
                                   const DeviceState& device, const ContactPlanes& rigid, double h,
                                   BodyStates& bodies) {
  const BodyStates start = bodies;
  x0_ = x_;
  refresh(bodies);
  prepare_damping(h);
  ++counts_.steps;
  StepResult result;
  if (by_midpoint(coupling)) {
    if (advance_by_midpoint(coupling, before, device, rigid, h, bodies, result)) {
      counts_.left_out += result.left_out;
      return result;
    }
    ++counts_.by_euler;
    find_contacts(x_, bodies);
  }
  const bool converged = solve(euler_step_, coupling, before, device, rigid, h, bodies, result);
  // The energy costs as much as the forces do, and a step of implicit Euler that is solved gains none.
  const bool is_watched = by_midpoint(coupling) || !converged;
  const double had = is_watched ? energy() : 0;
  const double work = take(h, false);
  if (is_watched) spare_ = std::clamp(spare_ + had + work - energy(), 0.0, spare_energy * stored());
  if (!x_.allFinite() || !v_.allFinite()) {
    x_ = x0_;
    v_.setZero();
    bodies = start;
    for (Twist& V : bodies.V_WB) V = {};
    result = {.outcome = StepOutcome::stopped, .left_out = result.left_out};
    factored_h_ = 0;
  }
  if (!converged) {
    take_force(x_);
    ++counts_.damped;
    limit_energy(had, work);
    if (result.outcome == StepOutcome::converged) result.outcome = StepOutcome::damped;
  }
  counts_.left_out += result.left_out;
  return result;
}

}  // namespace tactor
