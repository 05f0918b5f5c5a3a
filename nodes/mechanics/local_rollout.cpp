#include "nodes/mechanics/local_rollout.hpp"

namespace tactor {

void LocalRollout::restart(const LocalModel& model) {
  local_ = model;
  last_ = {};
}

bool LocalRollout::advance(const Stamped<DeviceState>& sample) {
  const double h = (sample.stamp.valid - local_.time).seconds();
  if (h <= 0) return true;
  find_planes();
  const auto bodies = static_cast<std::size_t>(local_.bodies.count), count = static_cast<std::size_t>(local_.contacts.count);
  // The planes are those of now.
  const BodyStates now = local_.bodies;
  const ContactPlanes planes{std::span(now.X_WB).first(bodies), std::span(planes_).first(count),
                             std::span(local_.contacts.pair).first(count)};
  last_ = step_.advance(local_.law, local_.device, sample.value, planes, h, local_.bodies);
  acceleration_ = {(1 / h) * (local_.bodies.V_WB[0].v - now.V_WB[0].v), (1 / h) * (local_.bodies.V_WB[0].w - now.V_WB[0].w)};
  local_.device = sample.value;
  local_.time = sample.stamp.valid;
  return last_.outcome != StepOutcome::stopped;
}

void LocalRollout::find_planes() {
  const LocalContacts& local = local_.contacts;
  const auto anchors = static_cast<std::size_t>(local.anchors);
  for (std::size_t i = 0; i < static_cast<std::size_t>(local.count); ++i) {
    const auto body = static_cast<std::size_t>(local.pair[i].body);
    Contact& plane = planes_[i];
    plane = local.contact[i][0];
    double sum = 0, distance = 0, weight = 0;
    Vec3 n, p;
    for (std::size_t j = 0; j < anchors; ++j) {
      const ContactPlanes at{std::span(local.X_WB[j]).first(static_cast<std::size_t>(local.bodies)), std::span(&local.contact[i][j], 1), std::span(&local.pair[i], 1)};
      const PlaneNow now = plane_now(at, 0, local_.bodies.X_WB);
      const Vec3 away = now.p_W - transform(local.X_WB[j][body], local.contact[i][j].p_TC);
      const double share = 1 / (dot(away, away) + 1e-10);
      sum += share;
      distance += share * now.distance;
      weight += share * local.contact[i][j].weight;
      n += share * now.n_W;
      p += share * now.p_W;
    }
    const double length = norm(n);
    plane.n_W = (1 / length) * n;
    plane.distance = distance / sum;
    plane.weight = weight / sum;
    plane.p_TC = transform(inverse(local_.bodies.X_WB[body]), (1 / sum) * p);
  }
}

PhysicsState LocalRollout::state() const {
  return {.X_WT = local_.bodies.X_WB[0],
          .V_WT = local_.bodies.V_WB[0],
          .X_WD = local_.device.X_WD,
          .V_WD = local_.device.V_WD,
          .contact_T_W = last_.contact_T_W,
          .contacts = last_.touching};
}

}  // namespace tactor
