// Writes meshes in every format, byte by byte, so that the readers meet files that no code of theirs has made.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "nodes/physics/mesh/mesh.hpp"
#include "nodes/physics/mesh/mesh_formats.hpp"

namespace tactor::test {

inline std::string number(double value) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.17g", value);
  return text.data();
}
inline std::string point(const Vec3& p) {
  return number(p.x) + " " + number(p.y) + " " + number(p.z);
}

inline std::string as_off(const TriangleMesh& mesh) {
  std::string text = "OFF\n" + std::to_string(mesh.vertices.size()) + " " + std::to_string(mesh.faces.size()) + " 0\n";
  for (const Vec3& v : mesh.vertices) text += point(v) + "\n";
  for (const auto& f : mesh.faces) {
    text += "3 " + std::to_string(f[0]) + " " + std::to_string(f[1]) + " " + std::to_string(f[2]) + "\n";
  }
  return text;
}

inline std::string as_obj(const TriangleMesh& mesh) {
  std::string text = "# a solid\nmtllib none.mtl\no solid\n";
  for (const Vec3& v : mesh.vertices) text += "v " + point(v) + "\n";
  text += "vn 0 0 1\ns off\n";
  for (const auto& f : mesh.faces) {
    text += "f";
    for (const int i : f) text += " " + std::to_string(i + 1) + "//1";
    text += "\n";
  }
  return text;
}

inline std::string as_ascii_stl(const TriangleMesh& mesh) {
  std::string text = "solid body\n";
  for (const auto& f : mesh.faces) {
    text += "  facet normal 0 0 0\n    outer loop\n";
    for (const int i : f) text += "      vertex " + point(mesh.vertices[static_cast<std::size_t>(i)]) + "\n";
    text += "    endloop\n  endfacet\n";
  }
  return text + "endsolid body\n";
}

/// The bytes of a number, lowest first, or highest first where `swapped`.
template <class T>
std::string bytes_of(T value, bool swapped = false) {
  static_assert(std::endian::native == std::endian::little);
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  return swapped ? std::string(bytes.rbegin(), bytes.rend()) : bytes;
}

inline std::string as_binary_stl(const TriangleMesh& mesh, const std::string& title = "a title") {
  std::string bytes = title + std::string(80 - title.size(), '\0');
  bytes += bytes_of(static_cast<std::uint32_t>(mesh.faces.size()));
  for (const auto& f : mesh.faces) {
    bytes += std::string(12, '\0');
    for (const int i : f) {
      const Vec3& v = mesh.vertices[static_cast<std::size_t>(i)];
      for (const double x : {v.x, v.y, v.z}) bytes += bytes_of(static_cast<float>(x));
    }
    bytes += std::string(2, '\0');
  }
  return bytes;
}

inline std::string ply_header(const TriangleMesh& mesh, const std::string& coding) {
  return "ply\nformat " + coding + " 1.0\ncomment a solid\nelement vertex " + std::to_string(mesh.vertices.size()) +
         "\nproperty double x\nproperty double y\nproperty double z\nproperty uchar red\nelement face " +
         std::to_string(mesh.faces.size()) + "\nproperty list uchar int vertex_indices\nend_header\n";
}

inline std::string as_ascii_ply(const TriangleMesh& mesh) {
  std::string text = ply_header(mesh, "ascii");
  for (const Vec3& v : mesh.vertices) text += point(v) + " 255\n";
  for (const auto& f : mesh.faces) {
    text += "3 " + std::to_string(f[0]) + " " + std::to_string(f[1]) + " " + std::to_string(f[2]) + "\n";
  }
  return text;
}

inline std::string as_binary_ply(const TriangleMesh& mesh, bool big_endian = false) {
  std::string bytes = ply_header(mesh, big_endian ? "binary_big_endian" : "binary_little_endian");
  for (const Vec3& v : mesh.vertices) {
    for (const double x : {v.x, v.y, v.z}) bytes += bytes_of(x, big_endian);
    bytes += '\xff';
  }
  for (const auto& f : mesh.faces) {
    bytes += '\3';
    for (const int i : f) bytes += bytes_of(static_cast<std::int32_t>(i), big_endian);
  }
  return bytes;
}

struct MeshFile {
  std::string name;
  std::string bytes;
};

/// The mesh in every format.
inline std::vector<MeshFile> in_every_format(const TriangleMesh& mesh) {
  return {{"a.off", as_off(mesh)},
          {"a.obj", as_obj(mesh)},
          {"ascii.stl", as_ascii_stl(mesh)},
          {"binary.stl", as_binary_stl(mesh)},
          {"solid.stl", as_binary_stl(mesh, "solid that is binary")},
          {"ascii.ply", as_ascii_ply(mesh)},
          {"little.ply", as_binary_ply(mesh)},
          {"big.ply", as_binary_ply(mesh, true)}};
}

inline PolygonSoup read_soup(const std::string& file, std::string_view bytes) {
  return read_mesh(file, mesh_format(file, bytes), bytes);
}

inline std::filesystem::path write(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

}  // namespace tactor::test
