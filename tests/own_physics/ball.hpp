// A program with physics of its own: a ball on a plane, with a graph around it.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "framework/session/physics_loop.hpp"
#include "tests/support/shipped_graphs.hpp"

namespace tactor::test {

/// A ball of 50 g that slides without friction on the plane z = 0, by semi-implicit steps.
class Ball {
 public:
  static constexpr double mass = 0.05, radius = 4e-3, stiffness = 2000, damping = 2;

  /// Where it is at the end of the step, after sub-steps of at most `longest` s.
  void move(const PhysicsStep& step, double longest = 5e-5) {
    const auto substeps = static_cast<int>(std::ceil(step.h() / longest));
    const double h = step.h() / substeps;
    if (!begun_) p_ = step.from.X_WD.p;
    begun_ = true;
    for (int i = 1; i <= substeps; ++i) {
      const Time t = step.begin + Duration::from_seconds(i * h);
      const Vec3 pull =
          explicit_wrench(step.coupling, step.handle_at(t), {.X_WT = {p_, {}}, .V_WT = {v_, {}}, .mass = mass}, h)
              .force;
      v_ += (h / mass) * (pull + push());
      p_ += h * v_;
    }
  }
  /// N, of the plane.
  [[nodiscard]] Vec3 push() const { return {0, 0, std::max(0.0, -stiffness * (p_.z - radius) - damping * v_.z)}; }
  /// The contact is told 15 mm before it touches.
  [[nodiscard]] ContactSet contacts() const {
    ContactSet set;
    if (p_.z - radius > 0.015) return set;
    set.count = 1;
    Contact& c = set.contact[0];
    c.p_TC = {0, 0, -radius};
    c.p_WC = {p_.x, p_.y, 0};
    c.n_W = {0, 0, 1};
    c.distance = p_.z - radius;
    c.weight = 1;
    c.stiffness = stiffness;
    c.damping = damping;
    return set;
  }
  [[nodiscard]] Pose pose() const { return {p_, {}}; }
  [[nodiscard]] Twist twist() const { return {v_, {}}; }

 private:
  Vec3 p_, v_;
  bool begun_ = false;
};

inline const std::string ball_scene = R"(
scene:
  gravity: [0, 0, 0]
  bodies:
    wall:
      plane: {}
    tool:
      sphere: {radius: 4 mm}
      motion: translation
      mass: 50 g
      pose: {p: [0, 0, 0.02 m]}
)";

/// The hand presses, slides and leaves.
inline const std::string pressing_hand = R"(
  trajectory:
    type: source.trajectory
    interpolation: minimum_jerk
    points:
      - {t: 0 s, z: 12 mm}
      - {t: 0.3 s, z: 12 mm}
      - {t: 0.5 s, z: 0 mm}
      - {t: 0.8 s, z: 2 mm, x: 20 mm}
      - {t: 1.1 s, z: -1 mm, x: -10 mm}
      - {t: 1.3 s, z: 10 mm}
      - {t: 1.45 s, z: 1 mm}
      - {t: 1.6 s, z: 12 mm}
)";

inline const std::string still_hand = R"(
  trajectory:
    type: source.trajectory
    points:
      - {t: 0 s, z: -2 mm}
      - {t: 1 s, z: -2 mm}
)";

inline const std::string held = R"(
  prediction: {type: prediction.hold}
  interpolation: {type: interpolation.none}
edges:
  - coupling.force -> prediction.force
  - prediction.forecast -> interpolation.forecast
  - interpolation.segment -> device.segment
)";

inline const std::string rolled_out = R"(
  local: {type: prediction.local, cost: {constant: 0.3 ms}}
  rollout: {type: interpolation.rollout, contacts: anchors, restart: always}
edges:
  - physics.bodies -> local.bodies
  - physics.contacts -> local.found
  - physics.state -> local.state
  - coupling.parameters -> local.coupling
  - device.state -> local.device
  - local.model -> rollout.model
  - device.state -> rollout.device
  - rollout.segment -> device.segment
)";

/// A graph around physics.external. `record`: outputs; `method`: `held` or `rolled_out`.
inline std::string graph_text(const std::string& head, const std::string& hand, double rate, const std::string& method,
                              const std::string& record) {
  return "format: 2\nseed: 1\n" + head + "\nrecord: [" + record + "]" + ball_scene + "nodes:" + hand +
         "  device: {type: device.simulated}\n  coupling: {type: coupling.dynamic}\n" +
         "  physics: {type: physics.external, rate: " + std::to_string(rate) + "}" + method +
         "  - trajectory.target -> device.target\n"
         "  - device.state -> physics.device\n"
         "  - coupling.parameters -> physics.coupling\n"
         "  - physics.state -> coupling.state\n";
}

inline Plan planned_text(const std::string& text) {
  const TemporaryFolder folder;
  return make_plan(load_graph(write(folder.path() / "graph.yaml", text), registry()));
}

/// All messages of an output, from now on.
template <class T>
std::vector<Stamped<T>>& keep(Session& session, const std::string& output, std::vector<Stamped<T>>& messages) {
  kept(output, messages)(session);
  return messages;
}

/// Steps the ball until the run ends; tells its contacts and their force.
inline void run_ball(Session& session, const std::function<void(const PhysicsStep&)>& meanwhile = {}) {
  Ball ball;
  PhysicsLoop loop(session);
  while (const auto step = loop.next()) {
    ball.move(*step);
    if (meanwhile) meanwhile(*step);
    const ContactSet contacts = ball.contacts();
    loop.result(
        *step,
        {.X_WT = ball.pose(), .V_WT = ball.twist(), .contact_T_W = Wrench{ball.push(), {}}, .contacts = &contacts});
  }
}

}  // namespace tactor::test
