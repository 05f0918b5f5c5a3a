// A program whose physics is MassAndWall, with its own light copy as the rollout of a shipped overlay.
#pragma once

#include <array>
#include <cmath>

#include "framework/session/physics_loop.hpp"
#include "tests/own_physics/ball.hpp"
#include "tests/own_physics/mass_and_wall.hpp"

namespace tactor::test {

/// The plan of a text, with the program's copy as its method.
inline Plan planned_with_copy(const std::string& text) {
  const TemporaryFolder folder;
  return make_plan(load_graph(write(folder.path() / "graph.yaml", text), registry(),
                              Overrides{over_patch(graphs / "own_physics/copy.yaml")}));
}

/// Steps the mass until the run ends, with sub-steps of at most 0.25 ms. `with_copy`: each result tells the state of
/// the light copy.
inline void run_mass(PhysicsLoop& loop, bool with_copy = true) {
  std::array<double, MassAndWall::numbers> state{};
  bool begun = false;
  while (const auto step = loop.next()) {
    const Vec3& p = step->from.X_WD.p;
    if (!begun) state = {p.x, p.y, p.z};
    begun = true;
    const double count = std::ceil(step->h() / 2.5e-4 - 1e-6), h = step->h() / count;
    CopyTool tool;
    for (double i = 1; i <= count; ++i) {
      const Time t = step->begin + Duration::from_seconds(i * h);
      tool = MassAndWall::step(state, {h, step->handle_at(t), step->coupling});
    }
    PhysicsResult result{.X_WT = tool.X_WT, .V_WT = tool.V_WT};
    if (with_copy) result.copy_state = state;
    loop.result(*step, result);
  }
}

}  // namespace tactor::test
