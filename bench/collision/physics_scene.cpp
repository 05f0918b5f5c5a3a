#include <numbers>
#include <numeric>

#include "bench/collision/measure.hpp"
#include "bench/collision/path.hpp"
#include "bench/collision/physics_rig.hpp"
#include "bench/collision/quantile.hpp"
#include "bench/collision/scenes.hpp"
#include "bench/collision/timed_loop.hpp"
#include "framework/core/check.hpp"
#include "nodes/physics/mesh/mass_properties.hpp"
#include "nodes/physics/mesh/solid_file.hpp"
#include "tests/support/nodes.hpp"

namespace tactor::bench {

namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

double us_between(Clock::time_point a, Clock::time_point b) {
  return std::chrono::duration<double, std::micro>(b - a).count();
}

/// Of one value at least.
Json metrics(const std::vector<double>& values) {
  TACTOR_DEMAND(!values.empty());
  Json json = spread_of(values);
  json["mean"] = std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  return json;
}

SdfCollision::Params collision_params(double margin, int max_contacts) {
  auto params = test::default_params<SdfCollision>();
  params.margin = margin;
  params.max_contacts = max_contacts;
  return params;
}

SdfCollision make_collision(const Scene& scene, double margin, int max_contacts = ContactSet::capacity) {
  return {collision_params(margin, max_contacts), NodeContext{.name = "bench", .scene = &scene}};
}

/// Collision, dynamics and coupling in turns, as one thread of a live run steps them.
class Whole {
 public:
  Whole(const Scene& scene, double margin) : collision_(make_collision(scene, margin)), dynamics_(scene) {
    collision_.device.configure({});
    collision_.state.configure({});
    // As in a graph in which nobody reads it.
    collision_.local.set_wanted(false);
  }

  /// us, of the parts of a step and of all.
  struct Times {
    double collision, dynamics, coupling, all;
  };
  Times step(Time t, const DeviceState& device) {
    const auto begin = Clock::now();
    collision_.device.push({t, t, 0}, &device);
    collision_.contacts.clear_pending();
    StepContext context(t);
    collision_.step(context);
    const auto found = Clock::now();
    const PhysicsState& state = dynamics_.advance(t, device, contacts());
    collision_.state.push({t, t, 0}, &state);
    const auto moved = Clock::now();
    force_ = dynamics_.force();
    const auto end = Clock::now();
    return {us_between(begin, found), us_between(found, moved), us_between(moved, end), us_between(begin, end)};
  }

  [[nodiscard]] const ContactSet& contacts() const { return test::sent(collision_.contacts); }
  [[nodiscard]] const PhysicsState& state() const { return dynamics_.state(); }
  [[nodiscard]] const Wrench& force() const { return force_; }

 private:
  SdfCollision collision_;
  DynamicsRig dynamics_;
  Wrench force_;
};

/// What is inside collision.sdf's step, to time it apart.
class Parts {
 public:
  Parts(const Scene& scene, double margin)
      : make_(cell_distances(collision_params(margin, ContactSet::capacity), nullptr)),
        tool_(scene.bodies[1], 0, true, margin, make_, nullptr),
        fixed_(scene.bodies[0], 0, true, margin, make_, nullptr),
        pair_(tool_, fixed_, {}, 0, margin) {
    found_.reserve(most);
  }

  void query(const Pose& X_WT) {
    found_.clear();
    pair_.find(X_WT, {}, found_);
  }
  void reduce() { reduction_.reduce(found_, set_); }
  [[nodiscard]] std::size_t found() const { return found_.contact.size(); }
  [[nodiscard]] int sent() const { return set_.count; }

 private:
  static constexpr std::size_t most = 4096;
  MakeMeshDistance make_;
  ContactBody tool_, fixed_;
  BodyPair pair_;
  FoundContacts found_;
  ContactReduction reduction_{ContactSet::capacity, most};
  ContactSet set_;
};

/// The handle poses for which the springs alone would have the tool at the poses of the path.
std::vector<Pose> handle_path(const Scene& scene, const std::vector<Step>& steps, const Vec3& p_BT) {
  SdfCollision collision = make_collision(scene, 0);
  const CouplingParameters coupling = DynamicsRig(scene).coupling();
  std::vector<Pose> path;
  ContactSet set;
  for (const Step& step : steps) {
    const Pose X_WT{transform(step.X_AB, p_BT), step.X_AB.R};
    collision.query(X_WT, set);
    path.push_back(balancing_handle(coupling, X_WT, set));
  }
  return path;
}

Json whole_step(const Scene& scene, const std::vector<DeviceState>& handle, Duration period, double margin, bool cold) {
  Whole whole(scene, margin), swept(scene, margin);
  Parts parts(scene, margin);
  std::vector<double> all, collision, dynamics, coupling, query, reduction, cold_us;
  std::vector<double> found, sent, penetrating, touching, depth, force;
  std::size_t other = 0;
  const auto time_of = [&](std::size_t i) { return Time{static_cast<std::int64_t>(i) * period.ns}; };
  {
    TimedLoop loop;
    constexpr std::size_t block = 100;
    struct Queried {
      Pose X_WT;
      int sent;
    };
    std::vector<Queried> queried;
    for (std::size_t begin = 0; begin < handle.size(); begin += block) {
      queried.clear();
      for (std::size_t i = begin; i < std::min(begin + block, handle.size()); ++i) {
        const bool rested = loop.rest_if_due();
        const Whole::Times us = whole.step(time_of(i), handle[i]);
        const ContactSet& set = whole.contacts();
        queried.push_back({set.bodies.X_WB[0], set.count});
        // The first step puts the tool at the handle; the first of a block, or after a rest, finds what others left of
        // the caches.
        if (i == begin || rested) continue;
        all.push_back(us.all);
        collision.push_back(us.collision);
        dynamics.push_back(us.dynamics);
        coupling.push_back(us.coupling);
        sent.push_back(set.count);
        penetrating.push_back(set.penetrating);
        touching.push_back(whole.state().contacts);
        force.push_back(norm(whole.force().force));
        double deepest = 0;
        for (int k = 0; k < set.count; ++k) {
          deepest = std::max(deepest, -set.contact[static_cast<std::size_t>(k)].distance);
        }
        depth.push_back(1e3 * deepest);
      }
      for (std::size_t i = 0; i < queried.size(); ++i) {
        const bool rested = loop.rest_if_due();
        const double us_query = microseconds([&] { parts.query(queried[i].X_WT); });
        const double us_reduce = microseconds([&] { parts.reduce(); });
        other += parts.sent() != queried[i].sent;
        if (i == 0 || rested) continue;
        query.push_back(us_query);
        reduction.push_back(us_reduce);
        found.push_back(static_cast<double>(parts.found()));
      }
    }
    for (std::size_t i = 0; cold && i < handle.size(); ++i) {
      loop.rest_if_due();
      const bool sweep = i % 20 == 19;
      if (sweep) sweep_caches();
      const Whole::Times us = swept.step(time_of(i), handle[i]);
      if (sweep) cold_us.push_back(us.all);
    }
  }
  if (other > 0) throw RunError("the parts of collision found other contacts than the node");
  Json json = {{"margin_mm", 1e3 * margin},
               {"contacts",
                {{"found", metrics(found)},
                 {"sent", metrics(sent)},
                 {"penetrating", metrics(penetrating)},
                 {"with_force", metrics(touching)}}},
               {"deepest_mm", metrics(depth)},
               {"force_N", metrics(force)},
               {"us",
                {{"whole step", metrics(all)},
                 {"collision", metrics(collision)},
                 {"query", metrics(query)},
                 {"reduction", metrics(reduction)},
                 {"dynamics", metrics(dynamics)},
                 {"coupling", metrics(coupling)}}}};
  if (!cold_us.empty()) {
    json["cold_us"] = metrics(cold_us);
    json["cold_queries"] = cold_us.size();
  }
  return json;
}

/// The scene's tool on a handle that circles beside the place where `count` contacts balance it, all of them
/// penetrating.
struct Circling {
  Circling(const Scene& scene, int count) : dynamics(scene, Start::where_the_scene_says) {
    const Pose& X_WT = scene.tool()->X_WB;
    if (count > 0) make_collision(scene, 0, count).query(X_WT, set);
    if (set.penetrating != count) throw RunError("the pose has fewer contacts than are asked for");
    // The set says for which poses of the bodies it was found.
    set.bodies.count = 1;
    set.bodies.X_WB[0] = X_WT;
    middle = balancing_handle(dynamics.coupling(), X_WT, set);
    last = at(0);
  }

  [[nodiscard]] Pose at(int i) const {
    constexpr double radius = 0.001, turns = 3;  // m, 1/s
    const double angle = 2 * std::numbers::pi * turns * period * i;
    return {middle.p + radius * Vec3{std::cos(angle) - 1, std::sin(angle), 0}, middle.R};
  }

  void step(int i, bool counted) {
    const Pose now = at(i);
    const DeviceState device = device_at(now, last, period);
    last = now;
    const Time t{std::int64_t{i} * 1'000'000};
    const double us = microseconds([&] { dynamics.advance(t, device, set); });
    if (i > 0 && counted) times.push_back(us), touching.push_back(dynamics.state().contacts);
  }

  static constexpr double period = 0.001;  // s
  DynamicsRig dynamics;
  ContactSet set;
  Pose middle, last;
  std::vector<double> times, touching;
};

}  // namespace

Json physics_scene(const SceneOptions& options) {
  const std::filesystem::path file = options.meshes / "bunny.off";
  const Scene scene = two_of(file);
  const TriangleMesh mesh = load_solid(file).mesh;
  const Body bunny{mesh, vertex_samples(mesh).points};
  const Samples samples{0, press_and_slide_duration / options.samples, options.samples};
  const Vec3 p_BT = mass_properties(mesh).center;
  const std::vector<Pose> path = handle_path(scene, press_and_slide({bunny, bunny}, samples), p_BT);
  std::vector<DeviceState> handle;
  for (std::size_t i = 0; i < path.size(); ++i) {
    handle.push_back(device_at(path[i], path[i == 0 ? 0 : i - 1], samples.period));
  }
  Json rows = Json::array();
  const double by_default = test::default_params<SdfCollision>().margin;
  const Duration period{static_cast<std::int64_t>(std::llround(1e9 * samples.period))};
  for (const double margin : {by_default, 0.001}) {
    rows.push_back(whole_step(scene, handle, period, margin, options.cold));
  }
  return {{"samples", path.size()}, {"rate_hz", 1 / samples.period}, {"margins", rows}};
}

Json dynamics_scene(const SceneOptions& options) {
  const std::filesystem::path file = options.meshes / "bunny.off";
  const TriangleMesh mesh = load_solid(file).mesh;
  const Body bunny{mesh, vertex_samples(mesh).points};
  // The path is deepest there.
  const Step deep = press_and_slide({bunny, bunny}, {0.875, 0.001, 1}, 0.004).front();
  Scene scene = two_of(file);
  scene.bodies[1].X_WB = {transform(deep.X_AB, mass_properties(mesh).center), deep.X_AB.R};
  std::vector<std::unique_ptr<Circling>> all;
  constexpr int counts[] = {0, 20, 60, 128};
  for (const int count : counts) all.push_back(std::make_unique<Circling>(scene, count));
  {
    TimedLoop loop;
    constexpr int block = 100;
    for (int begin = 0; begin < options.samples; begin += block) {
      for (const auto& one : all) {
        for (int i = begin; i < std::min(begin + block, options.samples); ++i) one->step(i, !loop.rest_if_due());
      }
    }
  }
  Json rows = Json::array();
  for (std::size_t k = 0; k < all.size(); ++k) {
    rows.push_back(
        {{"contacts", counts[k]}, {"with_force", metrics(all[k]->touching)}, {"us", metrics(all[k]->times)}});
  }
  return {{"steps", options.samples}, {"contacts", rows}};
}

}  // namespace tactor::bench
