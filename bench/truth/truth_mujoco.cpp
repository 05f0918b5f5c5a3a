// truth_mujoco SCENE.json MOTION.csv OUT.csv [STEP]: the tool on its spring in MuJoCo, with MuJoCo's contacts.
//
// STEP in s is the longest step, 5e-5 by default. The integrator is MuJoCo's semi-implicit Euler; the spring is
// explicit in it, so its error falls with the step.
#include <mujoco/mujoco.h>

#include <cmath>
#include <cstdlib>
#include <memory>
#include <sstream>

#include "truth_io.hpp"

namespace truth {

namespace {

/// MuJoCo's own contact parameters, the same for all bodies of a scene.
struct Material {
  std::vector<double> solref;  ///< time constant [s] and damping ratio; negative: -stiffness, -damping
  std::vector<double> solimp;  ///< d_0, d_width, width [m], midpoint, power
  double friction = 0;
  double impratio = 0;  ///< impedance of friction over that of the normal
};

Material read_material(const Scene& scene) {
  if (!scene.engines.contains("mujoco")) throw InputError(scene.file.string() + ": mujoco: this key is missing");
  Keys keys(scene.file, "mujoco", scene.engines.at("mujoco"));
  Material m{keys.numbers("solref", 2), keys.numbers("solimp", 5), keys.not_negative("friction"),
             keys.positive("impratio")};
  if ((m.solref[0] > 0) != (m.solref[1] > 0)) keys.refuse("solref", "expected two numbers of one sign");
  keys.done();
  return m;
}

struct Model {
  std::unique_ptr<mjModel, void (*)(mjModel*)> m{nullptr, mj_deleteModel};
  std::unique_ptr<mjData, void (*)(mjData*)> d{nullptr, mj_deleteData};
};

std::string numbers(const std::vector<double>& values) {
  std::ostringstream text;
  text.precision(17);
  for (const double v : values) text << v << ' ';
  return text.str();
}

std::string words(const Vector3d& v) {
  return numbers({v[0], v[1], v[2]});
}

std::string words(const Quaterniond& q) {
  return numbers({q.w(), q.x(), q.y(), q.z()});
}

std::string geom(const Scene& scene, const std::string& name, const Shape& shape) {
  if (const auto* s = std::get_if<Sphere>(&shape)) return "type='sphere' size='" + numbers({s->radius}) + "'";
  if (const auto* c = std::get_if<Capsule>(&shape)) {
    return "type='capsule' size='" + numbers({c->radius, c->length / 2}) + "'";
  }
  if (const auto* b = std::get_if<Box>(&shape)) return "type='box' size='" + words(Vector3d(b->size / 2)) + "'";
  if (std::holds_alternative<Plane>(shape)) return "type='plane' size='0 0 1'";
  throw InputError(scene.file.string() + ": fixed." + name +
                   ".shape: MuJoCo takes a mesh as its convex hull, so a mesh is refused here; truth_simbody takes it");
}

std::string make_xml(const Scene& scene, const Material& material, const Quaterniond& R_WT) {
  const std::string surface = " condim='3' friction='" + numbers({material.friction, 0, 0}) + "' solref='" +
                              numbers(material.solref) + "' solimp='" + numbers(material.solimp) + "'";
  std::ostringstream xml;
  xml.precision(17);
  xml << "<mujoco><option gravity='" << words(scene.gravity_W) << "' cone='elliptic' solver='Newton' iterations='100'"
      << " tolerance='1e-14' impratio='" << material.impratio << "'/><size nconmax='200' njmax='800'/><worldbody>";
  for (const FixedBody& body : scene.fixed) {
    // In the world body itself: a plane in a static body of its own is met twice by MuJoCo 2.2.2.
    xml << "<geom pos='" << words(body.X_WB.p) << "' quat='" << words(body.X_WB.R) << "' "
        << geom(scene, body.name, body.shape) << surface << "/>";
  }
  xml << "<body name='tool' quat='" << words(scene.rotates ? Quaterniond::Identity() : R_WT) << "'>";
  if (scene.rotates) {
    xml << "<freejoint/>";
  } else {
    // The axes of a joint are the body's.
    for (int axis = 0; axis < 3; ++axis) {
      xml << "<joint type='slide' axis='" << words(Vector3d(R_WT.conjugate() * Vector3d::Unit(axis))) << "'/>";
    }
  }
  const Vector3d inertia = scene.rotates ? scene.inertia_T : Vector3d::Constant(1e-6);
  xml << "<inertial pos='0 0 0' mass='" << scene.mass << "' diaginertia='" << words(inertia) << "'/><geom "
      << geom(scene, "tool", scene.tool) << surface << "/></body></worldbody></mujoco>";
  return xml.str();
}

Model make_model(const std::string& xml) {
  const auto vfs = std::make_unique<mjVFS>();
  mj_defaultVFS(vfs.get());
  mj_makeEmptyFileVFS(vfs.get(), "scene.xml", static_cast<int>(xml.size()));
  std::copy(xml.begin(), xml.end(), static_cast<char*>(vfs->filedata[0]));
  char error[1000] = "";
  Model model;
  model.m.reset(mj_loadXML("scene.xml", vfs.get(), error, sizeof error));
  mj_deleteVFS(vfs.get());
  if (!model.m) throw std::runtime_error(std::string("MuJoCo refuses the scene: ") + error);
  model.d.reset(mj_makeData(model.m.get()));
  return model;
}

/// The tool out of MuJoCo's coordinates. A free joint's angular velocity is in the body's frame.
State tool_state(const Scene& scene, const mjData& d, const Quaterniond& R_WT) {
  State tool;
  tool.X.p = Vector3d(d.qpos);
  tool.v = Vector3d(d.qvel);
  tool.X.R = R_WT;
  if (scene.rotates) {
    tool.X.R = Quaterniond(d.qpos[3], d.qpos[4], d.qpos[5], d.qpos[6]).normalized();
    tool.w = tool.X.R * Vector3d(d.qvel + 3);
  }
  return tool;
}

struct ContactSum {
  int count = 0;
  Vector3d force_T_W = Vector3d::Zero();
};

ContactSum contacts_on(const mjModel& m, const mjData& d, int tool) {
  ContactSum sum;
  for (int i = 0; i < d.ncon; ++i) {
    if (d.contact[i].efc_address < 0) continue;
    mjtNum wrench[6];
    mj_contactForce(&m, &d, i, wrench);
    if (!(wrench[0] > 0)) continue;
    ++sum.count;
    // The rows of `frame` are its axes; the first one is the normal from geom1 to geom2.
    const Eigen::Map<const Eigen::Matrix<mjtNum, 3, 3, Eigen::RowMajor>> axes(d.contact[i].frame);
    const Vector3d on_second = axes.transpose() * Vector3d(wrench);
    sum.force_T_W += m.geom_bodyid[d.contact[i].geom2] == tool ? on_second : Vector3d(-on_second);
  }
  return sum;
}

void check(const mjData& d) {
  for (const int warning : {mjWARN_BADQPOS, mjWARN_BADQVEL, mjWARN_BADQACC, mjWARN_CONTACTFULL, mjWARN_CNSTRFULL}) {
    if (d.warning[warning].number > 0) {
      throw std::runtime_error("MuJoCo failed at " + std::to_string(d.time) +
                               " s: " + mju_warningText(warning, d.warning[warning].lastinfo));
    }
  }
}

void work(const std::vector<std::string>& arguments) {
  const double longest = arguments.size() > 3 ? positive_argument("STEP", arguments[3]) : 5e-5;
  const Scene scene = read_scene(arguments[0]);
  const Material material = read_material(scene);
  const Motion motion(arguments[1]);
  const Pose start = scene.starts_at_handle ? motion.at(motion.time(0)).X : scene.X_WT;
  const Model model = make_model(make_xml(scene, material, start.R));
  mjModel& m = *model.m;
  mjData& d = *model.d;
  const int tool_id = mj_name2id(&m, mjOBJ_BODY, "tool");
  for (int i = 0; i < 3; ++i) d.qpos[i] = start.p[i];
  if (scene.rotates) {
    d.qpos[3] = start.R.w();
    for (int i = 0; i < 3; ++i) d.qpos[4 + i] = start.R.vec()[i];
  }
  const auto apply = [&](double t) {
    const State tool = tool_state(scene, d, start.R);
    const Wrench device = coupling_wrench(scene.coupling, motion.at(t), tool, scene.rotates);
    for (int i = 0; i < 3; ++i) {
      d.xfrc_applied[6 * tool_id + i] = -device.force[i];
      d.xfrc_applied[6 * tool_id + 3 + i] = -device.torque[i];
    }
    return std::pair(tool, device);
  };
  Table table(arguments[2]);
  for (std::size_t i = 0; i < motion.count(); ++i) {
    const double t = motion.time(i);
    const auto [tool, device] = apply(t);
    mj_forward(&m, &d);
    const ContactSum contacts = contacts_on(m, d, tool_id);
    table.row(t, scene.coupling, device, tool, contacts.count, contacts.force_T_W);
    if (i + 1 == motion.count()) break;
    const double dt = motion.time(i + 1) - t;
    const int steps = static_cast<int>(std::ceil(dt / longest - 1e-6));
    m.opt.timestep = dt / steps;
    for (int k = 0; k < steps; ++k) {
      apply(t + k * dt / steps);
      mj_step(&m, &d);
    }
    check(d);
  }
  table.close();
}

}  // namespace

}  // namespace truth

int main(int argc, char** argv) {
  mju_user_error = [](const char* text) {
    std::fprintf(stderr, "MuJoCo: %s\n", text);
    std::exit(1);
  };
  mju_user_warning = [](const char*) {};
  return truth::run_program(argc, argv, "SCENE.json MOTION.csv OUT.csv [STEP]", 3, truth::work);
}
