#include "nodes/physics/engine/engine_node.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

#include "framework/core/value_error.hpp"
#include "nodes/physics/engine/mujoco_plugin.hpp"
#include "nodes/physics/mechanics/scene_model.hpp"

namespace tactor {

namespace {

/// Relative difference of the two masses, and of the two gravities in m/s^2, that counts as none.
constexpr double same_mass = 1e-3, same_gravity = 1e-3;

/// The same of their principal inertias, which a shape of the scene has only roughly.
constexpr double same_inertia = 0.05;

std::string kilograms(double mass) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6g kg", mass);
  return text.data();
}

std::string in_kg_m2(const Vec3& inertia) {
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), "[%.4g, %.4g, %.4g] kg m^2", inertia.x, inertia.y, inertia.z);
  return text.data();
}

void compare_inertias(const std::string& type, const Body& tool, const std::string& of_model,
                      const CoupledEngine& engine) {
  Scene alone;
  alone.bodies = {tool};
  const Eigen::Matrix3d inertia = scene_model(type, alone, nullptr).body[0].inertia_B;
  const Eigen::Vector3d scene = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertia).eigenvalues();
  const Vec3 unsorted = engine.tool_principal_inertia();
  std::array<double, 3> model{unsorted.x, unsorted.y, unsorted.z};
  std::sort(model.begin(), model.end());
  for (Eigen::Index i = 0; i < 3; ++i) {
    const double of_tool = model[static_cast<std::size_t>(i)];
    if (std::abs(scene[i] - of_tool) <= same_inertia * of_tool) continue;
    throw ValueError("scene.bodies." + tool.name + ".inertia",
                     type + ": " + of_model + " has the principal inertias " +
                         in_kg_m2({model[0], model[1], model[2]}) + ", and the scene's tool has " +
                         in_kg_m2({scene[0], scene[1], scene[2]}) +
                         "; the coupling is made for the latter, so give it the former as `inertia`");
  }
}

void compare_tools(const std::string& type, const Body& tool, const EngineParams& params, const CoupledEngine& engine) {
  const std::string of_model = "body '" + params.tool + "' of " + params.model.string();
  const std::string place = "scene.bodies." + tool.name;
  const bool rotates = tool.motion == Motion::rigid;
  if (rotates != engine.tool_rotates()) {
    throw ValueError(place + ".motion", type + ": " + of_model +
                                            (rotates ? " keeps its orientation; expected motion: translation"
                                                     : " has a free joint; expected motion: rigid"));
  }
  if (std::abs(tool.mass - engine.tool_mass()) > same_mass * engine.tool_mass()) {
    throw ValueError(place + ".mass", type + ": " + of_model + " has a mass of " + kilograms(engine.tool_mass()) +
                                          ", and the scene's tool has " + kilograms(tool.mass) +
                                          "; the coupling is made for the latter, so give it the former");
  }
  if (rotates) compare_inertias(type, tool, of_model, engine);
}

/// Without bodies of a scene beside the tool.
std::unique_ptr<CoupledEngine> engine_alone(const std::string& type, const EngineParams& params) {
  return load_mujoco_plugin(type).engine(
      {.file = params.model, .tool = params.tool, .keyframe = params.keyframe, .bodies = {}});
}

/// m, of a ball about the origin of the shape's body that holds the shape.
double reach_of(const OwnShape& shape) {
  struct Reach {
    double operator()(const SphereShape& s) const { return s.radius; }
    double operator()(const CapsuleShape& s) const { return s.radius + 0.5 * s.length; }
    double operator()(const BoxShape& s) const { return 0.5 * norm(s.size); }
    double operator()(const PlaneShape&) const { return 0; }
    double operator()(const CylinderShape& s) const { return std::hypot(s.radius, 0.5 * s.length); }
    double operator()(const EllipsoidShape& s) const { return std::max({s.radii.x, s.radii.y, s.radii.z}); }
    double operator()(const TrianglesShape& s) const {
      double most = 0;
      for (const Vec3& vertex : s.triangles->vertices) most = std::max(most, norm(vertex));
      return most;
    }
  };
  return norm(shape.X_BS.p) + std::visit(Reach{}, shape.form);
}

bool is_in_the_middle(const OwnShape& shape) {
  constexpr double same_place = 1e-9;
  return norm(shape.X_BS.p) <= same_place && norm(to_rotation_vector(shape.X_BS.R)) <= same_place;
}

}  // namespace

OwnScene model_scene(const std::string& type, const EngineParams& params) {
  return engine_alone(type, params)->own_scene();
}

OwnTool model_tool(const std::string& type, const EngineParams& params) {
  const auto engine = engine_alone(type, params);
  Body body;
  // Names of bodies in graphs are plainer than those of models.
  body.name = "tool";
  body.X_WB = engine->tool().X_WT;
  body.mass = engine->tool_mass();
  body.motion = engine->tool_rotates() ? Motion::rigid : Motion::translation;
  if (engine->tool_rotates()) body.inertia = engine->tool_principal_inertia();
  constexpr double least_radius = 1e-3;
  double radius = least_radius;
  std::optional<Shape> only;
  int shapes = 0;
  for (const OwnShape& shape : engine->own_scene().shapes) {
    if (shape.body != std::size_t{0}) continue;
    radius = std::max(radius, reach_of(shape));
    only = is_in_the_middle(shape) ? scene_shape(shape) : std::nullopt;
    ++shapes;
  }
  body.shape = shapes == 1 && only ? *only : SphereShape{radius};
  return {std::move(body), engine->gravity_W()};
}

std::unique_ptr<CoupledEngine> load_engine(const std::string& type, const EngineParams& params,
                                           const NodeContext& context, bool partial) {
  if (params.model.empty()) {
    throw ValueError("model", type + ": expected the model that physics.mujoco steps, found none");
  }
  const Scene& scene = *context.scene;
  const std::vector<std::size_t> moving = scene.moving();
  if (moving.empty()) throw InputError(type + " needs a moving body in the scene");
  refuse_deformable(scene, type + " moves", "dynamics.deformable");
  EngineModel model{
      .file = params.model, .tool = params.tool, .keyframe = params.keyframe, .bodies = {}, .partial = partial};
  for (std::size_t i = 1; i < moving.size(); ++i) model.bodies.push_back(scene.bodies[moving[i]].name);
  auto engine = load_mujoco_plugin(type).engine(model);
  const Vec3 g = engine->gravity_W();
  if (norm(g - scene.gravity_W) > same_gravity) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "[%.4g, %.4g, %.4g]", g.x, g.y, g.z);
    throw ValueError("scene.gravity", type + ": the gravity of " + params.model.string() + " is " + text.data() +
                                          " m/s^2, and the metrics count the energy with the scene's; expected "
                                          "gravity: " +
                                          text.data());
  }
  compare_tools(type, scene.bodies[moving.front()], params, *engine);
  return engine;
}

void note_untold(const EngineParams& params, const CoupledEngine& engine, const NodeContext& context) {
  const std::vector<std::string> untold = engine.untold_bodies();
  if (context.notes == nullptr || untold.empty()) return;
  std::string names;
  for (const std::string& name : untold) names += (names.empty() ? "" : ", ") + name;
  context.notes->push_back("of " + params.model.string() + " these bodies move and are not in the scene: " + names +
                           ". The messages `bodies` and `contacts` do not tell that they move, so prediction.local "
                           "takes them as fixed");
}

}  // namespace tactor
