// A ball and elastic boxes of a few tetrahedra, stepped together, and what tests ask of them.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "nodes/physics/deformable/deformable_step.hpp"
#include "nodes/physics/geometry/mesh_distance.hpp"
#include "nodes/physics/mechanics/eigen.hpp"
#include "nodes/physics/mechanics/scene_model.hpp"
#include "tests/nodes/physics/deformable/boxes.hpp"

namespace tactor::test {

/// What a rig is made of, but for the scene.
struct RigOptions {
  Elasticity law = Elasticity::corotational;
  ElementOrder order = ElementOrder::linear;
  Integrator integrator = Integrator::implicit_euler;
  int iterations = 30;
  double tolerance = 1e-10;
  bool reuse = false;
  int patch_nodes = 24, far_nodes = 0;
  double patch_reach = 0.04;              // m
  FactorKind factor = FactorKind::eigen;  // the same numbers everywhere
  double stick_velocity = 1e-4;           // m/s
  double margin = 0.002, spacing = 0;     // m, of contacts
  [[nodiscard]] DeformableOptions deformable() const {
    return {.law = law,
            .elements = order,
            .solver = factor,
            .newton_iterations = iterations,
            .tolerance = tolerance,
            .reuse_factors = reuse,
            .patch_nodes = patch_nodes,
            .patch_far_nodes = far_nodes,
            .patch_reach = patch_reach};
  }
};

/// A box of `size` about `middle`, of cells of about `edge` (m).
inline Body gel_box(const std::string& name, const Vec3& size, const Vec3& middle, double young, double edge) {
  Body gel;
  gel.name = name;
  gel.shape = BoxShape{size};
  gel.X_WB.p = middle;
  gel.motion = Motion::deformable;
  gel.material = {.stiffness = 2000, .damping = 0, .friction = 0, .patch_area = 1e-4};
  gel.deformable.young = young;
  gel.deformable.poisson = 0.4;
  gel.deformable.damping = 0;
  gel.deformable.cell_size = edge;
  return gel;
}
/// Holds what is below the middle of a box less half its height.
inline void hold_bottom(Body& gel) {
  gel.deformable.fixed = {HalfSpaceRegion{{0, 0, -0.5 * std::get<BoxShape>(gel.shape).size.z}, {0, 0, 1}}};
}

inline Body ball_tool(double radius, const Vec3& p, double mass, Motion motion = Motion::translation) {
  Body tool;
  tool.name = "tool";
  tool.shape = SphereShape{radius};
  tool.X_WB.p = p;
  tool.motion = motion;
  tool.mass = mass;
  tool.material = {.stiffness = 20000, .damping = 0, .friction = 0, .patch_area = 1e-4};
  return tool;
}
/// A ball that touches nothing.
inline Body far_tool() {
  return ball_tool(0.008, {0, 0, 1000}, 0.05);
}

inline SystemModel rig_model(const Scene& scene, const RigOptions& options) {
  SystemModel model = scene_model("test", scene, nullptr);
  model.integrator = options.integrator;
  model.tolerance = 1e-12;
  model.stick_velocity = options.stick_velocity;
  return model;
}

class SoftRig {
 public:
  explicit SoftRig(Scene s, const RigOptions& options = {})
      : scene(std::move(s)),
        soft(soft_scene(scene, options.deformable(), nullptr)),
        tool_(*scene.tool(), 0, false, options.patch_reach, cell_distances({}, nullptr), nullptr),
        contacts_(scene, {.soft_margin = options.margin, .soft_spacing = options.spacing},
                  cell_distances({}, nullptr)) {
    std::vector<Vec3> rest;
    for (int i = 0; i < model().nodes(); ++i) rest.push_back(at(model().rest(), i));
    contacts_.set_surface(soft.surface, rest);
    step.emplace(soft, contacts_, tool_, rig_model(scene, options), options.deformable(), scene.gravity_W);
    for (const std::size_t i : scene.moving()) {
      bodies.X_WB[static_cast<std::size_t>(bodies.count++)] = scene.bodies[i].X_WB;
    }
  }
  SoftRig(const SoftRig&) = delete;
  SoftRig& operator=(const SoftRig&) = delete;

  StepResult advance(double h, const DeviceState& device = {}) {
    const DeviceState before = device_;
    device_ = device;
    return step->advance(coupling, before, device, {}, h, bodies);
  }

  [[nodiscard]] const ElasticModel& model() const { return soft.model; }
  [[nodiscard]] static Vec3 at(const Eigen::VectorXd& x, int node) {
    return {x[3 * node], x[3 * node + 1], x[3 * node + 2]};
  }
  /// N s, of all unknowns with velocities v.
  [[nodiscard]] Eigen::Vector3d momentum(const Eigen::VectorXd& v) const {
    const Eigen::VectorXd p = model().mass().selfadjointView<Eigen::Lower>() * v;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int u = 0; u < model().unknowns(); u += 3) sum += p.segment<3>(u);
    return sum;
  }
  [[nodiscard]] Eigen::Vector3d momentum() const { return momentum(step->v()); }
  /// kg, of all unknowns.
  [[nodiscard]] double mass() const {
    Eigen::VectorXd along = Eigen::VectorXd::Zero(model().unknowns());
    for (int u = 0; u < model().unknowns(); u += 3) along[u] = 1;
    return momentum(along).x();
  }
  /// m, of what is free.
  [[nodiscard]] Eigen::Vector3d centre() const {
    Eigen::VectorXd x(model().unknowns());
    for (int u = 0; u < model().unknowns(); u += 3) x.segment<3>(u) = step->x().segment<3>(3 * model().node_of(u));
    return momentum(x) / mass();
  }
  /// Moves the unknowns by `u` (m) from rest and gives them velocities v.
  void start(const Eigen::VectorXd& u, const Eigen::VectorXd& v) { step->place(moved(model(), model().rest(), u), v); }

  Scene scene;
  SoftScene soft;

 private:
  ContactBody tool_;
  SoftContacts contacts_;
  DeviceState device_;

 public:
  std::optional<DeformableStep> step;
  BodyStates bodies;
  CouplingParameters coupling;  ///< none, unless a test says so
};

}  // namespace tactor::test
