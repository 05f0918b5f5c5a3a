// The scenes: what touches what, and how the hand moves.
#include <algorithm>
#include <cmath>
#include <fstream>

#include "bench/stability/trial.hpp"
#include "nodes/collision/sdf.hpp"
#include "nodes/coupling/coupling_node.hpp"
#include "nodes/physics/mesh/body_mesh.hpp"

namespace tactor::bench {

namespace {

constexpr double margin = 0.002;     // m, the default of the collision nodes
constexpr double friction = 0.3;     // the default of Material
constexpr double period_max = 0.02;  // s, of the slowest physics

const std::vector<double> all_stiffness = {1e2, 1e3, 1e4, 1e5, 1e6};
const std::vector<double> all_mass = {1e-3, 1e-2, 1e-1, 1, 10};
const std::vector<double> all_rate = {50, 100, 500, 1000, 5000, 10000};
const std::vector<double> all_coupling = {1e2, 1e3, 1e4, 1e5};

/// s, in whole periods of the slowest physics.
double whole(double seconds) {
  return std::ceil(seconds / period_max - 1e-9) * period_max;
}

/// 1/s, how fast the slower root of m x'' + b x' + k x = 0 decays.
double decay(double m, double b, double k) {
  const double root = b * b - 4 * k * m;
  return root < 0 ? b / (2 * m) : 2 * k / (b + std::sqrt(root));
}

/// s, in which the exact motion dies down by e^20 both in the air and in contact, and 40 periods of slow physics.
double settling(const Cell& cell, double b_t) {
  const double k = cell.coupling_stiffness, m = cell.mass;
  const double rate = std::min(decay(m, b_t, k), decay(m, b_t + contact_damping, k + cell.contact_stiffness));
  return whole(20 / rate + 40 * period_max);
}

/// s, the stretch of a rest that is judged.
constexpr double judged = 0.4;

Contact contact_of(const Cell& cell, double weight) {
  return {.weight = weight, .stiffness = cell.contact_stiffness, .damping = contact_damping, .friction = friction};
}

void add(ContactSet& set, const Contact& contact, ContactPair pair = {}) {
  if (contact.distance < 0) ++set.penetrating;
  set.contact[static_cast<std::size_t>(set.count)] = contact;
  set.pair[static_cast<std::size_t>(set.count++)] = pair;
}

void clear(ContactSet& set) {
  set.count = set.penetrating = set.truncated = 0;
}

/// The points p_TC (m) of body `body` against a plane that faces up through p_WP; each for `weight` of its stiffness.
void touch_plane(const Cell& cell, const std::vector<Vec3>& points, const Pose& X_WT, double weight, ContactSet& set) {
  for (const Vec3& p : points) {
    const Vec3 p_W = transform(X_WT, p);
    if (p_W.z >= margin) continue;
    Contact c = contact_of(cell, weight);
    c.p_TC = p;
    c.p_WC = {p_W.x, p_W.y, 0};
    c.n_W = {0, 0, 1};
    c.distance = p_W.z;
    add(set, c);
  }
}

Body tool_of(const Cell& cell, Shape shape, Motion motion) {
  Body tool;
  tool.name = "tool";
  tool.shape = std::move(shape);
  tool.motion = motion;
  tool.mass = cell.mass;
  return tool;
}

/// Critically damped; the torsion swings as fast as the spring does.
CouplingParameters law_for(const Cell& cell, const Body& tool) {
  CouplingParameters coupling{.k_t = cell.coupling_stiffness, .force_max = 1e9, .torque_max = 1e9};
  coupling.b_t = damping_of(coupling.k_t, cell.mass, 1);
  if (tool.motion == Motion::rigid) {
    const double inertia = body_inertia(tool).trace() / 3;
    coupling.k_r = coupling.k_t * inertia / cell.mass;
    coupling.b_r = damping_of(coupling.k_r, inertia, 1);
  }
  return coupling;
}

/// A trial of one tool that starts slack in the hand at p.
Trial trial_of(const Cell& cell, Body tool, const Vec3& p) {
  tool.X_WB.p = p;
  Trial trial{.scene = {}, .coupling = law_for(cell, tool), .hand = HandPath(p), .query = {}, .rests = {}};
  trial.scene.bodies.push_back(std::move(tool));
  return trial;
}

/// A rest that ends where the hand's path ends now.
Rest rest_now(const Trial& trial, std::optional<Vec3> p_WT = {}) {
  return {.begin = trial.hand.end() - judged, .end = trial.hand.end(), .p_WT = p_WT};
}

/// m, the height at which coupling, gravity and a flat surface that meets the tool at `touching` hold the tool.
double balance(const Cell& cell, double gravity, double z_D, double touching) {
  const double k = cell.coupling_stiffness, c = cell.contact_stiffness;
  const double free = z_D - cell.mass * gravity / k;
  return free >= touching ? free : (k * free + c * touching) / (k + c);
}

/// m, where a tool rests on a slab that rests on the floor.
Vec3 stacked(const Cell& cell, double slab_mass, double z_D, double thickness, double radius) {
  const double k = cell.coupling_stiffness, c = cell.contact_stiffness, g = 9.81;
  const double free = z_D - cell.mass * g / k, slab_free = thickness - slab_mass * g / c;
  if (free >= slab_free + radius) return {0, 0, free};
  // Floor and slab are two equal springs in series for the tool; the slab's weight loads the lower one alone.
  const double series = c / 2;
  return {0, 0, (k * free + series * (slab_free + radius)) / (k + series)};
}

/// The tool, whose lowest point is `reach` (m) below its origin, is pressed `size`/4 deep by the hand, slid by half its
/// size, and lifted by its size.
void press_slide_lift(const Cell& cell, double reach, double size, Trial& trial) {
  const double gravity = -trial.scene.gravity_W.z, rest = settling(cell, trial.coupling.b_t);
  bool fallen = false;
  const Vec3 deep{0, 0, reach - 0.25 * size}, aside{0.5 * size, 0, deep.z}, up{aside.x, 0, reach + size};
  const auto at_rest = [&](const Vec3& hand) {
    trial.hand.stay(rest);
    Rest r = rest_now(trial, Vec3{0, 0, balance(cell, gravity, hand.z, reach)});
    // Friction holds it sideways, where and whether depends on how it got there.
    r.known = {0, 0, 1};
    r.tolerance = 0.05 * size + 0.1 * std::abs(r.p_WT->z - reach);
    // A box on too soft a surface falls over in truth: its load acts above the contact, whose corners hold it up.
    const double c = cell.contact_stiffness, load = c * std::max(0.0, reach - r.p_WT->z);
    fallen = fallen || (trial.scene.rotates() && load * reach > c * reach * reach + trial.coupling.k_r);
    if (fallen) r.p_WT.reset();
    trial.rests.push_back(r);
  };
  trial.hand.go(0.2, deep).stay(0.1).go(0.3, aside);
  at_rest(aside);
  trial.hand.go(0.2, up);
  at_rest(up);
}

std::vector<Vec3> corners(const Vec3& size) {
  std::vector<Vec3> points;
  for (int i = 0; i < 8; ++i) {
    points.push_back({(i & 1) != 0 ? size.x / 2 : -size.x / 2, (i & 2) != 0 ? size.y / 2 : -size.y / 2,
                      (i & 4) != 0 ? size.z / 2 : -size.z / 2});
  }
  return points;
}

/// The corners that a box stands on. The upper ones of a box that sinks in whole would double its stiffness.
std::vector<Vec3> lower_corners(const Vec3& size) {
  std::vector<Vec3> points = corners(size);
  std::erase_if(points, [](const Vec3& p) { return p.z > 0; });
  return points;
}

/// The query of a sphere (3 degrees of freedom) on the plane z = 0.
Query sphere_on_plane(const Cell& cell, double radius) {
  return [cell, radius](const BodyStates& bodies, ContactSet& set) {
    clear(set);
    const Pose& X_WT = bodies.X_WB[0];
    touch_plane(cell, {rotate(inverse(X_WT.R), {0, 0, -radius})}, X_WT, 1, set);
  };
}

TrialScene sphere_press() {
  return {
      "sphere_plane",
      "a ball of 20 mm, 3 degrees of freedom, pressed 5 mm deep onto a plane, slid and lifted",
      all_stiffness,
      all_mass,
      all_rate,
      all_coupling,
      [](const Cell& cell) {
        const double radius = 0.01;
        Trial trial = trial_of(cell, tool_of(cell, SphereShape{radius}, Motion::translation), {0, 0, radius + 0.002});
        trial.query = sphere_on_plane(cell, radius);
        press_slide_lift(cell, radius, 2 * radius, trial);
        return trial;
      }};
}

TrialScene box_press() {
  return {"box_plane",
          "a box of 20 mm, 6 degrees of freedom, pressed 5 mm deep flat onto a plane, slid and lifted",
          all_stiffness,
          all_mass,
          all_rate,
          all_coupling,
          [](const Cell& cell) {
            const double edge = 0.02;
            const Vec3 size{edge, edge, edge};
            Trial trial = trial_of(cell, tool_of(cell, BoxShape{size}, Motion::rigid), {0, 0, edge / 2 + 0.002});
            trial.lever = edge / 2;
            trial.query = [cell, points = lower_corners(size)](const BodyStates& bodies, ContactSet& set) {
              clear(set);
              touch_plane(cell, points, bodies.X_WB[0], 0.25, set);
            };
            press_slide_lift(cell, edge / 2, edge, trial);
            return trial;
          }};
}

TrialScene deep_start() {
  return {"deep_start",
          "a ball of 20 mm that begins with its top 10 mm below the surface; the hand lifts it out",
          all_stiffness,
          all_mass,
          all_rate,
          {1e3},
          [](const Cell& cell) {
            const double radius = 0.01;
            Trial trial = trial_of(cell, tool_of(cell, SphereShape{radius}, Motion::translation), {0, 0, -2 * radius});
            trial.query = sphere_on_plane(cell, radius);
            trial.hand.stay(0.2).go(0.2, {0, 0, 3 * radius}).stay(settling(cell, trial.coupling.b_t));
            Rest rest = rest_now(trial, Vec3{0, 0, balance(cell, 9.81, 3 * radius, radius)});
            rest.tolerance = 1e-3 + 0.1 * std::abs(rest.p_WT->z - radius);
            trial.rests.push_back(rest);
            return trial;
          }};
}

/// A slab without sides, 10 mm thick, on the plane z = 0, and a ball on the slab: both only translate.
/// The floor damps the slab critically, because nothing else does.
Query ball_on_slab(const Cell& cell, double radius, double thickness, double slab_mass) {
  return [cell, radius, thickness, slab_mass](const BodyStates& bodies, ContactSet& set) {
    clear(set);
    const Pose &X_WT = bodies.X_WB[0], &X_WS = bodies.X_WB[1];
    Contact c = contact_of(cell, 1);
    c.n_W = {0, 0, 1};
    c.p_TC = {0, 0, -radius};
    c.p_WC = {X_WT.p.x, X_WT.p.y, X_WS.p.z + thickness / 2};
    c.distance = X_WT.p.z - radius - c.p_WC.z;
    if (c.distance < margin) add(set, c, {.body = 0, .other = 1});
    c.damping = damping_of(cell.contact_stiffness, slab_mass, 1);
    c.p_TC = {0, 0, -thickness / 2};
    c.p_WC = {X_WS.p.x, X_WS.p.y, 0};
    c.distance = X_WS.p.z - thickness / 2;
    if (c.distance < margin) add(set, c, {.body = 1, .other = ContactPair::fixed});
  };
}

/// The tool has the cell's mass, the slab the other of 1 g and 10 kg.
TrialScene stack() {
  return {"mass_ratio",
          "a ball of 1 g on a slab of 10 kg, or of 10 kg on 1 g, pressed by 5 mm, slid and lifted",
          all_stiffness,
          {1e-3, 10},
          all_rate,
          {1e3},
          [](const Cell& cell) {
            const double radius = 0.01, thickness = 0.01;
            const double other = cell.mass < 0.1 ? 10 : 1e-3;
            Trial trial = trial_of(cell, tool_of(cell, SphereShape{radius}, Motion::translation),
                                   {0, 0, thickness + radius + 0.002});
            Body slab = tool_of(cell, BoxShape{{0.1, 0.1, thickness}}, Motion::translation);
            slab.name = "slab";
            slab.mass = other;
            slab.X_WB.p = {0, 0, thickness / 2};
            trial.scene.bodies.push_back(slab);
            trial.scene.tool_name = "tool";
            trial.query = ball_on_slab(cell, radius, thickness, other);
            const double slab_rate = std::sqrt(cell.contact_stiffness / other);
            const double rest = std::max(settling(cell, trial.coupling.b_t), whole(20 / slab_rate));
            const auto at_rest = [&](const Vec3& hand) {
              trial.hand.stay(rest);
              trial.rests.push_back(rest_now(trial, stacked(cell, other, hand.z, thickness, radius)));
              trial.rests.back().known = {0, 0, 1};
              trial.rests.back().tolerance = 1e-3 + 0.1 * std::abs(trial.rests.back().p_WT->z - thickness - radius);
            };
            const Vec3 deep{0, 0, thickness + radius - 0.005}, aside{0.01, 0, deep.z}, up{0.01, 0, deep.z + 0.025};
            trial.hand.go(0.2, deep).stay(0.1).go(0.3, aside);
            at_rest(aside);
            trial.hand.go(0.2, up);
            at_rest(up);
            return trial;
          }};
}

TrialScene weightless() {
  return {"no_gravity",
          "a ball that touches the plane exactly, no gravity: still, moved about, back again; it must not drift",
          all_stiffness,
          all_mass,
          all_rate,
          {1e3},
          [](const Cell& cell) {
            const double radius = 0.01;
            const Vec3 home{0, 0, radius};
            Trial trial = trial_of(cell, tool_of(cell, SphereShape{radius}, Motion::translation), home);
            trial.scene.gravity_W = {};
            trial.query = sphere_on_plane(cell, radius);
            const double settle = settling(cell, trial.coupling.b_t);
            trial.hand.stay(2);
            Rest still = rest_now(trial, home);
            still.tolerance = 1e-6;
            trial.hand.go(0.3, {0.02, 0.01, 0.03}).go(0.3, home).stay(settle);
            Rest back = rest_now(trial, home);
            back.tolerance = 1e-6;
            trial.rests = {still, back};
            return trial;
          }};
}

/// A ball and a plane of that size (m), all lengths in proportion.
TrialScene sized(const std::string& name, const std::string& title, double size) {
  return {name, title, {1e3, 1e5}, {1e-2, 1}, {50, 1000, 10000}, {1e3}, [size](const Cell& cell) {
            const double radius = size / 2;
            Trial trial =
                trial_of(cell, tool_of(cell, SphereShape{radius}, Motion::translation), {0, 0, radius + 0.1 * size});
            trial.peak_to_peak_max = std::min(1e-6, 1e-3 * size);
            trial.query = sphere_on_plane(cell, radius);
            press_slide_lift(cell, radius, size, trial);
            return trial;
          }};
}

/// A query by collision.sdf, one for each run: what a node chooses depends on what it was asked before. The stiffness
/// of the whole contact is spread by the weights of the node.
class MeshQuery {
 public:
  MeshQuery(Scene scene, double spacing) : scene_(std::move(scene)) {
    const NodeContext context{.name = "collision", .scene = &scene_, .torque = true};
    const NodeInfo info = SdfCollision::declare();
    std::vector<ParamValue> values;
    for (const ParamInfo& p : info.params) {
      values.push_back(p.name == "spacing" ? ParamValue(spacing) : p.default_value.value());
    }
    node_ = info.create(values, context);
  }
  void operator()(const Cell& cell, const BodyStates& bodies, ContactSet& set) const {
    static_cast<SdfCollision&>(*node_).query(bodies, set);
    for (std::size_t i = 0; i < static_cast<std::size_t>(set.count); ++i) {
      set.contact[i].stiffness = cell.contact_stiffness;
      set.contact[i].damping = contact_damping;
      set.contact[i].friction = friction;
    }
  }

 private:
  Scene scene_;
  std::unique_ptr<Node> node_;
};

Body mesh_body(const std::string& name, const std::filesystem::path& file, double scale, double patch_area) {
  Body body;
  body.name = name;
  body.shape = MeshShape{file, scale};
  body.material.patch_area = patch_area;
  return body;
}

/// Tool and obstacle of meshes.
struct MeshPair {
  Body obstacle, tool;
  double spacing = 0;  // m; the default of the node

  /// m, the height at which the tool, coming down along z from 1 m, touches.
  double touching(const Cell& cell) {
    const Trial probe = trial(cell, {});
    BodyStates bodies;
    ContactSet set;
    double apart = 1, inside = 0;
    while (apart - inside > 1e-6) {
      const double z = 0.5 * (apart + inside);
      bodies.X_WB[0].p = {0, 0, z};
      probe.query(bodies, set);
      (set.penetrating > 0 ? inside : apart) = z;
    }
    return apart;
  }

  Trial trial(const Cell& cell, const Vec3& p) {
    Body moving = tool;
    moving.motion = Motion::rigid;
    moving.mass = cell.mass;
    Scene scene;
    scene.bodies = {obstacle, moving};
    Trial trial = trial_of(cell, moving, p);
    trial.query = [query = std::make_shared<MeshQuery>(std::move(scene), spacing), cell](
                      const BodyStates& bodies, ContactSet& set) { (*query)(cell, bodies, set); };
    return trial;
  }
};

TrialScene box_on_box(const std::filesystem::path& scratch) {
  constexpr double edge = 0.04;  // m
  const std::filesystem::path file = scratch / "box.off";
  std::ofstream out(file);
  out << "OFF\n8 12 0\n";
  for (const Vec3& p : corners({edge, edge, edge})) out << p.x << ' ' << p.y << ' ' << p.z << '\n';
  out << "3 0 2 3\n3 0 3 1\n3 4 5 7\n3 4 7 6\n3 0 1 5\n3 0 5 4\n3 2 6 7\n3 2 7 3\n3 0 4 6\n3 0 6 2\n3 1 3 7\n3 1 7 5\n";
  if (!out.flush()) throw RunError(file.string() + ": cannot be written");
  auto pair = std::make_shared<MeshPair>();
  pair->obstacle = mesh_body("table", file, 1, edge * edge);
  pair->tool = mesh_body("tool", file, 1, edge * edge);
  pair->spacing = 0.02;
  return {"box_on_box",
          "a box of 40 mm set onto the same box, faces coincident and sides coplanar, pressed by 2 mm and lifted",
          {1e3, 1e5},
          {1e-2, 1},
          {50, 100, 1000},
          {1e3},
          [pair](const Cell& cell) {
            Trial trial = pair->trial(cell, {0, 0, edge});
            trial.lever = edge / 2;
            const double settle = settling(cell, trial.coupling.b_t);
            trial.hand.stay(0.1).go(0.2, {0, 0, edge - 0.002}).stay(settle);
            trial.rests.push_back(rest_now(trial));
            trial.hand.go(0.2, {0, 0, edge + 0.03}).stay(settle);
            Rest lifted = rest_now(trial, Vec3{0, 0, edge + 0.03 - cell.mass * 9.81 / cell.coupling_stiffness});
            trial.rests.push_back(lifted);
            return trial;
          }};
}

/// `spacing` in m: with 10 mm about 30 samples touch; with the node's default of 0 they fill the contact set several
/// times over.
TrialScene jammed_peg(const std::filesystem::path& meshes, const std::string& name, const std::string& touching,
                      double spacing) {
  auto pair = std::make_shared<MeshPair>();
  // The radii are 10 mm and 10.5 mm.
  pair->obstacle = mesh_body("plate", meshes / "plate.off", 1, 4e-4);
  pair->tool = mesh_body("tool", meshes / "peg.off", 1.05, 4e-4);
  pair->spacing = spacing;
  return {name,
          "a peg in a hole of the same 43 sides without clearance, " + touching +
              ", pushed 1 mm aside, turned by 2 degrees, and let go",
          {1e3, 1e5},
          {1e-2, 1},
          {50, 100, 1000},
          {1e3},
          [pair](const Cell& cell) {
            Trial trial = pair->trial(cell, {});
            trial.lever = 0.025;
            const double settle = settling(cell, trial.coupling.b_t);
            trial.hand.stay(0.1).go(0.2, {0.001, 0, 0}, {0, 0.035, 0}).stay(settle);
            trial.rests.push_back(rest_now(trial));
            trial.hand.go(0.2, {}).stay(settle);
            Rest back = rest_now(trial, Vec3{});
            back.known = {1, 1, 0};
            trial.rests.push_back(back);
            return trial;
          }};
}

TrialScene thrown_bunny(const std::filesystem::path& meshes) {
  auto pair = std::make_shared<MeshPair>();
  pair->obstacle = mesh_body("bunny", meshes / "bunny.off", 1, 1e-4);
  pair->tool = mesh_body("tool", meshes / "bunny.off", 1, 1e-4);
  return {"bunny_thrown",
          "a bunny of 20,990 faces thrown from above at 10 m/s onto the same bunny by a hand that stops 5 mm deep, and "
          "lifted",
          {1e3, 1e5},
          {1e-2, 1},
          {50, 100, 1000},
          {1e3},
          [pair](const Cell& cell) {
            const double touch = pair->touching(cell), start = touch + 0.5;
            Trial trial = pair->trial(cell, {0, 0, start});
            trial.lever = 0.05;
            const double settle = settling(cell, trial.coupling.b_t);
            trial.hand.strike(10, {0, 0, touch - 0.005}).stay(settle);
            trial.rests.push_back(rest_now(trial));
            trial.hand.go(0.3, {0, 0, start}).stay(settle);
            Rest lifted = rest_now(trial, Vec3{0, 0, start - cell.mass * 9.81 / cell.coupling_stiffness});
            trial.rests.push_back(lifted);
            return trial;
          }};
}

/// Runs by the steppers that the others vary alone, because it takes long.
TrialScene slow(TrialScene scene) {
  scene.contenders = {"tactor", "tactor_as_made", "ode", "ode_quick"};
  return scene;
}

}  // namespace

std::vector<Cell> TrialScene::cells() const {
  std::vector<Cell> cells;
  for (const double c : contact_stiffness) {
    for (const double m : mass) {
      for (const double r : rate) {
        for (const double k : coupling_stiffness) cells.push_back({c, m, r, k});
      }
    }
  }
  return cells;
}

std::vector<TrialScene> trial_scenes(const std::filesystem::path& meshes, const std::filesystem::path& scratch) {
  return {sphere_press(),
          box_press(),
          deep_start(),
          stack(),
          weightless(),
          sized("size_1e-4_m", "a ball of 0.1 mm pressed onto a plane, slid and lifted", 1e-4),
          sized("size_1e2_m", "a ball of 100 m pressed onto a plane, slid and lifted", 1e2),
          slow(box_on_box(scratch)),
          slow(jammed_peg(meshes, "peg_jammed", "touching at samples 10 mm apart", 0.01)),
          slow(jammed_peg(meshes, "peg_jammed_full", "touching all over, more contacts than the set holds", 0)),
          slow(thrown_bunny(meshes))};
}

}  // namespace tactor::bench
