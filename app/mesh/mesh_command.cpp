#include "app/mesh/mesh_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/interruption.hpp"
#include "app/mesh/mesh_units.hpp"
#include "app/output.hpp"
#include "app/terminal.hpp"
#include "framework/core/check.hpp"
#include "framework/graph/text_table.hpp"
#include "framework/yaml/file_finder.hpp"
#include "nodes/physics/mesh/body_mesh.hpp"
#include "nodes/physics/mesh/bounds.hpp"
#include "nodes/physics/mesh/cgal_plugin.hpp"
#include "nodes/physics/mesh/make_solid.hpp"
#include "nodes/physics/mesh/mass_properties.hpp"
#include "nodes/physics/mesh/mesh_measures.hpp"
#include "nodes/physics/mesh/mesh_writers.hpp"
#include "nodes/physics/mesh/meshing_plugin.hpp"
#include "nodes/physics/mesh/solid_file.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::json;

/// What a graph would make of a mesh, or why it would refuse it.
struct Verdict {
  std::optional<TriangleMesh> solid;
  MeshReport report;
  std::string refusal;          ///< or empty
  std::optional<double> scale;  ///< that the graph has to give, or none
  std::string unit_note;        ///< where that was guessed, or empty
};

/// Reads a mesh, and lets go of the signals: checks and repairs do not look for them.
MeshFile read_to_work_on(const fs::path& path) {
  MeshFile file = read_mesh_file(path);
  stop_listening_for_interruption();
  return file;
}

Verdict judge(const MeshFile& file, const std::string& name, std::optional<double> scale) {
  Verdict verdict;
  try {
    verdict.solid = make_solid(file.soup, name, verdict.report);
  } catch (const InputError& error) {
    verdict.refusal = error.what() + repair_hint(verdict.report, name);
    return verdict;
  }
  const double longest = bounds_of(*verdict.solid).longest();
  verdict.scale = scale;
  if (!scale && (verdict.scale = guessed_scale(longest))) {
    verdict.unit_note = fmt::format("{:.4g} units long, taken as mm; --unit or --scale says otherwise", longest);
  }
  const SizeVerdict size = judge_size(verdict.scale.value_or(1) * longest, verdict.scale.has_value());
  if (!size.refusal.empty()) verdict.refusal = name + ": " + size.refusal;
  if (!size.warning.empty()) verdict.report.warnings.push_back(size.warning);
  return verdict;
}

void need_plugin(const char* verb) {
  static_cast<void>(load_cgal_plugin(std::string("tactor mesh ") + verb));
}

fs::path mesh_path(const fs::path& name) {
  return named_file(name, mesh_files);
}

std::string text_of(const Vec3& v) {
  return fmt::format("{:.6g}, {:.6g}, {:.6g}", v.x, v.y, v.z);
}

Json json_of(const Vec3& v) {
  return {v.x, v.y, v.z};
}

Json json_of(const Verdict& verdict) {
  return {{"accepted", verdict.refusal.empty()},
          {"refusal", verdict.refusal.empty() ? Json() : Json(verdict.refusal)},
          {"scale", verdict.scale ? Json(*verdict.scale) : Json()},
          {"repairs", verdict.report.repairs},
          {"warnings", verdict.report.warnings}};
}

/// Where nothing is refused: `a graph takes it with scale: 0.001 (80 units long, taken as mm; ...)`.
std::string acceptance_text(const Verdict& verdict) {
  std::string text = "a graph takes it";
  if (verdict.scale) text += fmt::format(" with scale: {:g}", *verdict.scale);
  return verdict.unit_note.empty() ? text : text + " (" + verdict.unit_note + ")";
}

std::string verdict_text(const std::string& name, const Verdict& verdict) {
  std::string text = name + ": ok, " + acceptance_text(verdict) + "\n";
  for (const std::string& repair : verdict.report.repairs) text += "  repaired while loading: " + repair + "\n";
  for (const std::string& warning : verdict.report.warnings) text += "  warning: " + warning + "\n";
  return text;
}

/// Where the result goes; refuses to replace the mesh itself.
fs::path result_file(const fs::path& file, const ResultsRequest& results) {
  if (!results.out) throw InputError("expected --out FILE, found no place for the new mesh");
  static_cast<void>(format_of_ending(results.out->string()));
  std::error_code ignored;
  if (fs::equivalent(file, *results.out, ignored)) {
    throw InputError(fmt::format("--out {}: expected a file other than the mesh itself", results.out->string()));
  }
  return results_file(*results.out, {}, results);
}

Json json_of(const MeshChange& change, double diagonal) {
  return {{"changes", change.changes},
          {"warnings", change.report.warnings},
          {"vertices", change.mesh.vertices.size()},
          {"faces", change.mesh.faces.size()},
          {"diagonal", diagonal},
          {"old_to_new", change.old_to_new},
          {"new_to_old", change.new_to_old},
          {"moved_of_diagonal", std::max(change.old_to_new, change.new_to_old) / diagonal},
          {"moved_error", change.moved_error},
          {"removed_faces", change.removed},
          {"inside_faces", change.inside},
          {"inside_share", change.inside_share},
          {"filled_faces", change.filled},
          {"filled_share", change.filled_share},
          {"volume_before", change.old_volume},
          {"volume_after", change.new_volume}};
}

void write_result(const MeshRequest& request, const fs::path& out, const MeshChange& change, double diagonal) {
  listen_for_interruption();
  write_file(out, mesh_text(change.mesh, format_of_ending(out.string())));
  if (request.json) {
    Json json = json_of(change, diagonal);
    json["file"] = request.file.string();
    json["out"] = out.string();
    fmt::print("{}\n", json.dump(2));
    return;
  }
  std::string text = fmt::format("{} -> {}\n", request.file.string(), out.string());
  if (change.changes.empty()) text += "  nothing needed a repair\n";
  for (const std::string& phrase : change.changes) text += "  " + phrase + "\n";
  text += moved_text(change, diagonal);
  for (const std::string& warning : change.report.warnings) text += "  warning: " + warning + "\n";
  fmt::print("{}", wrapped(text, terminal_columns()));
}

double in_units(const MeshLength& length, double diagonal) {
  return length.of_diagonal ? length.value * diagonal : length.value;
}

}  // namespace

double diagonal_of(const PolygonSoup& soup) {
  Bounds bounds;
  for (const auto& polygon : soup.polygons) {
    for (const std::size_t corner : polygon) bounds.add(soup.points[corner]);
  }
  return soup.polygons.empty() ? 0 : norm(bounds.size());
}

std::string moved_text(const MeshChange& change, double diagonal) {
  const auto share = [&](double length) {
    return fmt::format("{:.4g} ({:.2g} % of the diagonal)", length, 100 * length / diagonal);
  };
  std::vector<std::string> gone;
  if (!change.removed.empty()) gone.push_back(fmt::format("the {} removed", counted(change.removed.size(), "face")));
  if (!change.inside.empty()) {
    gone.push_back(fmt::format("the part that lies inside now, {:.3g} % of its area", 100 * change.inside_share));
  }
  const std::string but_gone = gone.empty() ? "" : fmt::format(", but for {},", fmt::join(gone, " and "));
  const std::string but_filled = change.filled.empty()
                                     ? ""
                                     : fmt::format(", but for the {} that fill holes, {:.3g} % of its area,",
                                                   counted(change.filled.size(), "face"), 100 * change.filled_share);
  std::string text = fmt::format("  the old surface{} is nowhere farther from the new one than {}\n", but_gone,
                                 share(change.old_to_new));
  text += fmt::format("  the new surface{} is nowhere farther from the old one than {}\n", but_filled,
                      share(change.new_to_old));
  const std::string growth =
      change.old_volume > 0 ? fmt::format(" ({:+.2g} %)", 100 * (change.new_volume / change.old_volume - 1)) : "";
  return text + fmt::format("  {} faces, volume {:.6g} before, {:.6g} after{}\n", change.mesh.faces.size(),
                            change.old_volume, change.new_volume, growth);
}

MeshChange repaired(const PolygonSoup& soup, const MeshRepairRequest& request) {
  const MeshingPlugin& plugin = load_meshing_plugin("the repair of " + request.file.string());
  const double diagonal = diagonal_of(soup);
  return plugin.reworked_solid(soup, request.file.string(),
                               {.merge = in_units(request.merge, diagonal),
                                .max_hole = in_units(request.max_hole, diagonal),
                                .sheets = request.sheets,
                                .wrap = request.wrap});
}

int check_mesh(const MeshCheckRequest& request) {
  need_plugin("check");
  const fs::path path = mesh_path(request.file);
  const Verdict verdict = judge(read_to_work_on(path), path.string(), request.scale);
  if (request.json) {
    Json json = json_of(verdict);
    json["file"] = path.string();
    fmt::print("{}\n", json.dump(2));
    return verdict.refusal.empty() ? 0 : 2;
  }
  if (!verdict.refusal.empty()) throw InputError(verdict.refusal);
  fmt::print("{}", wrapped(verdict_text(path.string(), verdict), terminal_columns()));
  return 0;
}

int repair_mesh(const MeshRepairRequest& request) {
  need_plugin("repair");
  MeshRepairRequest of_file = request;
  of_file.file = mesh_path(request.file);
  const fs::path out = result_file(of_file.file, request.results);
  const MeshFile file = read_to_work_on(of_file.file);
  write_result(of_file, out, repaired(file.soup, of_file), diagonal_of(file.soup));
  return 0;
}

int decimate_mesh(const MeshDecimateRequest& request) {
  need_plugin("decimate");
  const MeshingPlugin& plugin = load_meshing_plugin("tactor mesh decimate");
  const fs::path path = mesh_path(request.file);
  const fs::path out = result_file(path, request.results);
  MeshFile file = read_to_work_on(path);
  const double diagonal = diagonal_of(file.soup);
  MeshReport report;
  const TriangleMesh solid = make_solid(std::move(file.soup), path.string(), report);
  MeshChange change = plugin.decimated_solid(solid, static_cast<std::size_t>(request.faces), path.string());
  change.changes.insert(change.changes.begin(), report.repairs.begin(), report.repairs.end());
  write_result({path, request.json}, out, change, diagonal);
  return 0;
}

int show_mesh(const MeshRequest& request) {
  need_plugin("info");
  constexpr double density = 1000;  // kg/m^3
  const fs::path path = mesh_path(request.file);
  const MeshFile file = read_to_work_on(path);
  const MeshMeasures m = measures_of(file.soup);
  const Verdict verdict = judge(file, path.string(), std::nullopt);
  const bool closed = m.open_edges + m.shared_edges == 0 && m.faces > 0;
  const bool has_faces = m.faces > 0;
  if (request.json) {
    Json json = {{"file", path.string()},
                 {"format", name_of(file.format)},
                 {"vertices", m.vertices},
                 {"faces", m.faces},
                 {"pieces", m.pieces},
                 {"closed", closed},
                 {"open_edges", m.open_edges},
                 {"shared_edges", m.shared_edges},
                 {"area", m.area},
                 {"shortest_edge", m.shortest_edge},
                 {"longest_edge", m.longest_edge},
                 {"check", json_of(verdict)}};
    if (has_faces) json["bounds"] = {json_of(m.bounds.low), json_of(m.bounds.high)};
    if (verdict.solid) {
      const MassProperties mass = mass_properties(*verdict.solid);
      json["volume"] = mass.volume;
      json["center"] = json_of(mass.center);
      json["mass_at_1000"] = density * mass.volume;
      for (int i = 0; i < 3; ++i) {
        json["inertia_at_1000"].push_back(
            {density * mass.inertia(i, 0), density * mass.inertia(i, 1), density * mass.inertia(i, 2)});
      }
    }
    fmt::print("{}\n", json.dump(2));
    return 0;
  }
  std::string text = fmt::format("{}: {}, {}, {}\n", path.string(), name_of(file.format), counted(m.vertices, "vertex"),
                                 counted(m.faces, "face"));
  if (has_faces) {
    text += fmt::format("  bounds    ({}) to ({})\n", text_of(m.bounds.low), text_of(m.bounds.high));
    text += fmt::format("  size      {} units: {} long where a unit is a metre, {} with scale: 0.001\n",
                        text_of(m.bounds.size()), metres(m.bounds.longest()), metres(1e-3 * m.bounds.longest()));
    text += fmt::format(
        "  surface   {}, {}, area {:.6g}, edges {:.3g} to {:.3g} long\n", counted(m.pieces, "piece"),
        closed ? "closed"
               : fmt::format("{} of one face, {} of more than two", counted(m.open_edges, "edge"), m.shared_edges),
        m.area, m.shortest_edge, m.longest_edge);
  }
  if (verdict.solid) {
    const MassProperties mass = mass_properties(*verdict.solid);
    text += fmt::format("  solid     volume {:.6g}, centre of mass ({})\n", mass.volume, text_of(mass.center));
    text += fmt::format("  mass      {:.4g} kg at 1000 kg/m^3 where a unit is a metre, {:.4g} kg with scale: 0.001\n",
                        density * mass.volume, 1e-9 * density * mass.volume);
    text += fmt::format("  inertia   xx {:.4g}, yy {:.4g}, zz {:.4g} kg m^2 about it, at that density in metres\n",
                        density * mass.inertia(0, 0), density * mass.inertia(1, 1), density * mass.inertia(2, 2));
  }
  text += verdict.refusal.empty() ? "  " + acceptance_text(verdict) + "\n"
                                  : "  a graph refuses it: " + verdict.refusal + "\n";
  for (const std::string& repair : verdict.report.repairs) text += "  repaired while loading: " + repair + "\n";
  for (const std::string& warning : verdict.report.warnings) text += "  warning: " + warning + "\n";
  fmt::print("{}", wrapped(text, terminal_columns()));
  return 0;
}

}  // namespace tactor
