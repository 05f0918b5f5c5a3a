#include "nodes/physics/mesh/body_volume.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <numbers>
#include <string>

#include "framework/core/check.hpp"
#include "framework/core/input_file.hpp"
#include "framework/core/value_error.hpp"
#include "nodes/physics/mesh/bounds.hpp"
#include "nodes/physics/mesh/box_volume.hpp"
#include "nodes/physics/mesh/filled_surface.hpp"
#include "nodes/physics/mesh/mass_properties.hpp"
#include "nodes/physics/mesh/tet_quality.hpp"
#include "nodes/physics/mesh/tet_topology.hpp"
#include "nodes/physics/mesh/volume_formats.hpp"

namespace tactor {

namespace {

constexpr double most_tetrahedra = 200'000;

[[noreturn]] void refuse(const Body& body, const std::string& key, const std::string& what) {
  throw ValueError("scene.bodies." + body.name + "." + key, "body '" + body.name + "': " + what);
}

std::string text_of(const char* format, double value) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

/// `3,012`.
std::string count_text(std::size_t n) {
  std::string text = std::to_string(n);
  for (auto at = static_cast<std::ptrdiff_t>(text.size()) - 3; at > 0; at -= 3) {
    text.insert(static_cast<std::size_t>(at), ",");
  }
  return text;
}

std::string point_text(const Vec3& p) {
  return "(" + text_of("%.4g", p.x) + ", " + text_of("%.4g", p.y) + ", " + text_of("%.4g", p.z) + ")";
}

Bounds bounds_of_nodes(const TetMesh& mesh) {
  Bounds bounds;
  for (const Vec3& p : mesh.nodes) bounds.add(p);
  return bounds;
}

std::string where_it_lies(const TetMesh& mesh) {
  const Bounds bounds = bounds_of_nodes(mesh);
  return "the body lies between " + point_text(bounds.low) + " and " + point_text(bounds.high) + " m of its own frame";
}

/// Refuses what would take minutes to make and no physics computes in time.
void check_count(const Body& body, double count) {
  if (count <= most_tetrahedra) return;
  const double edge = body.deformable.cell_size * std::cbrt(count / 3000);
  if (body.deformable.cell_size > 0) {
    refuse(body, "cell_size",
           "cells of " + metres(body.deformable.cell_size) + " are about " + text_of("%.3g", count) +
               " tetrahedra; at most 200,000 are made. " + metres(edge) + " gives about 3,000");
  }
  refuse(body, "tetrahedra",
         text_of("%.0f", count) + " tetrahedra; at most 200,000 are made. A few thousand are usual");
}

VolumeFineness fineness_of(const Body& body) {
  const Deformable& d = body.deformable;
  if (!(d.cell_size >= 0)) refuse(body, "cell_size", "expected a length above zero, found " + metres(d.cell_size));
  if (d.cell_size == 0 && d.tetrahedra < 1) {
    refuse(body, "tetrahedra", "expected a number above zero, found " + std::to_string(d.tetrahedra));
  }
  VolumeFineness fineness;
  fineness.edge = d.cell_size;
  if (d.cell_size == 0) {
    check_count(body, d.tetrahedra);
    fineness.tetrahedra = static_cast<std::size_t>(d.tetrahedra);
  }
  return fineness;
}

TetMesh box_of(const Body& body, const BoxShape& box) {
  const std::array<std::size_t, 3> cells = box_cells(box.size, fineness_of(body));
  check_count(body,
              5.0 * static_cast<double>(cells[0]) * static_cast<double>(cells[1]) * static_cast<double>(cells[2]));
  return box_volume(box.size, cells);
}

std::string volume_text(double volume, double surface_volume) {
  const double percent = 100 * (volume / surface_volume - 1);
  return "volume " + text_of("%.1f", std::abs(percent)) + " % " + (percent < 0 ? "below" : "above") +
         " that of its surface";
}

/// What a user should know of the mesh. `surface_volume`: of what was filled, m^3; 0 where nothing was.
void note_quality(const Body& body, const TetMesh& mesh, double surface_volume, Notes* notes) {
  constexpr double bad_angle = 5 * std::numbers::pi / 180, bad_ratio = 0.05, bad_volume = 0.05;
  const std::string name = "body '" + body.name + "': ";
  const TetQuality quality = quality_of(mesh);
  std::string note = name + count_text(mesh.tets.size()) + " tetrahedra, " + count_text(mesh.nodes.size()) +
                     " nodes, edges of " + metres(quality.mean_edge) + ", smallest dihedral angle " +
                     text_of("%.0f", quality.smallest_angle * 180 / std::numbers::pi) + " deg, worst radius ratio " +
                     text_of("%.2g", quality.worst_ratio);
  if (surface_volume > 0) note += ", " + volume_text(quality.volume, surface_volume);
  add_once(notes, note);
  if (quality.smallest_angle < bad_angle || quality.worst_ratio < bad_ratio) {
    add_once(notes, name +
                        "warning: some tetrahedra are nearly flat; they make the body stiff and the solution slow. "
                        "Use another number of tetrahedra, or mesh the file anew");
  }
  if (surface_volume > 0 && std::abs(quality.volume / surface_volume - 1) > bad_volume) {
    add_once(notes, name + "warning: the tetrahedra are too coarse for this shape; ask for more of them");
  }
  if (const std::size_t pieces = pieces_of(mesh); pieces > 1) {
    add_once(notes, name + "warning: the tetrahedra are in " + count_text(pieces) +
                        " unconnected pieces; a piece without a fixed node falls or flies off");
  }
}

/// Says how far the count is from what was asked for, where the shape did not allow it.
void note_count(const Body& body, const TetMesh& mesh, Notes* notes) {
  const Deformable& d = body.deformable;
  constexpr double usual = 0.12;
  const auto count = static_cast<double>(mesh.tets.size());
  if (d.cell_size > 0 || std::abs(count / d.tetrahedra - 1) <= usual) return;
  add_once(notes, "body '" + body.name + "': " + count_text(mesh.tets.size()) + " tetrahedra and not the " +
                      count_text(static_cast<std::size_t>(d.tetrahedra)) + " asked for, because of the shape");
}

/// Brain has some 500 Pa.
void note_softness(const Body& body, Notes* notes) {
  constexpr double softest = 100;  // Pa
  const double young = body.deformable.young;
  if (young >= softest) return;
  add_once(notes, "body '" + body.name + "': warning: young is " + text_of("%.3g", young) +
                      " Pa, softer than any tissue; a bare number is in Pa, write kPa if you mean that");
}

TetMesh fill(const Body& body, Notes* notes) {
  const TriangleMesh surface = load_body_mesh(body, notes);
  const VolumeFineness fineness = fineness_of(body);
  const double volume = mass_properties(surface).volume;
  if (fineness.edge > 0) {
    check_count(body, 6 * std::numbers::sqrt2 * volume / (fineness.edge * fineness.edge * fineness.edge));
  }
  std::vector<std::string> troubles;
  TetMesh mesh = [&] {
    try {
      return filled_surface(surface, fineness, body.mesh()->file.string(), troubles);
    } catch (const InputError& error) {
      refuse(body, "mesh", error.what());
    }
  }();
  for (std::string& note : troubles) add_once(notes, std::move(note));
  // Another body than the surface shows.
  constexpr double least_part = 0.75;
  if (const double part = quality_of(mesh).volume / volume; part < least_part) {
    refuse(body, body.deformable.cell_size > 0 ? "cell_size" : "tetrahedra",
           text_of("so few tetrahedra fill %.0f", 100 * part) +
               text_of(" %% of its volume, and %.0f", 100 * least_part) +
               " % are needed; ask for more of them (a smaller cell_size)");
  }
  note_quality(body, mesh, volume, notes);
  note_count(body, mesh, notes);
  return mesh;
}

TetMesh read(const Body& body, Notes* notes) {
  constexpr std::uint64_t most_bytes = std::uint64_t{1} << 30U;
  const std::filesystem::path& path = body.mesh()->file;
  VolumeSoup soup;
  TetMesh mesh = [&] {
    try {
      return within_memory(path, [&] {
        soup = read_volume(path.string(), volume_format(path.string()), read_input_file(path, most_bytes));
        for (Vec3& p : soup.nodes) p *= body.mesh()->scale.value_or(1);
        return make_volume(soup, path.string());
      });
    } catch (const InputError& error) {
      refuse(body, "mesh", error.what());
    }
  }();
  check_body_size(body, bounds_of_nodes(mesh).longest(), notes);
  for (const std::string& note : soup.notes)
    add_once(notes, "body '" + body.name + "': " + path.string() + ": " + note);
  note_quality(body, mesh, 0, notes);
  return mesh;
}

TetMesh mesh_of(const Body& body, Notes* notes) {
  if (const auto* box = std::get_if<BoxShape>(&body.shape)) {
    TetMesh mesh = box_of(body, *box);
    note_quality(body, mesh, 0, notes);
    note_count(body, mesh, notes);
    return mesh;
  }
  if (body.mesh() != nullptr) return is_volume_file(body.mesh()->file.string()) ? read(body, notes) : fill(body, notes);
  const bool is_ball = std::holds_alternative<SphereShape>(body.shape);
  const std::string shape = is_ball ? "sphere" : std::holds_alternative<CapsuleShape>(body.shape) ? "capsule" : "plane";
  refuse(body, shape, "a " + shape + " is not filled with tetrahedra; a deformable body is a mesh or a box");
}

/// Whether a region holds a point, which may lie `slack` outside.
struct Holds {
  Vec3 p;
  double slack;
  bool operator()(const BoxRegion& box) const {
    for (int axis = 0; axis < 3; ++axis) {
      if (p[axis] < box.low[axis] - slack || p[axis] > box.high[axis] + slack) return false;
    }
    return true;
  }
  bool operator()(const HalfSpaceRegion& half) const { return dot(half.n, p - half.p) <= slack * norm(half.n); }
  bool operator()(const NamedFaces& /*faces*/) const { return false; }
};

std::string region_text(const FixedRegion& region) {
  if (const auto* box = std::get_if<BoxRegion>(&region)) {
    return "the box between " + point_text(box->low) + " and " + point_text(box->high);
  }
  if (const auto* half = std::get_if<HalfSpaceRegion>(&region)) {
    return "the half-space behind " + point_text(half->p) + " with the normal " + point_text(half->n);
  }
  return "the faces '" + std::get<NamedFaces>(region).name + "'";
}

const FaceGroup& named_group(const Body& body, const TetMesh& mesh, const std::string& name) {
  for (const FaceGroup& group : mesh.groups) {
    if (group.name == name) return group;
  }
  std::string names;
  for (const FaceGroup& group : mesh.groups) names += (names.empty() ? "'" : ", '") + group.name + "'";
  refuse(body, "fixed",
         "it has no faces named '" + name + "'; " +
             (names.empty() ? "its mesh names none: write box or behind, or use a .msh file "
                              "with a physical group of faces"
                            : "its mesh has " + names));
}

std::vector<char> fixed_nodes(const Body& body, const TetMesh& mesh) {
  std::vector<char> fixed(mesh.nodes.size(), 0);
  const double slack = 1e-6 * bounds_of_nodes(mesh).longest();
  for (const FixedRegion& region : body.deformable.fixed) {
    bool holds_any = false;
    if (const auto* faces = std::get_if<NamedFaces>(&region)) {
      for (const auto& face : named_group(body, mesh, faces->name).faces) {
        for (const int node : face) fixed[static_cast<std::size_t>(node)] = 1;
      }
      holds_any = true;
    }
    for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
      if (!std::visit(Holds{mesh.nodes[i], slack}, region)) continue;
      fixed[i] = 1;
      holds_any = true;
    }
    if (!holds_any) refuse(body, "fixed", region_text(region) + " holds no node of it; " + where_it_lies(mesh));
  }
  if (std::find(fixed.begin(), fixed.end(), 0) == fixed.end()) {
    refuse(body, "fixed", "the regions hold all its nodes, so nothing could deform; " + where_it_lies(mesh));
  }
  return fixed;
}

std::vector<double> stiffnesses(const Body& body, const TetMesh& mesh) {
  std::vector<double> young(mesh.tets.size(), body.deformable.young);
  for (const Inclusion& inclusion : body.deformable.inclusions) {
    bool holds_any = false;
    for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
      const TetCorners c = corners_of(mesh, mesh.tets[t]);
      if (norm(0.25 * (c[0] + c[1] + c[2] + c[3]) - inclusion.p) > inclusion.radius) continue;
      young[t] = inclusion.young;
      holds_any = true;
    }
    if (!holds_any) {
      refuse(body, "inclusions",
             "the ball of radius " + metres(inclusion.radius) + " about " + point_text(inclusion.p) +
                 " contains no centroid of a tetrahedron; the edges are about " + metres(quality_of(mesh).mean_edge) +
                 " long; " + where_it_lies(mesh) + "; move the inclusion, or use smaller tetrahedra");
    }
  }
  return young;
}

}  // namespace

BodyVolume load_body_volume(const Body& body, Notes* notes) {
  TACTOR_DEMAND(body.motion == Motion::deformable);
  BodyVolume volume;
  note_softness(body, notes);
  volume.mesh = mesh_of(body, notes);
  volume.young = stiffnesses(body, volume.mesh);
  volume.fixed = fixed_nodes(body, volume.mesh);
  return volume;
}

TriangleMesh load_body_surface(const Body& body, Notes* notes) {
  return body.motion == Motion::deformable ? surface_of(mesh_of(body, notes)) : load_body_mesh(body, notes);
}

}  // namespace tactor
