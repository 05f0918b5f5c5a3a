#include "bench/rollout_course.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <numbers>
#include <sstream>
#include <utility>

#include "framework/core/check.hpp"
#include "nodes/physics/contact/surface_contacts.hpp"
#include "nodes/physics/mechanics/rollout_parameters.hpp"
#include "tests/support/nodes.hpp"
#include "tests/support/shapes.hpp"

namespace tactor::bench {

namespace {

constexpr double pressed = 2e-4;       // m, depth of the tool in the surface
constexpr double bowl = 0.05;          // m, radius of the surface that the ring's contacts tell of
constexpr double ring = 0.008;         // m, radius of the ring of contacts under the tool
constexpr double anchor_time = 0.015;  // s

/// A handle that slides to and fro with some tremor, 1 mm deeper than the tool.
DeviceState sliding_handle(double t) {
  const double w = 2 * std::numbers::pi * 2, u = 2 * std::numbers::pi * 10;
  DeviceState s;
  s.X_WD.p = {5e-3 * std::sin(w * t), 0, -1e-3 + 5e-5 * std::sin(u * t)};
  s.V_WD.v = {5e-3 * w * std::cos(w * t), 0, 5e-5 * u * std::cos(u * t)};
  return s;
}

BodyStates sliding_tool(double t) {
  const DeviceState handle = sliding_handle(t);
  BodyStates bodies;
  bodies.count = 1;
  bodies.X_WB[0].p = {handle.X_WD.p.x, 0, 0};
  bodies.V_WB[0].v = {handle.V_WD.v.x, 0, 0};
  return bodies;
}

/// A ring of contacts, all of which touch and slide, looked up at three anchors.
LocalContacts ring_at(double t, int count) {
  LocalContacts local;
  local.anchors = LocalContacts::max_anchors;
  local.bodies = 1;
  local.count = count;
  for (std::size_t j = 0; j < LocalContacts::max_anchors; ++j) {
    Pose X_WT = sliding_tool(t).X_WB[0];
    X_WT.p += static_cast<double>(j) * anchor_time * sliding_tool(t).V_WB[0].v;
    local.X_WB[j][0] = X_WT;
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(i) / count;
      Contact& c = local.contact[i][j];
      c.p_TC = {ring * std::cos(angle), ring * std::sin(angle), -0.01};
      // The bowl is the same wherever the tool slides: what is timed is the arithmetic.
      const Vec3 lean{-c.p_TC.x / bowl, -c.p_TC.y / bowl, 1};
      c.n_W = (1 / norm(lean)) * lean;
      c.distance = -pressed;
      c.p_WC = transform(X_WT, c.p_TC) + pressed * c.n_W;
      c.weight = 8.0 / count;
      c.stiffness = 2000;
      c.damping = 2;
      c.friction = 0.3;
      c.H_W = {1 / bowl, 0, 0, 1 / bowl, 0, 0};
    }
  }
  return local;
}

/// What physics would feel of these contacts at their first anchor, where all of them slide.
PhysicsState felt_at(double t, const LocalContacts& local) {
  PhysicsState state;
  state.X_WT = sliding_tool(t).X_WB[0];
  state.V_WT = sliding_tool(t).V_WB[0];
  state.contacts = local.count;
  const Vec3 v = state.V_WT.v;
  for (std::size_t i = 0; i < static_cast<std::size_t>(local.count); ++i) {
    const Contact& c = local.contact[i][0];
    const double N = std::max(0.0, -c.weight * (c.stiffness * c.distance + c.damping * dot(c.n_W, v)));
    const Vec3 sliding = v - dot(c.n_W, v) * c.n_W;
    const double speed = norm(sliding);
    const Vec3 force = N * c.n_W - (speed > 0 ? c.friction * N / speed : 0) * sliding;
    state.contact_T_W.force += force;
    state.contact_T_W.torque += cross(rotate(state.X_WT.R, c.p_TC), force);
  }
  return state;
}

/// A slab with a top of squares of 2 mm, at z = 0.
TriangleMesh slab() {
  constexpr int n = 40;
  constexpr double a = 0.002, thick = 0.02;
  TriangleMesh mesh;
  for (int side = 0; side < 2; ++side) {
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j <= n; ++j) mesh.vertices.push_back({a * (i - n / 2), a * (j - n / 2), -thick * side});
    }
  }
  const auto at = [](int i, int j, int side) { return side * (n + 1) * (n + 1) + i * (n + 1) + j; };
  const auto square = [&mesh](int p, int q, int r, int s) {
    mesh.faces.push_back({p, q, r});
    mesh.faces.push_back({p, r, s});
  };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      square(at(i, j, 0), at(i + 1, j, 0), at(i + 1, j + 1, 0), at(i, j + 1, 0));
      square(at(i, j, 1), at(i, j + 1, 1), at(i + 1, j + 1, 1), at(i + 1, j, 1));
    }
    square(at(i, 0, 0), at(i, 0, 1), at(i + 1, 0, 1), at(i + 1, 0, 0));
    square(at(i, n, 0), at(i + 1, n, 0), at(i + 1, n, 1), at(i, n, 1));
    square(at(0, i, 0), at(0, i + 1, 0), at(0, i + 1, 1), at(0, i, 1));
    square(at(n, i, 0), at(n, i, 1), at(n, i + 1, 1), at(n, i + 1, 0));
  }
  return mesh;
}

/// Moves the tool along the course against the surface, 1 ms a step, and notes what that takes. `tell`: what physics
/// tells at a time.
template <class Tell>
void simulate(Course& course, double seconds, const BodyStates& start, const Tell& tell) {
  const NodeContext context = tactor::test::context_for(course.scene);
  SurfaceOptions unbounded = course.params;
  unbounded.most_work = std::numeric_limits<std::int32_t>::max();
  const std::unique_ptr<ContactSource> surface = surface_contacts(unbounded, context);
  RigidStep step(rollout_model("rollout_bench", course.params, context));
  BodyStates bodies = start;
  DeviceState before = course.handle(0);
  ContactSet set;
  StepResult last;
  double contacts = 0;
  const auto every = static_cast<int>(std::lround(1000 * result_period)), count = static_cast<int>(1000 * seconds);
  for (int ms = 0; ms <= count; ++ms) {
    if (ms % every == 0) course.results.push_back(tell(1e-3 * ms, bodies, last));
    surface->find(bodies, set);
    course.work.push_back(surface->work());
    contacts += set.count;
    const DeviceState device = course.handle(1e-3 * (ms + 1));
    last = step.advance(course.coupling, before, device, contact_planes(set), 1e-3, bodies);
    before = device;
  }
  course.contacts = contacts / (count + 1);
}

/// Way-points of a hand, met by Catmull and Rom's curve.
class WayPoints {
 public:
  explicit WayPoints(const std::filesystem::path& file) {
    std::ifstream in(file);
    std::string line;
    std::getline(in, line);
    while (std::getline(in, line)) {
      std::replace(line.begin(), line.end(), ',', ' ');
      std::istringstream numbers(line);
      std::array<double, 7> row{};
      for (double& x : row) numbers >> x;
      if (!numbers) throw InputError(file.string() + ": expected seven numbers a line");
      rows_.push_back(row);
    }
    if (rows_.size() < 4) throw InputError(file.string() + ": there are no way-points");
  }
  [[nodiscard]] double end() const { return rows_.back()[0]; }
  [[nodiscard]] DeviceState at(double t) const {
    constexpr double h = 1e-5;
    const Pose a = pose(t - h), b = pose(t + h);
    DeviceState state{pose(t), {}, 0};
    state.V_WD.v = (b.p - a.p) / (2 * h);
    state.V_WD.w = to_rotation_vector(b.R * inverse(a.R)) / (2 * h);
    return state;
  }

 private:
  [[nodiscard]] Pose pose(double t) const {
    const double step = rows_[1][0] - rows_[0][0];
    const double place = std::clamp((t - rows_[0][0]) / step, 1.0, static_cast<double>(rows_.size()) - 2.001);
    const auto i = static_cast<std::size_t>(place);
    const double s = place - static_cast<double>(i);
    std::array<double, 7> x{};
    for (std::size_t k = 1; k < 7; ++k) {
      const double a = rows_[i - 1][k], b = rows_[i][k], c = rows_[i + 1][k], d = rows_[i + 2][k];
      x[k] = b + 0.5 * s * (c - a + s * (2 * a - 5 * b + 4 * c - d + s * (3 * (b - c) + d - a)));
    }
    // The hand trembles.
    const double tremor = 5e-5 * std::sin(2 * std::numbers::pi * 10 * t);
    return {{x[1], x[2], x[3] + tremor}, from_rotation_vector({x[4], x[5], x[6]})};
  }
  std::vector<std::array<double, 7>> rows_;
};

}  // namespace

namespace {

/// The ring over a box of that width and its samples.
Course sliding_course(std::string name, double seconds, int contacts, double width, double spacing) {
  Course course;
  course.name = std::move(name);
  Body tool{.name = "tool", .shape = BoxShape{{width, width, 0.02}}};
  tool.motion = Motion::rigid;
  Body table{.name = "table", .shape = MeshShape{tactor::test::write_off(slab(), "slab")}};
  table.X_WB.p = {0, 0, -0.01 + pressed};
  course.scene.bodies = {tool, table};
  course.params = tactor::test::default_params<Rollout>();
  course.params.spacing = spacing;
  // Physics feels the ring, and the rollout the table.
  course.params.worse = 1e6;
  course.coupling = {.k_t = 500, .b_t = 14, .k_r = 1, .b_r = 0.01, .force_max = 8, .torque_max = 0.3};
  course.handle = sliding_handle;
  simulate(course, seconds, sliding_tool(0), [contacts](double t, const BodyStates&, const StepResult&) {
    const LocalContacts around = ring_at(t, contacts);
    return PhysicsResult{sliding_tool(t), around, felt_at(t, around)};
  });
  return course;
}

}  // namespace

Course ring_course(double seconds, int contacts) {
  return sliding_course("ring", seconds, contacts, 0.02, 0.0075);
}

Course dense_course(double seconds, int contacts, double spacing) {
  return sliding_course(fmt::format("{} mm", 1000 * spacing), seconds, contacts, 0.04, spacing);
}

Course bunny_course(double seconds, const std::filesystem::path& mesh, const std::filesystem::path& motion) {
  Course course;
  course.name = "two bunnies";
  const Material material{.stiffness = 2000, .damping = 2, .friction = 0.3, .patch_area = 4e-5};
  Body tool{.name = "tool", .shape = MeshShape{mesh}, .motion = Motion::rigid, .mass = 0.1, .material = material};
  Body fixed{.name = "bunny", .shape = MeshShape{mesh}, .material = material};
  course.scene.gravity_W = {};
  course.scene.bodies = {tool, fixed};
  course.params = tactor::test::default_params<Rollout>();
  course.params.margin = 0.001;
  course.coupling = {.k_t = 500, .b_t = 14, .k_r = 1, .b_r = 0.01, .force_max = 8, .torque_max = 0.3};
  const WayPoints hand(motion);
  if (seconds > hand.end()) throw InputError(motion.string() + ": the motion ends before the bench does");
  course.handle = [hand](double t) { return hand.at(t); };
  SceneContacts contacts(course.scene, {.margin = course.params.margin, .anchor_time = anchor_time},
                         cell_distances(course.params, nullptr));
  BodyStates start;
  start.count = 1;
  start.X_WB[0] = hand.at(0).X_WD;
  simulate(course, seconds, start, [&](double t, const BodyStates& bodies, const StepResult& last) {
    PhysicsResult result{bodies, {}, {}};
    contacts.find_ahead(bodies, result_period, result.around);
    const DeviceState handle = hand.at(t);
    result.state = {.X_WT = bodies.X_WB[0],
                    .V_WT = bodies.V_WB[0],
                    .X_WD = handle.X_WD,
                    .V_WD = handle.V_WD,
                    .contact_T_W = last.contact_T_W,
                    .contacts = last.touching,
                    .damped = last.outcome == StepOutcome::converged ? 0 : 1};
    return result;
  });
  return course;
}

}  // namespace tactor::bench
