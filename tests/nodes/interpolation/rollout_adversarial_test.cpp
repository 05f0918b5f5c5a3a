// interpolation.rollout and interpolation.direct on surfaces that nobody would draw, moved over at random, against the
// same physics in steps of a tenth of a tick; and models of absurd content.
#include <boost/test/unit_test.hpp>

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "framework/core/segment.hpp"
#include "framework/realtime/allocation_watch.hpp"
#include "nodes/interpolation/direct.hpp"
#include "nodes/interpolation/rollout.hpp"
#include "nodes/physics/mechanics/coupling_wrench.hpp"
#include "nodes/physics/mechanics/scene_model.hpp"
#include "nodes/physics/mesh/make_solid.hpp"
#include "nodes/prediction/local.hpp"
#include "tests/nodes/interpolation/rollout_subject.hpp"
#include "tests/support/dice.hpp"
#include "tests/support/nodes.hpp"
#include "tests/support/shapes.hpp"

BOOST_AUTO_TEST_SUITE(rollout_adversarial_test)

using namespace tactor;
using namespace tactor::test;

namespace {

constexpr int duration = 500;          // ms
constexpr int warm_up = 110;           // ms, until the first result has come and is shown; the heap may be called
constexpr int steps_a_tick = 10;       // of the reference
constexpr double field = 0.025;        // m, half the space that the surfaces fill
constexpr double anchor_time = 0.015;  // s
constexpr int resolution = 32;         // of cells

// ---- surfaces

void append(TriangleMesh& mesh, const TriangleMesh& part) {
  const auto first = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), part.vertices.begin(), part.vertices.end());
  for (const auto& f : part.faces) mesh.faces.push_back({f[0] + first, f[1] + first, f[2] + first});
}

/// A double pyramid from `low` to `high`, `thick` about its middle: along a needle its faces are thin triangles.
TriangleMesh spindle(const Vec3& low, const Vec3& high, double thick) {
  const Vec3 along = (high - low) / norm(high - low), middle = 0.5 * (low + high);
  const Vec3 side = cross(along, std::abs(along.x) < 0.9 ? Vec3{1, 0, 0} : Vec3{0, 1, 0});
  const Vec3 u = (thick / norm(side)) * side, v = cross(along, u);
  return {{low, high, middle + u, middle + v, middle - u, middle - v},
          {{1, 2, 3}, {1, 3, 4}, {1, 4, 5}, {1, 5, 2}, {0, 3, 2}, {0, 4, 3}, {0, 5, 4}, {0, 2, 5}}};
}

TriangleMesh tetrahedron(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const bool outward = dot(cross(b - a, c - a), d - a) < 0;
  return {{a, outward ? b : c, outward ? c : b, d}, {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}}};
}

/// A flat prism whose corners are at random angles, some of them microns apart: its sides are slivers.
TriangleMesh prism(Dice& dice, const Vec3& centre, double radius, double height) {
  constexpr int corners = 12;
  TriangleMesh mesh;
  std::array<double, corners> angle;
  for (int i = 0; i < corners; ++i) {
    const double even = 2 * std::numbers::pi * i / corners;
    angle[static_cast<std::size_t>(i)] =
        i % 3 == 2 ? angle[static_cast<std::size_t>(i - 1)] + dice(1e-4, 1e-3) : even + dice(0, 0.3);
  }
  for (int side = 0; side < 2; ++side) {
    for (const double a : angle) {
      mesh.vertices.push_back(centre + Vec3{radius * std::cos(a), radius * std::sin(a), (side - 0.5) * height});
    }
  }
  for (int i = 0; i < corners; ++i) {
    const int j = (i + 1) % corners;
    mesh.faces.push_back({i, j, j + corners});
    mesh.faces.push_back({i, j + corners, i + corners});
    if (i == 0 || j == 0) continue;
    mesh.faces.push_back({0, j, i});
    mesh.faces.push_back({corners, i + corners, j + corners});
  }
  return mesh;
}

/// The middles of `n` x `n` x `layers` cells in the field, and how long the cells are.
template <class Part>
TriangleMesh in_cells(int n, int layers, const Part& part) {
  TriangleMesh mesh;
  const double a = 2 * field / n, height = 2 * field / layers;
  for (int i = 0; i < n * n * layers; ++i) {
    append(mesh, part(Vec3{a * (i % n - 0.5 * (n - 1)), a * (i / n % n - 0.5 * (n - 1)),
                           height * (i / n / n - 0.5 * (layers - 1))}));
  }
  return mesh;
}

enum class Kind { needles, slivers, soup, self_cut };

const char* name_of(Kind kind) {
  constexpr std::array<const char*, 4> names{"needles", "slivers", "soup", "soup that cuts itself"};
  return names[static_cast<std::size_t>(kind)];
}

/// One mesh of many parts. They do not meet, because what cuts itself is refused where the plugin checks meshes; where
/// it is not installed, nothing is refused, and `self_cut` is taken as it is.
TriangleMesh surface(Kind kind, Dice& dice) {
  switch (kind) {
    case Kind::needles:
      // 4 cm long, some tenths of a millimetre thick, as steep as the cells let them be.
      return in_cells(6, 1, [&](const Vec3& c) {
        const auto tip = [&](double z) { return c + Vec3{dice(-0.0035, 0.0035), dice(-0.0035, 0.0035), z}; };
        return spindle(tip(dice(-0.022, -0.018)), tip(dice(0.018, 0.022)), std::pow(10, dice(-4.3, -3.4)));
      });
    case Kind::slivers: {
      // Tetrahedra and prisms, 1 cm wide, of 1 to 300 um.
      int number = 0;
      return in_cells(4, 6, [&](const Vec3& c) {
        const double thick = std::pow(10, dice(-6, -3.5));
        if (++number % 2 == 0) return prism(dice, c, 0.005, thick);
        const Quat turn = from_rotation_vector(dice.in_cube(0.3));
        const auto corner = [&](double x, double y) {
          return c + rotate(turn, {x + dice(-0.002, 0.002), y + dice(-0.002, 0.002), dice(-thick, thick)});
        };
        return tetrahedron(corner(-0.004, -0.003), corner(0.004, -0.003), corner(0.004, 0.003), corner(-0.004, 0.003));
      });
    }
    case Kind::soup:
      return in_cells(4, 4, [&](const Vec3& c) {
        const auto corner = [&] { return c + dice.in_cube(0.006); };
        return tetrahedron(corner(), corner(), corner(), corner());
      });
    case Kind::self_cut:
      break;
  }
  TriangleMesh mesh;
  for (int i = 0; i < 60; ++i) {
    const Vec3 c = dice.in_cube(field);
    const auto corner = [&] { return c + dice.in_cube(0.01); };
    append(mesh, tetrahedron(corner(), corner(), corner(), corner()));
  }
  return mesh;
}

enum class Tool { ball, box, star };

/// A ball whose corners stand out or in: a tool of spikes and dents.
TriangleMesh star() {
  TriangleMesh mesh = icosphere(0.006, 1);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) mesh.vertices[i] *= i % 3 == 0 ? 1.6 : 0.8;
  return mesh;
}

struct Case {
  Kind kind;
  Tool tool;
  int seed;
  friend std::ostream& operator<<(std::ostream& out, const Case& c) {
    constexpr std::array<const char*, 3> tools{"ball", "box", "star"};
    return out << name_of(c.kind) << ", " << tools[static_cast<std::size_t>(c.tool)] << ", seed " << c.seed;
  }
};

/// Three bodies of such parts that stand in each other, and the tool above them.
Scene scene_of(const Case& c, Dice& dice) {
  Scene scene;
  scene.gravity_W = {};
  Body tool;
  tool.name = "tool";
  tool.motion = c.tool == Tool::ball ? Motion::translation : Motion::rigid;
  if (c.tool == Tool::ball) tool.shape = SphereShape{0.005};
  if (c.tool == Tool::box) tool.shape = BoxShape{{0.016, 0.012, 0.008}};
  if (c.tool == Tool::star) tool.shape = MeshShape{write_off(star(), "star")};
  tool.mass = 0.1;
  // As of a tool with a grip, so that the spring turns it as fast as it moves it.
  tool.inertia = Vec3{2e-5, 2e-5, 2e-5};
  scene.bodies.push_back(tool);
  for (int i = 0; i < 3; ++i) {
    Body body;
    body.name = std::string(1, static_cast<char>('a' + i));
    body.shape = MeshShape{write_off(surface(c.kind, dice), "surface_" + body.name)};
    body.X_WB = dice.pose(0.004, i == 0 ? 0.1 : 1.5);
    scene.bodies.push_back(body);
  }
  return scene;
}

// ---- the hand

/// Dives from above into the field and through it, up to 0.5 m/s, with a tremor of 0.1 mm at 9 Hz.
class Hand {
 public:
  Hand(Dice& dice, bool turns) : turns_(turns) {
    for (Wave& w : waves_) {
      w = {dice.in_cube(field), dice.in_cube(1.5), dice(0.5, 2.5), dice(0, 2 * std::numbers::pi)};
    }
    double fastest = 0;
    for (int ms = 0; ms <= duration; ++ms) fastest = std::max(fastest, norm(at(1e-3 * ms).V_WD.v));
    pace_ = 0.5 / fastest;
  }
  [[nodiscard]] DeviceState at(double t) const {
    constexpr double h = 1e-6;
    DeviceState state{pose(t), {}, 0};
    state.V_WD.v = (pose(t + h).p - pose(t - h).p) / (2 * h);
    if (turns_) state.V_WD.w = to_rotation_vector(pose(t + h).R * inverse(pose(t - h).R)) / (2 * h);
    return state;
  }

 private:
  struct Wave {
    Vec3 way, turn;  // m, rad
    double hz, phase;
  };
  [[nodiscard]] Pose pose(double t) const {
    const double u = pace_ * t, into = 1 / (1 + std::exp(-(u - 0.15) / 0.03));
    Vec3 p, r;
    for (const Wave& w : waves_) {
      const double s = std::sin(2 * std::numbers::pi * w.hz * u + w.phase);
      p += s * w.way;
      r += s * w.turn;
    }
    p = into * p + Vec3{0, 0, (1 - into) * 2 * field} + Vec3{1e-4 * std::sin(2 * std::numbers::pi * 9 * t), 0, 0};
    return {p, turns_ ? from_rotation_vector(r) : Quat{}};
  }
  bool turns_;
  double pace_ = 1;
  std::array<Wave, 4> waves_;
};

// ---- physics

SystemModel model_of(const Scene& scene) {
  return scene_model("test", scene, nullptr);
}

/// The bodies of a scene on the spring, from where the hand is at 0.
class Bodies {
 public:
  Bodies(const Scene& scene, const Hand& hand)
      : hand_(hand),
        torque_(scene.rotates()),
        contacts_(scene, {.margin = 0.002, .anchor_time = anchor_time},
                  cell_distances({.resolution = resolution}, nullptr)),
        step_(model_of(scene)) {
    device_ = hand.at(0);
    bodies_.count = 1;
    bodies_.X_WB[0] = device_.X_WD;
    bodies_.V_WB[0] = device_.V_WD;
  }
  void look() { contacts_.find(bodies_, set_); }
  void look_ahead(double age, LocalContacts& around) { contacts_.find_ahead(bodies_, age, around); }
  /// To `t`, against the contacts of the last look.
  void advance(double t) {
    const DeviceState device = hand_.at(t);
    last_ = step_.advance(spring, device_, device, contact_planes(set_), t - t_, bodies_);
    device_ = device;
    t_ = t;
  }
  [[nodiscard]] PhysicsState state() const {
    return {.X_WT = bodies_.X_WB[0],
            .V_WT = bodies_.V_WB[0],
            .X_WD = device_.X_WD,
            .V_WD = device_.V_WD,
            .contact_T_W = last_.contact_T_W,
            .contacts = last_.touching,
            .damped = last_.outcome == StepOutcome::converged ? 0 : 1};
  }
  [[nodiscard]] const BodyStates& bodies() const { return bodies_; }
  [[nodiscard]] const ContactSet& contacts() const { return set_; }
  /// On the device.
  [[nodiscard]] Wrench wrench() const { return coupling_wrench(spring, state(), torque_); }

 private:
  const Hand& hand_;
  bool torque_;
  SceneContacts contacts_;
  RigidStep step_;
  BodyStates bodies_;
  DeviceState device_;
  double t_ = 0;
  ContactSet set_;
  StepResult last_{.outcome = StepOutcome::converged};
};

/// The largest changes of a wrench that is looked at each tick.
struct Steps {
  double force = 0, torque = 0;  // N, N m, in one tick
  void take(const Wrench& w) {
    if (taken_ > 0) {
      force = std::max(force, norm(w.force - last_.force));
      torque = std::max(torque, norm(w.torque - last_.torque));
    }
    ++taken_;
    last_ = w;
  }

 private:
  Wrench last_;
  int taken_ = 0;
};

Steps of_reference(const Scene& scene, const Hand& hand) {
  Bodies bodies(scene, hand);
  Steps steps;
  for (int ms = 0; ms <= duration; ++ms) {
    for (int k = 1; k <= steps_a_tick; ++k) {
      bodies.look();
      bodies.advance(1e-3 * (ms + static_cast<double>(k) / steps_a_tick));
    }
    steps.take(bodies.wrench());
  }
  return steps;
}

// ---- the nodes

/// What a node displays, and what is promised of it.
class Display {
 public:
  explicit Display(std::string name) : name_(std::move(name)) {}
  template <class N>
  void tick(N& node, int ms) {
    StepContext context(at_ms(ms));
    const std::int64_t before = thread_heap_calls();
    node.step(context);
    if (ms > warm_up) calls += thread_heap_calls() - before;
    if (node.segment.pending() > 0) shown_ = sent(node.segment);
    node.segment.clear_pending();
    // Between the ends of a tick, which are within the limits, a cubic swings a little beyond them.
    for (const double later : {0.0, 0.4, 1.0}) {
      const Wrench w = evaluate(shown_, at_ms(ms + later));
      BOOST_REQUIRE_MESSAGE(is_finite(w), name_ << " at " << ms << " ms");
      const double share = later == 0.4 ? 1.01 : 1 + 1e-9;
      BOOST_REQUIRE_MESSAGE(norm(w.force) <= share * spring.force_max,
                            name_ << " at " << ms << " ms: " << norm(w.force));
      BOOST_REQUIRE_MESSAGE(norm(w.torque) <= share * spring.torque_max,
                            name_ << " at " << ms << " ms: " << norm(w.torque));
    }
    // The safety gate lets the first force in little by little.
    if (ms > warm_up) steps.take(evaluate(shown_, at_ms(ms + 1)));
  }
  [[nodiscard]] const std::string& name() const { return name_; }
  Steps steps;
  std::int64_t calls = 0;  // of the heap

 private:
  std::string name_;
  ForceSegment shown_;
};

template <class T>
void push(Input<T>& input, int valid_ms, int ms, std::uint64_t number, const T& message) {
  input.push({at_ms(valid_ms), at_ms(ms), number}, &message);
}

/// `judged`: the rollout as it comes; `rollout`: where it is displayed whatever physics feels.
struct Displays {
  Display judged{"rollout, or a hold"}, rollout{"rollout"}, direct{"direct"};
};

/// Physics of one look in `period` ms, whose results come a period late, as it runs beside the device.
void run(const Scene& scene, const Hand& hand, int period, Displays& shown) {
  const NodeContext context = context_for(scene);
  LocalPredictor local(default_params<LocalPredictor>(), context);
  auto rollout_params = default_params<Rollout>();
  auto direct_params = default_params<Direct>();
  // What is found does not depend on it, and coarse cells are sooner made.
  rollout_params.resolution = direct_params.resolution = resolution;
  Rollout judged(rollout_params, context);
  rollout_params.worse = 1e6;
  Rollout rollout(rollout_params, context);
  Direct stepped(direct_params, context);
  local.bodies.configure({});
  local.contacts.configure({});
  local.used.configure({QueuePolicy::drop_oldest, 8});
  local.state.configure({});
  local.coupling.configure({});
  local.device.configure({QueuePolicy::drop_oldest, 512});
  for (Rollout* node : {&judged, &rollout}) {
    node->model.configure({});
    node->device.configure({QueuePolicy::drop_oldest, 64});
  }
  stepped.device.configure({QueuePolicy::drop_oldest, 64});
  stepped.coupling.configure({});
  stepped.bodies.configure({});
  stepped.otherwise.configure({});
  push(local.coupling, 0, 0, 0, spring);
  push(stepped.coupling, 0, 0, 0, spring);

  Bodies physics(scene, hand);
  LocalContacts around;
  std::uint64_t results = 0;
  for (int ms = 0; ms <= duration; ++ms) {
    const DeviceState sample = hand.at(1e-3 * ms);
    const auto number = static_cast<std::uint64_t>(ms);
    push(local.device, ms, ms, number, sample);
    for (Rollout* node : {&judged, &rollout}) push(node->device, ms, ms, number, sample);
    push(stepped.device, ms, ms, number, sample);
    if (ms > 0 && ms % period == 0) {
      const int stamp = ms - period;
      physics.look();
      push(local.used, stamp, ms, results, physics.contacts());
      for (int k = std::max(1, stamp - period + 1); k <= stamp; ++k) physics.advance(1e-3 * k);
      physics.look_ahead(1e-3 * period, around);
      push(local.contacts, stamp, ms, results, around);
      push(local.state, stamp, ms, results, physics.state());
      push(local.bodies, stamp, ms, results, physics.bodies());
      push(stepped.bodies, stamp, ms, results, physics.bodies());
      push(stepped.otherwise, stamp, ms, results, constant_segment(at_ms(ms), physics.wrench()));
      StepContext now(at_ms(ms));
      local.step(now);
      if (local.model.pending() > 0) {
        for (Rollout* node : {&judged, &rollout}) push(node->model, stamp, ms, results, sent(local.model));
      }
      local.model.clear_pending();
      ++results;
    }
    shown.judged.tick(judged, ms);
    shown.rollout.tick(rollout, ms);
    shown.direct.tick(stepped, ms);
  }
  BOOST_TEST(metrics_of(rollout).at("rollout.ticks") > 0);
  BOOST_TEST(metrics_of(stepped).at("direct.ticks") > 0);
}

/// A tick learns of a new rate one tick late. Until then it goes on with the old rate. Then it catches up in part
/// (CarriedForce).
void check(const Case& c) {
  BOOST_TEST_CONTEXT(c) {
    Dice dice(static_cast<std::uint64_t>(c.seed));
    const Scene scene = scene_of(c, dice);
    const Hand hand(dice, scene.rotates());
    const Steps reference = of_reference(scene, hand);
    Displays shown;
    run(scene, hand, 20 + 15 * (c.seed % 3), shown);
    // The tool has met something.
    BOOST_TEST(reference.force > 0.01);
    const auto share = [](double part, double whole) { return whole > 0 ? part / whole : 0; };
    for (const Display* display : {&shown.judged, &shown.rollout, &shown.direct}) {
      const Steps& steps = display->steps;
      BOOST_TEST_MESSAGE(c << ": " << display->name() << " steps by " << share(steps.force, reference.force) << " and "
                           << share(steps.torque, reference.torque) << " of what the reference does");
      BOOST_TEST(steps.force <= 2 * reference.force, display->name());
      BOOST_TEST(steps.torque <= 2 * reference.torque, display->name());
    }
    for (const Display* display : {&shown.judged, &shown.rollout, &shown.direct}) {
      BOOST_TEST(display->calls == 0, display->name());
    }
  }
}

}  // namespace

BOOST_AUTO_TEST_CASE(on_adversarial_surfaces_the_force_is_finite_limited_and_steps_little_more_than_fine_physics) {
  for (const Kind kind : {Kind::needles, Kind::slivers, Kind::soup, Kind::self_cut}) {
    if (kind == Kind::self_cut && repairs_meshes()) continue;
    for (const Tool tool : {Tool::ball, Tool::box, Tool::star}) {
      for (int seed = 1; seed <= 4; ++seed) check({kind, tool, seed});
    }
  }
}

namespace {

using Spoil = std::function<void(LocalModel&)>;

/// Models with one number that no sender would write.
std::vector<std::pair<std::string, Spoil>> spoiled() {
  constexpr double inf = std::numeric_limits<double>::infinity();
  constexpr std::int32_t most = std::numeric_limits<std::int32_t>::max();
  std::vector<std::pair<std::string, Spoil>> list;
  const auto number = [&](const std::string& name, auto place) {
    for (const double value : {std::nan(""), inf, -inf, 1e300, -1e300}) {
      list.emplace_back(name + " " + std::to_string(value), [=](LocalModel& m) { place(m) = value; });
    }
  };
  const auto count = [&](const std::string& name, std::vector<std::int32_t> values, auto place) {
    for (const std::int32_t value : values) {
      list.emplace_back(name + " " + std::to_string(value), [=](LocalModel& m) { place(m) = value; });
    }
  };
  number("place", [](LocalModel& m) -> double& { return m.bodies.X_WB[0].p.y; });
  number("rotation", [](LocalModel& m) -> double& { return m.bodies.X_WB[0].R.x; });
  number("velocity", [](LocalModel& m) -> double& { return m.bodies.V_WB[0].v.x; });
  number("handle", [](LocalModel& m) -> double& { return m.device.X_WD.p.x; });
  number("handle's velocity", [](LocalModel& m) -> double& { return m.device.V_WD.v.x; });
  number("place in the result", [](LocalModel& m) -> double& { return m.p_WT_result.x; });
  number("force in the result", [](LocalModel& m) -> double& { return m.wrench_result.force.x; });
  number("torque in the result", [](LocalModel& m) -> double& { return m.wrench_result.torque.x; });
  number("stiffness of the spring", [](LocalModel& m) -> double& { return m.coupling.k_t; });
  number("damping of the spring", [](LocalModel& m) -> double& { return m.coupling.b_t; });
  number("scale of all", [](LocalModel& m) -> double& { return m.correction.scale_all; });
  number("scale of friction", [](LocalModel& m) -> double& { return m.correction.friction_scale_all; });
  number("scale", [](LocalModel& m) -> double& { return m.correction.stiffness_scale; });
  number("excess", [](LocalModel& m) -> double& { return m.correction.friction_excess; });
  number("material", [](LocalModel& m) -> double& { return m.correction.material[0].stiffness; });
  number("contact's distance", [](LocalModel& m) -> double& { return m.contacts.contact[0][0].distance; });
  number("contact's weight", [](LocalModel& m) -> double& { return m.contacts.contact[0][0].weight; });
  number("contact's inertia", [](LocalModel& m) -> double& { return m.contacts.contact[0][0].inertia; });
  number("contact's creep", [](LocalModel& m) -> double& { return m.contacts.contact[0][0].creep; });
  number("contact's lift", [](LocalModel& m) -> double& { return m.contacts.contact[0][0].lift; });
  number("contact's normal", [](LocalModel& m) -> double& { return m.contacts.contact[0][0].n_W.x; });
  number("contact's curvature", [](LocalModel& m) -> double& { return m.contacts.contact[0][0].H_W[0]; });
  number("anchor", [](LocalModel& m) -> double& { return m.contacts.X_WB[0][0].p.x; });
  count("bodies", {-1, 0, 2, most}, [](LocalModel& m) -> std::int32_t& { return m.bodies.count; });
  count("contacts", {-1, LocalContacts::capacity + 1, most},
        [](LocalModel& m) -> std::int32_t& { return m.contacts.count; });
  count("bodies of contacts", {-1, 0, 2, most}, [](LocalModel& m) -> std::int32_t& { return m.contacts.bodies; });
  count("anchors", {-1, 0, LocalContacts::max_anchors + 1, most},
        [](LocalModel& m) -> std::int32_t& { return m.contacts.anchors; });
  count("body of a contact", {-1, 1, most}, [](LocalModel& m) -> std::int32_t& { return m.contacts.pair[0].body; });
  count("other of a contact", {-2, 1, most}, [](LocalModel& m) -> std::int32_t& { return m.contacts.pair[0].other; });
  count("materials", {-1, ContactCorrection::most_materials + 1, most},
        [](LocalModel& m) -> std::int32_t& { return m.correction.count; });
  return list;
}

/// A ball on a box, whose contacts are found anew.
Scene ball_on_box() {
  Scene scene = ball_scene(0.1);
  Body box;
  box.name = "box";
  box.shape = BoxShape{{0.1, 0.1, 0.1}};
  box.X_WB.p = {-0.05, 0, 0};
  scene.bodies.push_back(box);
  return scene;
}

}  // namespace

BOOST_AUTO_TEST_CASE(models_of_absurd_content_do_no_harm_and_leave_nothing_behind) {
  auto anchors_always = default_params<Rollout>();
  anchors_always.contacts = SurfaceOptions::From::anchors;
  anchors_always.restart = Rollout::Params::Restart::always;
  const LocalContacts wall = wall_around({{0.009, 0, 0}});
  for (const Rollout::Params& params : {default_params<Rollout>(), anchors_always}) {
    for (const auto& [name, spoil] : spoiled()) {
      BOOST_TEST_CONTEXT(name) {
        Subject troubled(ball_on_box(), params), calm(ball_on_box(), params);
        for (int ms = 0; ms <= 400; ++ms) {
          const DeviceState handle{
              {{0.0085 + 0.0005 * std::sin(0.02 * ms), 0, 0}, {}}, {{0.01 * std::cos(0.02 * ms), 0, 0}, {}}, 0};
          for (Subject* subject : {&troubled, &calm}) subject->sample(ms, handle);
          if (ms % 10 == 0) {
            LocalModel model = model_at(ms, one_body({0.0092, 0, 0}), handle.X_WD.p, wall, handle.V_WD.v);
            model.wrench_result.force = {spring.k_t * (0.0092 - handle.X_WD.p.x), 0, 0};
            calm.model(ms - 10, ms, model);
            // The first one too.
            if (ms < 100 && ms % 30 == 0) spoil(model);
            troubled.model(ms - 10, ms, model);
          }
          calm.tick(ms);
          if (!troubled.tick(ms)) continue;
          for (const double later : {0.0, 0.4, 1.0}) {
            const Vec3 force = troubled.force(ms + later);
            BOOST_REQUIRE_MESSAGE(is_finite(force), ms << " ms");
            BOOST_REQUIRE_MESSAGE(norm(force) <= 1.01 * spring.force_max, ms << " ms: " << norm(force));
          }
        }
        BOOST_TEST(norm(troubled.force(401) - calm.force(401)) < 1e-4);
      }
    }
  }
}

BOOST_AUTO_TEST_SUITE_END()
