#include "nodes/physics/deformable/deformable_step.hpp"

#include <algorithm>
#include <cmath>

#include "framework/core/check.hpp"
#include "nodes/physics/mechanics/eigen.hpp"

namespace tactor {

namespace {

constexpr double good_contraction = 1.0 / 3;  // of what an iteration leaves
constexpr int most_halvings_of_way = 6;

Vec3 at(const Eigen::VectorXd& x, int first) {
  return {x[first], x[first + 1], x[first + 2]};
}

}  // namespace

DeformableStep::DeformableStep(const SoftScene& soft, SoftContacts& contacts, const ContactBody& tool,
                               const SystemModel& model, const DeformableOptions& options, const Vec3& gravity_W)
    : soft_(soft),
      contacts_(contacts),
      options_(options),
      rigid_step_(model, RigidStep::most_patch_nodes),
      patch_(soft, tool, options.patch),
      factor_(make_factor(options.factor, soft.model.elements())),
      weight_(soft.model.weight(gravity_W)),
      x_(soft.model.rest()),
      v_(Eigen::VectorXd::Zero(soft.model.unknowns())) {
  const Eigen::Index n = soft.model.unknowns();
  for (Eigen::VectorXd* v :
       {&force_, &inertia_force_, &damper_force_, &contact_force_, &left_, &d_, &scratch_, &way_}) {
    v->setZero(n);
  }
  x0_ = x_i_ = x_free_ = x_;
  constexpr Eigen::Index patch = 3 * RigidStep::most_patch_nodes;
  for (Eigen::VectorXd* v : {&patch_velocity_, &patch_free_, &patch_solved_, &patch_force_}) v->setZero(patch);
  nodes_W_.resize(static_cast<std::size_t>(soft.model.nodes()));
  patch_p_W_.resize(RigidStep::most_patch_nodes);
  patch_query_.resize(RigidStep::most_patch_nodes);
  found_.reserve(ContactSet::capacity);
  touching_.reserve(ContactSet::capacity);
}

void DeformableStep::place(const Eigen::VectorXd& x) {
  x_ = x;
  v_.setZero();
}

void DeformableStep::place(const Eigen::VectorXd& x, const Eigen::VectorXd& v) {
  x_ = x;
  v_ = v;
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

/// Assembles K at x_i_ and factors A for a step of h seconds.
void DeformableStep::factor(double h, ElasticModel::Tangent tangent) {
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
    std::vector<int> last;
    for (const int node : patch_.nodes()) last.push_back(model.unknown_of(node) / 3);
    factor_->analyze(A_, last);
    analysed_ = true;
  }
  TACTOR_DEMAND(factor_->factor(A_));
  factored_h_ = h;
  ++counts_.factors;
  if (!patch_.nodes().empty()) {
    factor_->schur(patch_inertia_);
    patch_inertia_ *= h * h;
  }
}

/// What is left of the nodes' equation at x, with the contact forces in contact_force_; fills the forces that make it
/// up.
void DeformableStep::residual(const Eigen::VectorXd& x, double h, Eigen::VectorXd& left) {
  const ElasticModel& model = soft_.model;
  model.force(x, force_);
  force_ += weight_;
  // way_ = x - x0, scratch_ = way - h v.
  by_unknown(x, way_);
  by_unknown(x0_, scratch_);
  way_ -= scratch_;
  scratch_ = way_ - h * v_;
  inertia_force_.noalias() = model.mass().selfadjointView<Eigen::Lower>() * scratch_;
  inertia_force_ /= -h * h;
  for (int u = 0; u < model.unknowns(); u += 3) {
    const SoftBody& body = model.bodies()[static_cast<std::size_t>(model.body_of(u))];
    scratch_.segment<3>(u) = -(body.damping / h) * way_.segment<3>(u);
  }
  damper_force_.noalias() = K_.selfadjointView<Eigen::Lower>() * scratch_;
  bool drags = false;
  for (const SoftBody& body : model.bodies()) drags = drags || body.drag > 0;
  if (drags) {
    for (int u = 0; u < model.unknowns(); u += 3) {
      const SoftBody& body = model.bodies()[static_cast<std::size_t>(model.body_of(u))];
      scratch_.segment<3>(u) = -(body.drag / h) * way_.segment<3>(u);
    }
    damper_force_.noalias() += model.mass().selfadjointView<Eigen::Lower>() * scratch_;
  }
  left = force_ + inertia_force_ + damper_force_ + contact_force_;
}

/// N, the forces that the residual is judged by.
double DeformableStep::scale(double h) const {
  // At rest without weight nothing else has a size.
  const double least = 1e-9 * soft_.model.mass().diagonal().sum() / (h * h) * 1e-3;
  return force_.norm() + weight_.norm() + inertia_force_.norm() + damper_force_.norm() + contact_force_.norm() + least;
}

/// What a step lowers, by the nodes alone, with the contact forces held, J.
double DeformableStep::merit(const Eigen::VectorXd& x, double h) const {
  const ElasticModel& model = soft_.model;
  double sum = model.energy(x);
  Eigen::VectorXd way(model.unknowns()), start(model.unknowns());
  by_unknown(x, way);
  by_unknown(x0_, start);
  way -= start;
  const Eigen::VectorXd off = way - h * v_;
  sum += off.dot(model.mass().selfadjointView<Eigen::Lower>() * off) / (2 * h * h);
  Eigen::VectorXd damped = way;
  for (int u = 0; u < model.unknowns(); u += 3) {
    damped.segment<3>(u) *= model.bodies()[static_cast<std::size_t>(model.body_of(u))].damping;
  }
  sum += way.dot(K_.selfadjointView<Eigen::Lower>() * damped) / (2 * h);
  return sum - (contact_force_ + weight_).dot(way);
}

void DeformableStep::find_contacts(const Eigen::VectorXd& x, const BodyStates& bodies) {
  for (std::size_t i = 0; i < nodes_W_.size(); ++i) nodes_W_[i] = at(x, static_cast<int>(3 * i));
  query_ = bodies;
  contacts_.find(nodes_W_, bodies, found_);
}

/// The contacts' convex problem about x_i_, with x_free_ known; sets contact_force_ and moves the bodies.
StepResult DeformableStep::solve_contacts(const CouplingParameters& coupling, const DeviceState& before,
                                          const DeviceState& device, const ContactPlanes& rigid, double h,
                                          double solved, BodyStates& bodies) {
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
    result = rigid_step_.advance(coupling, before, device, rigid, h, bodies);
  } else {
    const std::vector<int>& nodes = patch_.nodes();
    const auto size = static_cast<Eigen::Index>(3 * nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const int x_at = 3 * nodes[i], u = model.unknown_of(nodes[i]);
      const auto row = static_cast<Eigen::Index>(3 * i);
      patch_p_W_[i] = at(x0_, x_at);
      patch_query_[i] = at(x_i_, x_at);
      patch_velocity_.segment<3>(row) = v_.segment<3>(u);
      patch_free_.segment<3>(row) = (x_free_.segment<3>(x_at) - x0_.segment<3>(x_at)) / solved;
    }
    const SoftPatch patch{.p_W = std::span(patch_p_W_).first(nodes.size()),
                          .inertia = patch_inertia_,
                          .velocity = patch_velocity_.head(size),
                          .free_velocity = patch_free_.head(size),
                          .contacts = touching_,
                          .query_p_W = std::span(patch_query_).first(nodes.size()),
                          .query_X_WB = std::span(query_.X_WB).first(static_cast<std::size_t>(query_.count))};
    result = rigid_step_.advance(patch, coupling, before, device, rigid, h, bodies,
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
  const double kinetic = 0.5 * v_.dot(soft_.model.mass().selfadjointView<Eigen::Lower>() * v_);
  const double excess = energy() - before - work;
  if (!(excess > 0) || !(kinetic > 0)) return;
  v_ *= excess < kinetic ? std::sqrt(1 - excess / kinetic) : 0.0;
}

double DeformableStep::energy() const {
  Eigen::VectorXd way(soft_.model.unknowns()), rest(soft_.model.unknowns());
  by_unknown(x_, way);
  by_unknown(soft_.model.rest(), rest);
  return 0.5 * v_.dot(soft_.model.mass().selfadjointView<Eigen::Lower>() * v_) + soft_.model.energy(x_) -
         weight_.dot(way - rest);
}

StepResult DeformableStep::advance(const CouplingParameters& coupling, const DeviceState& before,
                                   const DeviceState& device, const ContactPlanes& rigid, double h,
                                   BodyStates& bodies) {
  const bool midpoint = rigid_step_.model().integrator == Integrator::midpoint && coupling.massless == 0;
  const double solved = midpoint ? h / 2 : h;
  const BodyStates start = bodies;
  x0_ = x_;
  x_i_ = x_;
  find_contacts(x_, bodies);
  if (patch_.update(x_, bodies.X_WB[0], bodies.V_WB[0], found_)) {
    analysed_ = false;
    factored_h_ = 0;
  }
  ++counts_.steps;

  bool fresh = !options_.reuse || factored_h_ != solved;
  if (fresh) factor(solved, ElasticModel::Tangent::warped);
  contact_force_.setZero();
  residual(x_i_, solved, left_);
  double was_left = left_.norm();
  bool converged = false;
  StepResult result;
  for (int i = 0; i < options_.iterations && !converged; ++i) {
    ++counts_.iterations;
    if (i > 0) find_contacts(x_i_, bodies);
    // Without contacts: what is left but for their force.
    d_ = left_ - contact_force_;
    factor_->solve(d_);
    x_free_ = x_i_;
    add(d_, 1, x_free_);
    bodies = start;
    result = solve_contacts(coupling, before, device, rigid, h, solved, bodies);
    way_ = contact_force_;
    factor_->solve(way_);
    d_ += way_;
    Eigen::VectorXd& x_next = x_free_;
    add(way_, 1, x_next);
    residual(x_next, solved, left_);
    converged = left_.norm() <= options_.tolerance * scale(solved);
    if (!converged) {
      // The merit of what the way promises; halved where it does not keep it.
      double share = 1;
      if (left_.norm() > was_left) {
        const double had = merit(x_i_, solved);
        for (int k = 0; k < most_halvings_of_way && merit(x_next, solved) > had; ++k) {
          share /= 2;
          x_next = x_i_;
          add(d_, share, x_next);
        }
        residual(x_next, solved, left_);
      }
      const bool slow = share < 1 || left_.norm() > good_contraction * was_left;
      was_left = left_.norm();
      x_i_ = x_next;
      if (slow) {
        // The warped tangent lacks what stress adds, so that it may be slow however fresh it is.
        factor(solved, fresh ? ElasticModel::Tangent::projected : ElasticModel::Tangent::warped);
        residual(x_i_, solved, left_);
        fresh = true;
      }
    } else {
      x_i_ = x_next;
    }
  }
  const double energy_before = converged ? 0 : energy();
  const double work = converged ? 0 : contact_force_.dot(way_);
  by_unknown(x_i_, way_);
  by_unknown(x0_, scratch_);
  way_ -= scratch_;
  if (midpoint) {
    x_ = x0_;
    add(way_, 2, x_);
    v_ = (2 / solved) * way_ - v_;
    soft_.model.force(x_, force_);
    force_ += weight_;
  } else {
    x_ = x_i_;
    v_ = way_ / solved;
  }
  if (!converged) {
    ++counts_.damped;
    limit_energy(energy_before, work);
    if (result.outcome == StepOutcome::converged) result.outcome = StepOutcome::damped;
  }
  counts_.left_out += result.left_out;
  return result;
}

}  // namespace tactor
