#include "nodes/physics/deformable/node_equation.hpp"

#include <limits>

namespace tactor {

NodeEquation::NodeEquation(const ElasticModel& model, const Vec3& gravity_W)
    : model_(model), weight_(model.weight(gravity_W)), x0_(model.rest()), halfway_(model.rest()) {
  for (Eigen::VectorXd* v :
       {&v0_, &force_, &inertia_force_, &damper_force_, &contact_force_, &way_, &scratch_, &product_}) {
    v->setZero(model.unknowns());
  }
  x_force_.setConstant(x0_.size(), std::numeric_limits<double>::quiet_NaN());
}

void NodeEquation::begin(const Eigen::VectorXd& x, const Eigen::VectorXd& v, double h) {
  x0_ = x;
  v0_ = v;
  for (const SoftBody& body : model_.bodies()) {
    if (body.damping > 0) {
      // There a way that turns strains nothing.
      halfway_ = x0_;
      model_.displace(v0_, h / 2, halfway_);
      model_.assemble(halfway_, ElasticModel::Tangent::warped, damping_K_, scratch_);
      return;
    }
  }
}

void NodeEquation::residual(const Eigen::VectorXd& x, double h, Eigen::VectorXd& left) {
  inner_force(x);
  way_to(x);
  scratch_ = way_ - h * v0_;
  inertia_force_.noalias() = model_.mass().selfadjointView<Eigen::Lower>() * scratch_;
  inertia_force_ /= -h * h;
  damp(way_, damper_force_);
  damper_force_ /= -h;
  left = force_ + inertia_force_ + damper_force_ + contact_force_;
}

double NodeEquation::forces() const {
  return force_.norm() + weight_.norm() + inertia_force_.norm() + damper_force_.norm() + contact_force_.norm();
}

double NodeEquation::merit(const Eigen::VectorXd& x, double h) {
  double sum = model_.energy(x);
  way_to(x);
  scratch_ = way_ - h * v0_;
  product_.noalias() = model_.mass().selfadjointView<Eigen::Lower>() * scratch_;
  sum += scratch_.dot(product_) / (2 * h * h);
  damp(way_, product_);
  sum += way_.dot(product_) / (2 * h);
  return sum - (contact_force_ + weight_).dot(way_);
}

const Eigen::VectorXd& NodeEquation::way_to(const Eigen::VectorXd& x) {
  by_unknown(x, way_);
  by_unknown(x0_, scratch_);
  way_ -= scratch_;
  return way_;
}

const Eigen::VectorXd& NodeEquation::inner_force(const Eigen::VectorXd& x) {
  if (x == x_force_) return force_;
  model_.force(x, force_);
  force_ += weight_;
  x_force_ = x;
  return force_;
}

double NodeEquation::kinetic(const Eigen::VectorXd& v) const {
  return 0.5 * v.dot(model_.mass().selfadjointView<Eigen::Lower>() * v);
}

double NodeEquation::stored(const Eigen::VectorXd& x, const Eigen::VectorXd& v) const {
  return kinetic(v) + model_.energy(x);
}

double NodeEquation::energy(const Eigen::VectorXd& x, const Eigen::VectorXd& v) const {
  return stored(x, v) - model_.work(weight_, x);
}

void NodeEquation::by_unknown(const Eigen::VectorXd& x, Eigen::VectorXd& values) const {
  for (int u = 0; u < model_.unknowns(); u += 3) values.segment<3>(u) = x.segment<3>(3 * model_.node_of(u));
}

/// Sets `sum` to D way, N s. `way` is not scratch_.
void NodeEquation::damp(const Eigen::VectorXd& way, Eigen::VectorXd& sum) {
  sum.setZero();
  const auto add = [&](double SoftBody::*of, const Eigen::SparseMatrix<double>& matrix) {
    bool any = false;
    for (const SoftBody& body : model_.bodies()) any = any || body.*of > 0;
    if (!any) return;
    for (int u = 0; u < model_.unknowns(); u += 3) {
      scratch_.segment<3>(u) = model_.bodies()[static_cast<std::size_t>(model_.body_of(u))].*of * way.segment<3>(u);
    }
    sum.noalias() += matrix.selfadjointView<Eigen::Lower>() * scratch_;
  };
  add(&SoftBody::damping, damping_K_);
  add(&SoftBody::drag, model_.mass());
}

}  // namespace tactor
