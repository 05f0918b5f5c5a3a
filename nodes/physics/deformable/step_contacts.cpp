#include "nodes/physics/deformable/step_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "nodes/physics/mechanics/eigen.hpp"

namespace tactor {

namespace {

constexpr int most_looks_ahead = 16;

/// Whether the same bodies are at the same places with the same velocities, to the bit.
bool are_same(const BodyStates& a, const BodyStates& b) {
  const auto count = static_cast<std::size_t>(a.count);
  return a.count == b.count && std::memcmp(a.X_WB.data(), b.X_WB.data(), count * sizeof(a.X_WB[0])) == 0 &&
         std::memcmp(a.V_WB.data(), b.V_WB.data(), count * sizeof(a.V_WB[0])) == 0;
}

bool of_tool(const SoftContact& contact) {
  return contact.body == 0;
}

}  // namespace

BodyStates on_the_way(const BodyStates& start, const BodyStates& end, double share) {
  BodyStates there = start;
  for (std::size_t i = 0; i < static_cast<std::size_t>(start.count); ++i) {
    const Pose &X0 = start.X_WB[i], &X1 = end.X_WB[i];
    there.X_WB[i] = {X0.p + share * (X1.p - X0.p),
                     from_rotation_vector(share * to_rotation_vector(X1.R * inverse(X0.R))) * X0.R};
  }
  return there;
}

StepContacts::StepContacts(const ElasticModel& model, SoftContacts& contacts, double tool_radius)
    : contacts_(contacts),
      tool_radius_(tool_radius),
      x_(model.rest()),
      x_ahead_(model.rest()),
      nodes_W_(static_cast<std::size_t>(model.nodes())) {
  found_.reserve(ContactSet::capacity);
  ahead_.reserve(ContactSet::capacity);
}

void StepContacts::look(const Eigen::VectorXd& x, const BodyStates& bodies, std::vector<SoftContact>& found) {
  for (std::size_t i = 0; i < nodes_W_.size(); ++i) nodes_W_[i] = plain(x.segment<3>(static_cast<Eigen::Index>(3 * i)));
  contacts_.find(nodes_W_, bodies, found);
}

void StepContacts::find(const Eigen::VectorXd& x, const BodyStates& bodies) {
  bodies_ = bodies;
  x_ = x;
  is_refreshed_ = false;
  look(x, bodies, found_);
}

bool StepContacts::refresh(const Eigen::VectorXd& x, const BodyStates& bodies) {
  if (is_refreshed_ && x == x_ && are_same(bodies, bodies_)) return false;
  find(x, bodies);
  is_refreshed_ = true;
  return true;
}

bool StepContacts::look_ahead(const BodyStates& start, const BodyStates& end, const Eigen::VectorXd& x0,
                              const Eigen::VectorXd& x_end) {
  if (std::any_of(found_.begin(), found_.end(), of_tool)) return false;
  const double way = norm(end.X_WB[0].p - start.X_WB[0].p);
  const double looks = std::clamp(std::ceil(4 * way / tool_radius_), 1.0, static_cast<double>(most_looks_ahead));
  for (double k = 1; k <= looks; ++k) {
    const BodyStates there = on_the_way(start, end, k / looks);
    x_ahead_ = x0 + (k / looks) * (x_end - x0);
    look(x_ahead_, there, ahead_);
    if (!std::any_of(ahead_.begin(), ahead_.end(), of_tool)) continue;
    std::swap(found_, ahead_);
    bodies_ = there;
    x_.swap(x_ahead_);
    is_refreshed_ = false;
    return true;
  }
  return false;
}

}  // namespace tactor
