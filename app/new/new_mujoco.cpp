#include "app/new/new_mujoco.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "app/new/new_project.hpp"
#include "app/output.hpp"
#include "framework/core/check.hpp"
#include "framework/core/input_file.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t max_project_bytes = 1 << 20;

/// m, of the motion that is written.
constexpr double press_depth = 3e-3, slide_way = 10e-3, clearance = 10e-3;
/// m, of the search for a surface.
constexpr double search_step = 1e-3, farthest_surface = 0.3, surface_tolerance = 1e-6;

/// Where the tool touches something.
struct FirstHit {
  Vec3 direction_W;     ///< unit, from where the tool begins
  double distance = 0;  ///< m
};

/// m, along `direction` to the first touch; none within `most`.
std::optional<double> distance_to_touch(CoupledEngine& engine, const Pose& begin, const Vec3& direction, double most) {
  const auto touches = [&](double s) { return engine.touches_at({begin.p + s * direction, begin.R}); };
  for (double s = 0; s <= most; s += search_step) {
    if (!touches(s)) continue;
    double apart = std::max(0.0, s - search_step), touching = s;
    while (touching - apart > surface_tolerance) {
      const double middle = 0.5 * (apart + touching);
      (touches(middle) ? touching : apart) = middle;
    }
    return touching;
  }
  return std::nullopt;
}

/// The nearest surface along an axis of the world, of equal ones the one below.
std::optional<FirstHit> nearest_surface(CoupledEngine& engine) {
  const Pose begin = engine.tool().X_WT;
  std::optional<FirstHit> nearest;
  double most = farthest_surface;
  for (const Vec3& direction :
       {Vec3{0, 0, -1}, Vec3{1, 0, 0}, Vec3{-1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, -1, 0}, Vec3{0, 0, 1}}) {
    const std::optional<double> distance = distance_to_touch(engine, begin, direction, most);
    if (!distance || (nearest && *distance >= nearest->distance)) continue;
    nearest = {direction, *distance};
    most = *distance;
  }
  return nearest;
}

std::string point_line(double t, const Vec3& p, const std::string& note = "") {
  const auto mm = [](double metres) {
    const double rounded = std::round(1e5 * metres) / 1e2;
    return fmt::format("{:.15g} mm", rounded == 0 ? 0.0 : rounded);
  };
  return fmt::format("      - {{t: {:g} s, x: {}, y: {}, z: {}}}{}\n", t, mm(p.x), mm(p.y), mm(p.z),
                     note.empty() ? "" : "   # " + note);
}

/// The way-points, which begin and end where the tool is apart from the surface.
std::string points_text(CoupledEngine& engine) {
  const Vec3 begin = engine.tool().X_WT.p;
  const std::optional<FirstHit> surface = nearest_surface(engine);
  if (!surface) {
    return point_line(0, begin, "no surface is near: let it go to one") + point_line(0.4, begin) +
           point_line(2, begin + Vec3{slide_way, 0, 0}) + point_line(3.8, begin);
  }
  const Vec3& n = surface->direction_W;
  const Vec3 apart = begin + std::min(0.0, surface->distance - clearance) * n;
  const Vec3 pressed = begin + (surface->distance + press_depth) * n;
  const Vec3 along = slide_way * (n.x == 0 ? Vec3{1, 0, 0} : Vec3{0, 1, 0});
  return point_line(0, apart) + point_line(0.4, apart) + point_line(1.2, pressed, "presses") +
         point_line(2, pressed + along, "slides") + point_line(2.8, pressed) + point_line(3.8, apart, "leaves");
}

/// The text from the end of the line that begins with `from` to the line that begins with `to` gives way.
void replace_lines(std::string& text, const std::string& from, const std::string& to, const std::string& by) {
  const std::size_t line = text.find("\n" + from);
  TACTOR_DEMAND(line != std::string::npos);
  const std::size_t begin = text.find('\n', line + 1) + 1, end = text.find("\n" + to, begin) + 1;
  TACTOR_DEMAND(end > begin);
  text.replace(begin, end - begin, by);
}

void replace_value(std::string& text, const std::string& key, const std::string& value) {
  const std::size_t line = text.find("\n" + key);
  TACTOR_DEMAND(line != std::string::npos);
  const std::size_t begin = line + 1 + key.size();
  text.replace(begin, text.find('\n', begin) - begin, nlohmann::json(value).dump());
}

/// As the graph names it: from its own folder where the model lies beside or below the project, so that both can be
/// moved together.
std::string model_name(const fs::path& model, const fs::path& folder) {
  const fs::path file = fs::weakly_canonical(model), around = fs::weakly_canonical(folder);
  const fs::path way = file.lexically_relative(around);
  return way.empty() || *way.begin() == ".." ? file.string() : (".." / way).string();
}

std::string listed(const std::vector<ModelBody>& bodies) {
  std::string text;
  for (const ModelBody& body : bodies) {
    text += fmt::format("\n  {}: {}{}", body.name, body.joints, body.is_usable ? ", can be the tool" : "");
  }
  return text.empty() ? "\n  none that has a name" : text;
}

}  // namespace

std::string choose_tool(const std::vector<ModelBody>& bodies, const fs::path& model) {
  std::vector<std::string> usable;
  for (const ModelBody& body : bodies) {
    if (body.is_usable) usable.push_back(body.name);
  }
  for (const char* name : {"tool", "ee", "end_effector", "gripper"}) {
    if (std::find(usable.begin(), usable.end(), name) != usable.end()) return name;
  }
  if (usable.size() == 1) return usable.front();
  throw InputError(fmt::format("{}: {}. Its bodies:{}", model.string(),
                               usable.empty()
                                   ? "no body of the model can be the tool, which is a child of the world with a free "
                                     "joint, or with three slide joints; add such a body"
                                   : "several bodies can be the tool; choose one by --tool",
                               listed(bodies)));
}

std::vector<fs::path> new_mujoco(const NewMujocoRequest& request) {
  const MujocoPlugin& mujoco = load_mujoco_plugin("tactor new physics --mujoco");
  std::error_code ignored;
  if (!fs::is_regular_file(request.model, ignored)) {
    throw InputError("--mujoco: expected a model of MuJoCo, found no file " + request.model.string());
  }
  const std::vector<ModelBody> bodies = mujoco.bodies(request.model);
  const auto is_it = [&](const ModelBody& body) { return body.name == request.tool; };
  if (!request.tool.empty() && std::none_of(bodies.begin(), bodies.end(), is_it)) {
    throw InputError(fmt::format("--tool: {} has no body '{}'. Its bodies:{}", request.model.string(), request.tool,
                                 listed(bodies)));
  }
  const std::string tool = request.tool.empty() ? choose_tool(bodies, request.model) : request.tool;
  const auto engine = mujoco.engine({.file = request.model, .tool = tool, .keyframe = {}, .bodies = {}});
  const std::string points = points_text(*engine);
  std::vector<fs::path> files = new_project(ProjectKind::mujoco, request.name, request.folder);
  for (const fs::path& file : files) {
    if (file.filename() != request.name + ".yaml") continue;
    std::string text = read_input_file(file, max_project_bytes);
    replace_lines(text, "    points:", "  device:", points);
    replace_value(text, "    model: ", model_name(request.model, request.folder));
    replace_value(text, "    tool: ", tool);
    write_file(file, text);
  }
  return files;
}

}  // namespace tactor
