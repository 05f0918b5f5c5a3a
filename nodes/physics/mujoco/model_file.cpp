#include "nodes/physics/mujoco/model_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>

#include "framework/core/shared_object.hpp"
#include "framework/core/spatial.hpp"
#include "framework/core/value_error.hpp"
#include "nodes/physics/engine/model_files.hpp"
#include "nodes/physics/mujoco/guarded_call.hpp"

namespace tactor {

namespace {

namespace fs = std::filesystem;

/// What a guarded reading of a file takes and gives.
struct Reading {
  const char* file;
  const mjVFS* files;
  std::array<char, 1000> error{};
  mjModel* model = nullptr;
};

/// Null where it cannot be read; `why` says so then.
ModelPointer read(const fs::path& file, const mjVFS* files, std::string& why) {
  const std::string name = file.string();
  Reading reading{.file = name.c_str(), .files = files};
  MujocoText text;
  const bool done = call_guarded(
      text,
      [](void* argument) {
        auto& r = *static_cast<Reading*>(argument);
        r.model = mj_loadXML(r.file, r.files, r.error.data(), static_cast<int>(r.error.size()));
      },
      &reading);
  if (done && reading.model != nullptr) return ModelPointer(reading.model);
  why = done ? reading.error.data() : text.data();
  std::replace(why.begin(), why.end(), '\n', ' ');
  why.erase(why.find_last_not_of(' ') + 1);
  return nullptr;
}

std::string in_xml(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

/// The file as it is, without the coupling. Throws ValueError about `model`.
ModelPointer plain_model(const fs::path& file) {
  std::string why;
  ModelPointer alone = read(file, nullptr, why);
  if (alone == nullptr) throw ValueError("model", file.string() + ": MuJoCo cannot read it: " + why);
  return alone;
}

/// Its absolute path. Throws ValueError about `model` where its name is not that of a model.
fs::path model_path(const fs::path& file) {
  fs::path path = fs::absolute(file);
  if (path.extension() != ".xml") {
    throw ValueError("model", path.string() + ": expected a model of MuJoCo in a file .xml");
  }
  return path;
}

/// The joints of a body in words, and what it hangs on if that is not the world.
std::string joints_in_words(const mjModel& m, int body) {
  const int count = m.body_jntnum[body];
  if (m.body_mocapid[body] >= 0) return "no joint, moved by mocap";
  if (count == 0) return "no joint";
  constexpr std::array<const char*, 4> words{"free", "ball", "slide", "hinge"};
  std::string text = count == 1 ? "" : std::to_string(count) + " ";
  const int first = m.body_jntadr[body];
  text += words.at(static_cast<std::size_t>(m.jnt_type[first]));
  for (int joint = first + 1; joint < first + count; ++joint) {
    if (m.jnt_type[joint] == m.jnt_type[joint - 1]) continue;
    text += std::string(" and ") + words.at(static_cast<std::size_t>(m.jnt_type[joint]));
  }
  text += count == 1 ? " joint" : " joints";
  const char* parent = m.body_parentid[body] == 0 ? nullptr : mj_id2name(&m, mjOBJ_BODY, m.body_parentid[body]);
  return parent == nullptr ? text : text + " on body '" + parent + "'";
}

/// The names of the bodies that hang on the world by a joint, for messages.
std::string movable_bodies(const mjModel& m) {
  std::string names;
  for (int b = 1; b < m.nbody; ++b) {
    if (m.body_parentid[b] != 0 || m.body_jntnum[b] == 0) continue;
    const char* name = mj_id2name(&m, mjOBJ_BODY, b);
    if (name != nullptr && *name != '\0') names += (names.empty() ? "" : ", ") + std::string(name);
  }
  return names.empty() ? "none" : names;
}

[[noreturn]] void refuse_tool(const mjModel& m, const EngineModel& model, const std::string& what) {
  throw ValueError("tool", model.file.string() + ": body '" + model.tool + "' " + what +
                               ". The coupling moves a child of the world with a free joint, or with three slide "
                               "joints along different axes; bodies of the world with joints: " +
                               movable_bodies(m));
}

/// True where the joints of the body are three slides whose axes span the space.
bool slides_everywhere(const mjModel& m, int body) {
  if (m.body_jntnum[body] != 3) return false;
  std::array<Vec3, 3> axis;
  for (int i = 0; i < 3; ++i) {
    const int joint = m.body_jntadr[body] + i;
    if (m.jnt_type[joint] != mjJNT_SLIDE) return false;
    const double* a = m.jnt_axis + 3 * joint;
    axis[static_cast<std::size_t>(i)] = {a[0], a[1], a[2]};
  }
  return std::abs(dot(axis[0], cross(axis[1], axis[2]))) > 1e-3;
}

/// Throws where a joint of the tool moves it otherwise than its mass and the forces on it would.
void check_joints(const mjModel& m, const EngineModel& model, int tool) {
  const auto refuse = [&](const char* attribute) {
    throw ValueError("tool", model.file.string() + ": a joint of body '" + model.tool + "' has " + attribute +
                                 ", and the coupling and the metrics are made for a tool that nothing but contacts and "
                                 "the coupling holds; leave it out");
  };
  for (int joint = m.body_jntadr[tool]; joint < m.body_jntadr[tool] + m.body_jntnum[tool]; ++joint) {
    if (m.jnt_stiffness[joint] != 0) refuse("stiffness");
  }
  for (int dof = m.body_dofadr[tool]; dof < m.body_dofadr[tool] + m.body_dofnum[tool]; ++dof) {
    if (m.dof_damping[dof] != 0) refuse("damping");
    if (m.dof_frictionloss[dof] != 0) refuse("frictionloss");
    if (m.dof_armature[dof] != 0) refuse("armature");
  }
}

/// Throws where a body is welded to the tool, whose centre of mass would then be another than that of the whole.
void check_welded(const mjModel& m, const EngineModel& model, int tool) {
  for (int b = tool + 1; b < m.nbody; ++b) {
    if (m.body_weldid[b] != tool) continue;
    const char* name = mj_id2name(&m, mjOBJ_BODY, b);
    throw ValueError("tool", model.file.string() + ": body '" + (name != nullptr ? name : "") +
                                 "' is welded to body '" + model.tool +
                                 "', which then has another centre of mass; give its geoms to body '" + model.tool +
                                 "' itself");
  }
}

void check_tool(const mjModel& m, const EngineModel& model) {
  const int tool = mj_name2id(&m, mjOBJ_BODY, model.tool.c_str());
  if (tool <= 0) refuse_tool(m, model, "is the world");
  if (m.body_parentid[tool] != 0) {
    const char* parent = mj_id2name(&m, mjOBJ_BODY, m.body_parentid[tool]);
    refuse_tool(m, model, std::string("hangs on body '") + (parent != nullptr ? parent : "") + "'");
  }
  const bool is_free = m.body_jntnum[tool] == 1 && m.jnt_type[m.body_jntadr[tool]] == mjJNT_FREE;
  if (!is_free && !slides_everywhere(m, tool)) {
    refuse_tool(m, model, m.body_jntnum[tool] == 0 ? "has no joint" : "has other joints");
  }
  check_joints(m, model, tool);
  check_welded(m, model, tool);
  if ((m.opt.disableflags & (mjDSBL_CONSTRAINT | mjDSBL_EQUALITY)) != 0) {
    throw ValueError("model", model.file.string() +
                                  ": <option><flag> disables constraints or equalities, and the coupling is one; "
                                  "enable both");
  }
}

ModelPointer welded_model(const fs::path& file, const EngineModel& model) {
  const std::string text = "<mujoco><include file=\"" + in_xml(file.filename().string()) +
                           "\"/><equality><weld active=\"true\" body1=\"" + in_xml(model.tool) +
                           "\"/></equality></mujoco>";
  const char* const name = "tactor coupling.xml";
  // It lies in the folder of the model, so that what the model names is found from there.
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), name, static_cast<int>(text.size()));
  std::memcpy(files->filedata[0], text.data(), text.size());
  std::string why;
  ModelPointer coupled = read(file.parent_path() / name, files.get(), why);
  mj_deleteVFS(files.get());
  if (coupled == nullptr) {
    const ModelPointer alone = plain_model(file);
    if (mj_name2id(alone.get(), mjOBJ_BODY, model.tool.c_str()) < 0) {
      refuse_tool(*alone, model, "is not there");
    }
    if (mj_name2id(alone.get(), mjOBJ_BODY, model.tool.c_str()) == 0) refuse_tool(*alone, model, "is the world");
    throw ValueError("model", file.string() + ": MuJoCo cannot weld body '" + model.tool + "' to the world: " + why);
  }
  check_tool(*coupled, model);
  return coupled;
}

/// Changes where one of the files of the model does.
std::string key_of(const fs::path& file, const EngineModel& model) {
  std::string key = "model of MuJoCo\n" + model.tool;
  const auto add = [&key](const fs::path& part) {
    std::error_code ignored;
    const auto changed = fs::last_write_time(part, ignored).time_since_epoch().count();
    key += "\n" + part.string() + " " + std::to_string(changed);
  };
  add(file);
  for (const fs::path& part : model_files(file)) add(part);
  return key;
}

/// Whether the coupling can move that body.
bool is_usable_tool(const mjModel& m, const fs::path& file, const std::string& body) {
  try {
    check_tool(m, {.file = file, .tool = body, .keyframe = {}, .bodies = {}});
    return true;
  } catch (const ValueError& error) {
    if (error.path() == "model") throw;
    return false;
  }
}

}  // namespace

std::vector<ModelBody> model_bodies(const fs::path& file) {
  const fs::path path = model_path(file);
  const ModelPointer model = plain_model(path);
  std::vector<ModelBody> bodies;
  for (int b = 1; b < model->nbody; ++b) {
    const char* name = mj_id2name(model.get(), mjOBJ_BODY, b);
    if (name == nullptr || *name == '\0') continue;
    bodies.push_back({name, joints_in_words(*model, b), is_usable_tool(*model, path, name)});
  }
  return bodies;
}

std::shared_ptr<const mjModel> read_coupled_model(const EngineModel& model) {
  const fs::path file = model_path(model.file);
  const std::string key = about("model", [&] { return key_of(file, model); });
  // Callers wait for each other, which MuJoCo needs: it keeps the file that it has read last.
  return std::static_pointer_cast<const mjModel>(shared_object(
      key, [&]() -> std::shared_ptr<const void> { return std::shared_ptr<const mjModel>(welded_model(file, model)); }));
}

}  // namespace tactor
