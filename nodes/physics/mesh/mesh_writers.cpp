#include "nodes/physics/mesh/mesh_writers.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

/// The shortest text that reads as the same number.
void put_coordinate(std::string& text, double v) {
  std::array<char, 40> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), v).ptr;
  text.append(buffer.data(), end);
}

void put_point(std::string& text, const Vec3& p, const char* before) {
  text += before;
  put_coordinate(text, p.x);
  text += ' ';
  put_coordinate(text, p.y);
  text += ' ';
  put_coordinate(text, p.z);
  text += '\n';
}

void put_lists(std::string& text, const TriangleMesh& mesh, const char* point, const char* face, int first) {
  for (const Vec3& v : mesh.vertices) put_point(text, v, point);
  for (const auto& f : mesh.faces) {
    text += face;
    text +=
        std::to_string(f[0] + first) + ' ' + std::to_string(f[1] + first) + ' ' + std::to_string(f[2] + first) + '\n';
  }
}

std::string stl_text(const TriangleMesh& mesh) {
  std::string text = "solid mesh\n";
  for (const auto& f : mesh.faces) {
    const Vec3 n = doubled_area_normal(mesh, f);
    put_point(text, norm(n) > 0 ? n / norm(n) : Vec3{}, "facet normal ");
    text += "outer loop\n";
    for (const int corner : f) put_point(text, mesh.vertices[static_cast<std::size_t>(corner)], "vertex ");
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid mesh\n";
}

}  // namespace

MeshFormat format_of_ending(const std::string& file) {
  std::string ending = std::filesystem::path(file).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  if (ending == ".off") return MeshFormat::off;
  if (ending == ".obj") return MeshFormat::obj;
  if (ending == ".stl") return MeshFormat::stl;
  if (ending == ".ply") return MeshFormat::ply;
  throw InputError(file + ": expected a file name with the ending .off, .obj, .stl or .ply, found '" + ending + "'");
}

std::string name_of(MeshFormat format) {
  switch (format) {
    case MeshFormat::off:
      return "OFF";
    case MeshFormat::obj:
      return "OBJ";
    case MeshFormat::stl:
      return "STL";
    case MeshFormat::ply:
      return "PLY";
  }
  TACTOR_DEMAND(false);
}

std::string mesh_text(const TriangleMesh& mesh, MeshFormat format) {
  const std::string vertices = std::to_string(mesh.vertices.size()), faces = std::to_string(mesh.faces.size());
  std::string text;
  switch (format) {
    case MeshFormat::off:
      text = "OFF\n" + vertices + ' ' + faces + " 0\n";
      put_lists(text, mesh, "", "3 ", 0);
      return text;
    case MeshFormat::obj:
      put_lists(text, mesh, "v ", "f ", 1);
      return text;
    case MeshFormat::stl:
      return stl_text(mesh);
    case MeshFormat::ply:
      text = "ply\nformat ascii 1.0\nelement vertex " + vertices +
             "\nproperty double x\nproperty double y\nproperty double z\nelement face " + faces +
             "\nproperty list uchar int vertex_indices\nend_header\n";
      put_lists(text, mesh, "", "3 ", 0);
      return text;
  }
  TACTOR_DEMAND(false);
}

}  // namespace tactor
