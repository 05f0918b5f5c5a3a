// truth_simbody SCENE.json MOTION.csv OUT.csv [ACCURACY]: the tool on its spring in Simbody, with Simbody's contacts.
//
// ACCURACY is that of the error-controlled Runge-Kutta-Merson integrator, 1e-6 by default.
#include <Simbody.h>

#include <cmath>
#include <memory>

#include "truth_io.hpp"

namespace truth {

namespace {

/// Simbody's own contact parameters, the same for all bodies of a scene.
struct Material {
  double stiffness = 0;            ///< Pa, of each body: plane-strain modulus for Hertz, layer modulus for meshes
  double vertex_stiffness = 0;     ///< N/m, of each body, for each vertex of a box
  double layer = 0;                ///< m, thickness of the elastic layer on a mesh and on what touches it
  double dissipation = 0;          ///< s/m, of Hunt and Crossley
  double friction = 0;             ///< static and dynamic
  double transition_velocity = 0;  ///< m/s, at which friction is whole
  int refine = 0;                  ///< each triangle of a mesh is cut into 4^refine
};

Material read_material(const Scene& scene) {
  if (!scene.engines.contains("simbody")) throw InputError(scene.file.string() + ": simbody: this key is missing");
  Keys keys(scene.file, "simbody", scene.engines.at("simbody"));
  Material m;
  m.stiffness = keys.positive("stiffness");
  m.vertex_stiffness = keys.positive("vertex_stiffness");
  m.layer = keys.positive("layer");
  m.dissipation = keys.not_negative("dissipation");
  m.friction = keys.not_negative("friction");
  m.transition_velocity = keys.positive("transition_velocity");
  const double refine = keys.not_negative("refine");
  if (refine > 4 || refine != std::floor(refine)) keys.refuse("refine", "expected a whole number from 0 to 4");
  m.refine = static_cast<int>(refine);
  keys.done();
  return m;
}

SimTK::Vec3 vec(const Vector3d& v) {
  return {v[0], v[1], v[2]};
}

Vector3d eigen(const SimTK::Vec3& v) {
  return {v[0], v[1], v[2]};
}

SimTK::Rotation rotation(const Quaterniond& q) {
  return SimTK::Rotation(SimTK::Quaternion(q.w(), q.x(), q.y(), q.z()));
}

SimTK::Transform transform(const Pose& X) {
  return {rotation(X.R), vec(X.p)};
}

/// The half-space of Simbody fills x > 0; this turns it into z <= 0.
SimTK::Transform half_space_below_z() {
  return SimTK::Transform(SimTK::Rotation(SimTK::Pi / 2, SimTK::YAxis));
}

State tool_state(const SimTK::State& state, const SimTK::MobilizedBody& body) {
  State tool;
  tool.X.p = eigen(body.getBodyOriginLocation(state));
  const SimTK::Quaternion q = body.getBodyRotation(state).convertRotationToQuaternion();
  tool.X.R = Quaterniond(q[0], q[1], q[2], q[3]);
  tool.v = eigen(body.getBodyOriginVelocity(state));
  tool.w = eigen(body.getBodyAngularVelocity(state));
  return tool;
}

/// The spring and damper to the handle.
class CouplingForce : public SimTK::Force::Custom::Implementation {
 public:
  CouplingForce(const Scene& scene, const Motion& motion, const SimTK::MobilizedBody& tool)
      : scene_(scene), motion_(motion), tool_(tool) {}

  void calcForce(const SimTK::State& state, SimTK::Vector_<SimTK::SpatialVec>& body_forces,
                 SimTK::Vector_<SimTK::Vec3>&, SimTK::Vector&) const override {
    const Wrench device =
        coupling_wrench(scene_.coupling, motion_.at(state.getTime()), tool_state(state, tool_), scene_.rotates);
    body_forces[tool_.getMobilizedBodyIndex()] += SimTK::SpatialVec(vec(-device.torque), vec(-device.force));
  }
  SimTK::Real calcPotentialEnergy(const SimTK::State&) const override { return 0; }
  bool dependsOnlyOnPositions() const override { return false; }

 private:
  const Scene& scene_;
  const Motion& motion_;
  const SimTK::MobilizedBody& tool_;
};

/// A fixed box as the half-space of the face that the tool is before, for Simbody's trackers know no fixed box.
struct Face {
  SimTK::Transform X_WH;  // of the half-space z <= 0
  Pose X_WB;
  int axis = 0;
  Vector3d half;
};

Face nearest_face(const Box& box, const Pose& X_WB, const Vector3d& p_WT) {
  const Vector3d p = X_WB.R.conjugate() * (p_WT - X_WB.p), half = box.size / 2;
  int axis = 0;
  const Vector3d out = p.cwiseAbs() - half;
  out.maxCoeff(&axis);
  const double side = p[axis] < 0 ? -1 : 1;
  const Vector3d n_W = X_WB.R * Vector3d(side * Vector3d::Unit(axis));
  const Vector3d q_W = X_WB.p + half[axis] * n_W;
  return {transform({q_W, Quaterniond::FromTwoVectors(Vector3d::UnitZ(), n_W)}), X_WB, axis, half};
}

SimTK::ContactGeometry::TriangleMesh mesh_geometry(const Mesh& mesh, int levels) {
  const Triangles triangles = read_mesh(mesh, levels);
  SimTK::Array_<SimTK::Vec3> vertices;
  for (const Vector3d& v : triangles.vertices) vertices.push_back(vec(v));
  SimTK::Array_<int> faces;
  for (const auto& f : triangles.faces) faces.insert(faces.end(), f.begin(), f.end());
  try {
    return {vertices, faces};
  } catch (const std::exception& error) {
    throw InputError(mesh.file.string() + ": Simbody refuses the mesh: " + error.what());
  }
}

struct Parts {
  SimTK::MultibodySystem system;
  SimTK::SimbodyMatterSubsystem matter{system};
  SimTK::GeneralForceSubsystem forces{system};
  SimTK::ContactTrackerSubsystem tracker{system};
  SimTK::CompliantContactSubsystem contact{system, tracker};
  std::vector<Face> faces;
  std::unique_ptr<SimTK::MobilizedBody> tool;
};

void add_fixed(Parts& parts, const Scene& scene, const Material& m, const Vector3d& p_WT) {
  const bool is_box = std::holds_alternative<Box>(scene.tool);
  const SimTK::ContactMaterial solid(is_box ? m.vertex_stiffness : m.stiffness, m.dissipation, m.friction, m.friction);
  SimTK::Body& ground = parts.matter.Ground().updBody();
  for (const FixedBody& body : scene.fixed) {
    if (std::holds_alternative<Plane>(body.shape)) {
      ground.addContactSurface(transform(body.X_WB) * half_space_below_z(),
                               SimTK::ContactSurface(SimTK::ContactGeometry::HalfSpace(), solid));
    } else if (const auto* box = std::get_if<Box>(&body.shape)) {
      parts.faces.push_back(nearest_face(*box, body.X_WB, p_WT));
      ground.addContactSurface(parts.faces.back().X_WH * half_space_below_z(),
                               SimTK::ContactSurface(SimTK::ContactGeometry::HalfSpace(), solid));
    } else {
      if (!std::holds_alternative<Sphere>(scene.tool)) {
        throw InputError(scene.file.string() + ": tool.shape: on a mesh Simbody takes a sphere alone");
      }
      ground.addContactSurface(
          transform(body.X_WB),
          SimTK::ContactSurface(mesh_geometry(std::get<Mesh>(body.shape), m.refine), solid, m.layer));
    }
  }
}

void add_tool(Parts& parts, const Scene& scene, const Material& m, const Pose& start) {
  const SimTK::ContactMaterial soft(m.stiffness, m.dissipation, m.friction, m.friction);
  const SimTK::ContactMaterial vertex(m.vertex_stiffness, m.dissipation, m.friction, m.friction);
  const SimTK::Vec3 moments = scene.rotates ? vec(scene.inertia_T) : SimTK::Vec3(1e-6);
  SimTK::Body::Rigid body(SimTK::MassProperties(scene.mass, SimTK::Vec3(0), SimTK::Inertia(moments)));
  if (const auto* sphere = std::get_if<Sphere>(&scene.tool)) {
    body.addContactSurface(SimTK::Transform(),
                           SimTK::ContactSurface(SimTK::ContactGeometry::Sphere(sphere->radius), soft, m.layer));
  } else if (const auto* capsule = std::get_if<Capsule>(&scene.tool)) {
    // Against a half-space the deepest place of a capsule is one of its ends.
    for (const double end : {-0.5, 0.5}) {
      body.addContactSurface(SimTK::Transform(SimTK::Vec3(0, 0, end * capsule->length)),
                             SimTK::ContactSurface(SimTK::ContactGeometry::Sphere(capsule->radius), soft));
    }
  } else {
    const Vector3d half = std::get<Box>(scene.tool).size / 2;
    body.addContactSurface(SimTK::Transform(), SimTK::ContactSurface(SimTK::ContactGeometry::Brick(vec(half)), vertex));
  }
  if (scene.rotates) {
    parts.tool = std::make_unique<SimTK::MobilizedBody>(
        SimTK::MobilizedBody::Free(parts.matter.Ground(), SimTK::Transform(), body, SimTK::Transform()));
  } else {
    parts.tool = std::make_unique<SimTK::MobilizedBody>(SimTK::MobilizedBody::Translation(
        parts.matter.Ground(), SimTK::Transform(), body, SimTK::Transform(rotation(start.R.conjugate()))));
  }
}

/// Throws where the tool is no longer before the face that stands for a box.
void check_faces(const Parts& parts, const Vector3d& p_WT, double t) {
  for (const Face& face : parts.faces) {
    const Vector3d p = face.X_WB.R.conjugate() * (p_WT - face.X_WB.p);
    for (int i = 0; i < 3; ++i) {
      if (i != face.axis && std::abs(p[i]) > face.half[i]) {
        throw std::runtime_error("the tool leaves the face of a box at " + std::to_string(t) +
                                 " s; Simbody has a half-space in its place");
      }
    }
  }
}

void work(const std::vector<std::string>& arguments) {
  const double accuracy = arguments.size() > 3 ? positive_argument("ACCURACY", arguments[3]) : 1e-6;
  const Scene scene = read_scene(arguments[0]);
  const Material material = read_material(scene);
  const Motion motion(arguments[1]);
  const Pose start = scene.starts_at_handle ? motion.at(motion.time(0)).X : scene.X_WT;
  Parts parts;
  parts.contact.setTransitionVelocity(material.transition_velocity);
  add_fixed(parts, scene, material, start.p);
  add_tool(parts, scene, material, start);
  SimTK::Force::Gravity(parts.forces, parts.matter, vec(scene.gravity_W));
  SimTK::Force::Custom(parts.forces, new CouplingForce(scene, motion, *parts.tool));
  SimTK::State initial = parts.system.realizeTopology();
  parts.tool->setQToFitTransform(initial, transform(start));
  initial.setTime(motion.time(0));
  SimTK::RungeKuttaMersonIntegrator integrator(parts.system);
  integrator.setAccuracy(accuracy);
  integrator.setAllowInterpolation(false);
  integrator.initialize(initial);
  Table table(arguments[2]);
  for (std::size_t i = 0; i < motion.count(); ++i) {
    const double t = motion.time(i);
    while (integrator.getTime() < t - 1e-12) {
      if (integrator.stepTo(t, t) == SimTK::Integrator::EndOfSimulation) {
        throw std::runtime_error("Simbody ended at " + std::to_string(integrator.getTime()) + " s");
      }
    }
    const SimTK::State& state = integrator.getState();
    parts.system.realize(state, SimTK::Stage::Dynamics);
    const State tool = tool_state(state, *parts.tool);
    check_faces(parts, tool.X.p, t);
    int count = 0;
    Vector3d sum = Vector3d::Zero();
    for (int k = 0; k < parts.contact.getNumContactForces(state); ++k) {
      const SimTK::ContactForce& one = parts.contact.getContactForce(state, k);
      const SimTK::Contact& touching = parts.tracker.getActiveContacts(state).getContactById(one.getContactId());
      const bool tool_is_second = parts.tracker.getMobilizedBody(touching.getSurface2()).getMobilizedBodyIndex() ==
                                  parts.tool->getMobilizedBodyIndex();
      const Vector3d on_second = eigen(one.getForceOnSurface2()[1]);
      if (on_second.norm() > 0) ++count;
      sum += tool_is_second ? on_second : Vector3d(-on_second);
    }
    table.row(t, scene.coupling, coupling_wrench(scene.coupling, motion.at(t), tool, scene.rotates), tool, count, sum);
  }
  table.close();
}

}  // namespace

}  // namespace truth

int main(int argc, char** argv) {
  return truth::run_program(argc, argv, "SCENE.json MOTION.csv OUT.csv [ACCURACY]", 3, truth::work);
}
