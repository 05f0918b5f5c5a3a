#include "nodes/forcefield/static_force.hpp"

#include <span>

#include "nodes/physics/mechanics/scene_model.hpp"

namespace tactor {

namespace {

constexpr int most_steps = 100;
constexpr int newton_steps = 10;
constexpr double settled_within = 1e-9;  // m

}  // namespace

void check_static_force(const Scene& scene, double margin, std::vector<std::string>* notes) {
  const SceneContacts contacts(scene, {.margin = margin}, tree_distances(), nullptr, notes);
}

StaticForce::StaticForce(const Scene& scene, double k_t, double margin, std::vector<std::string>* notes)
    : contacts_(scene, {.margin = margin}, cell_distances({}, notes), nullptr, notes),
      step_(scene_model("forcefield.rbf", scene, notes)),
      coupling_{.k_t = k_t, .massless = 1},
      R_WT_(scene.tool()->X_WB.R) {}

StaticForce::Result StaticForce::at(const Vec3& p_WD) {
  Result result;
  DeviceState handle;
  handle.X_WD.p = p_WD;
  BodyStates tool;
  tool.count = 1;
  tool.X_WB[0] = {p_WD, R_WT_};
  for (int i = 0; i < most_steps && !result.settled; ++i) {
    const Vec3 before = tool.X_WB[0].p;
    contacts_.find(tool, set_);
    const std::span contacts(set_.contact.data(), static_cast<std::size_t>(set_.count));
    if (i == 0) {
      result.near = set_.count > 0;
      if (set_.penetrating == 0) return {{}, result.near, true};
    }
    if (i < newton_steps) {
      for (Contact& contact : contacts) contact.friction = 0;
      // Of a balance without friction the length of the step does not matter.
      step_.advance(coupling_, handle, handle, contact_planes(set_), 1, tool);
      result.settled = norm(tool.X_WB[0].p - before) < settled_within;
      continue;
    }
    Vec3 out = coupling_.k_t * (p_WD - before);  // N, what is left of the balance
    double stiffness = coupling_.k_t;
    for (const Contact& contact : contacts) {
      if (contact.distance >= 0) continue;
      const double k = contact.stiffness * contact.weight;
      out -= k * contact.distance * contact.n_W;
      stiffness += k;
    }
    tool.X_WB[0].p += out / (stiffness * (1 + 0.5 * (i - newton_steps)));
  }
  result.force = -coupling_.k_t * (p_WD - tool.X_WB[0].p);
  return result;
}

}  // namespace tactor
