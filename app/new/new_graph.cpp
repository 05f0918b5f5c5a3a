#include "app/new/new_graph.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <vector>

#include "app/mesh/mesh_command.hpp"
#include "app/mesh/mesh_units.hpp"
#include "app/new/scene_text.hpp"
#include "app/output.hpp"
#include "framework/core/check.hpp"
#include "framework/core/input_file.hpp"
#include "framework/core/shell_word.hpp"
#include "framework/yaml/diagnostics.hpp"
#include "framework/yaml/file_finder.hpp"
#include "nodes/physics/mesh/body_mesh.hpp"
#include "nodes/physics/mesh/bounds.hpp"
#include "nodes/physics/mesh/box_mesh.hpp"
#include "nodes/physics/mesh/make_solid.hpp"
#include "nodes/physics/mesh/mesh_writers.hpp"
#include "nodes/physics/mesh/solid_file.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

constexpr double usual_size = 0.1;  // m, of what a hand goes about

/// A mesh as the scene takes it, in the unit of its file.
struct SceneMesh {
  TriangleMesh solid;
  std::string file;   // beside the scene
  std::string bytes;  // of that file
  std::string note;
};

/// As files are named: no blanks or signs that YAML or a shell reads.
std::string plain_name(const std::string& name) {
  std::string plain;
  for (const char c : name) {
    plain += std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-' ? c : '_';
  }
  return plain;
}

void check_name(const std::string& name) {
  const bool good = !name.empty() && name.size() <= 64 && std::isalpha(static_cast<unsigned char>(name[0])) != 0 &&
                    plain_name(name) == name;
  if (!good) {
    throw InputError(fmt::format(
        "tactor new graph: expected a name of letters, digits, `_` and `-` that begins with a letter, found '{}'",
        name));
  }
}

fs::path method_file(const std::string& method) {
  std::vector<std::string> names{"off"};
  for (const fs::path& file : files_of(method_files)) {
    if (file.parent_path().filename() == "methods") names.push_back(file.stem().string());
  }
  if (std::find(names.begin(), names.end(), method) == names.end()) {
    throw InputError(fmt::format("--method {}: expected a method of graphs/methods{}; there are {}", method,
                                 did_you_mean(method, names), fmt::join(names, ", ")));
  }
  return method;
}

/// The mesh, or what a repair makes of it.
SceneMesh scene_mesh(const fs::path& path) {
  const MeshFile file = read_mesh_file(path);
  const std::string stem = plain_name(path.stem().string());
  SceneMesh result;
  std::string refusal;
  try {
    MeshReport report;
    result.solid = make_solid(file.soup, path.string(), report);
    for (const std::string& warning : report.warnings) tell_note(path.string() + ": warning: " + warning);
    std::string ending = path.extension().string();
    if (ending.empty()) ending = "." + name_of(file.format);
    result.file = stem + ending;
    result.bytes = read_input_file(path, std::uint64_t{1} << 30U);
    return result;
  } catch (const InputError& error) {
    refusal = error.what();
  }
  constexpr double most_moved = 0.01;
  MeshRepairRequest repair;
  repair.file = path;
  const double diagonal = diagonal_of(file.soup);
  try {
    const MeshChange change = repaired(file.soup, repair);
    const double moved = std::max(change.old_to_new, change.new_to_old) / diagonal;
    if (!(moved <= most_moved)) {
      throw InputError(
          fmt::format("{}: a repair would move its surface by {:.2g} % of the diagonal", path.string(), 100 * moved));
    }
    std::string text = fmt::format("a graph refuses the mesh as it is ({}), so it was repaired:\n", refusal);
    for (const std::string& phrase : change.changes) text += "  " + phrase + "\n";
    text += moved_text(change, diagonal);
    if (!change.filled.empty()) {
      text += fmt::format(
          "  check whether the body should be solid where a hole was: the limit of {:g} % on the motion of the surface "
          "ignores the faces that fill holes\n",
          100 * most_moved);
    }
    text.pop_back();
    tell_note(text);
    result.solid = change.mesh;
    result.file = stem + "_repaired.off";
    result.bytes = mesh_text(change.mesh, MeshFormat::off);
    result.note = change.filled.empty()
                      ? "repaired: `tactor mesh repair` tells what changed"
                      : fmt::format("repaired, {:.2g} % of its surface fills holes: `tactor mesh repair` tells more",
                                    100 * change.filled_share);
    return result;
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}\n{}\ntry `tactor mesh repair {} --out {}.off` with other options", refusal,
                                 error.what(), path.string(), stem));
  }
}

/// What a unit of the file is, where that is not a metre; tells it.
std::optional<double> chosen_scale(const fs::path& file, double longest, const NewGraphRequest& request) {
  const std::optional<double> size = request.size;
  const auto rounded = [](double v) {
    const double step = std::pow(10, std::floor(std::log10(v)) - 3);
    return std::round(v / step) * step;
  };
  if (size) {
    tell_note(fmt::format("{}: scaled to {}, as --size says", file.string(), metres(*size)));
    return rounded(*size / longest);
  }
  if (request.unit) return request.unit;
  if (is_usual_size(longest)) return std::nullopt;
  if (is_usual_size(millimetre * longest)) {
    tell_note(fmt::format("{}: {:.4g} units long, taken as mm: the scene says scale: 0.001", file.string(), longest));
    return millimetre;
  }
  const double scale = rounded(usual_size / longest);
  tell_note(fmt::format(
      "{}: {:.4g} units long, which is no size for a hand in m or mm; the scene says scale: {:.6g}, so that it is {} "
      "long (--size or --unit chooses another)",
      file.string(), longest, scale, metres(scale * longest)));
  return scale;
}

/// The tenth of the body's depth that is farthest from where it is touched.
HalfSpaceRegion far_side(const TriangleMesh& body, const TouchPath& path) {
  constexpr double share = 0.1;
  Vec3 sum;
  for (const TouchPoint& point : path) sum += point.normal;
  const double length = norm(sum);
  const Vec3 n = length > 0.1 ? sum / length : path.front().normal;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Vec3& v : body.vertices) {
    low = std::min(low, dot(n, v));
    high = std::max(high, dot(n, v));
  }
  return {(low + share * (high - low)) * n, n};
}

/// The body in its place, and how the ball goes about it.
NewScene planned(const NewGraphRequest& request, const SceneMesh* mesh) {
  NewScene scene;
  scene.name = request.name;
  TriangleMesh body;
  if (mesh != nullptr) {
    scene.mesh = mesh->file;
    scene.mesh_note = mesh->note;
    body = mesh->solid;
    scene.scale = chosen_scale(*request.mesh, bounds_of(body).longest(), request);
    for (Vec3& v : body.vertices) v *= scene.scale.value_or(1);
    scene.p_WB = -bounds_of(body).middle();
    for (Vec3& v : body.vertices) v += scene.p_WB;
  } else {
    scene.box = request.size.value_or(usual_size) * Vec3{1, 0.6, 0.4};
    body = box_mesh(scene.box);
  }
  scene.longest = bounds_of(body).longest();
  // Tetrahedra are coarse: a ball that is smaller than one would feel single nodes.
  scene.radius = (request.young ? 2 : 1) * std::clamp(0.04 * scene.longest, 2e-4, 5e-3);
  scene.path = find_touch_path(body, scene.radius, 0.25 * scene.longest, 5);
  scene.young = request.young;
  if (scene.young) scene.held = far_side(body, scene.path);
  if (scene.path.size() == 1) tell_note("found no place to slide along: the ball presses in one place");
  return scene;
}

}  // namespace

void make_new_graph(const NewGraphRequest& request) {
  check_name(request.name);
  static_cast<void>(method_file(request.method));
  std::optional<SceneMesh> mesh;
  NewGraphRequest found = request;
  if (request.mesh) {
    found.mesh = named_file(*request.mesh, mesh_files);
    mesh = scene_mesh(*found.mesh);
  }
  const NewScene scene = planned(found, mesh ? &*mesh : nullptr);
  const fs::path folder = request.folder / request.name;
  std::vector<std::pair<fs::path, std::string>> files{{folder / "scene.yaml", scene_text(scene)}};
  if (mesh) files.emplace_back(folder / mesh->file, mesh->bytes);
  fs::path graph = folder / "scene.yaml";
  if (request.method != "off") {
    graph = folder / (request.method + ".yaml");
    files.emplace_back(graph, method_text(request.name, request.method));
  }
  for (const auto& [file, text] : files) {
    std::error_code ignored;
    if (found.mesh && fs::equivalent(file, *found.mesh, ignored)) {
      throw InputError(
          fmt::format("{}: expected another name or --in: the scene would replace the mesh itself", file.string()));
    }
    if (!request.overwrite && fs::exists(file, ignored)) {
      throw InputError(fmt::format(
          "{}: expected no such file yet, found one; --overwrite replaces it, another name keeps both", file.string()));
    }
  }
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw InputError(fmt::format("{}: cannot make this folder: {}", folder.string(), error.message()));
  for (const auto& [file, text] : files) write_file(file, text);
  fmt::print("{}\n", fmt::join(
                         [&] {
                           std::vector<std::string> names;
                           for (const auto& [file, text] : files) names.push_back(file.string());
                           return names;
                         }(),
                         "\n"));
  // Over the scene: a method of the user's own would be replaced.
  fmt::print(
      "\n    tactor run {0}\n    tactor view {0}\n    tactor view {1} --over side_by_side    # methods to switch\n",
      as_typed(graph.lexically_normal().string()), as_typed(files.front().first.lexically_normal().string()));
}

}  // namespace tactor
