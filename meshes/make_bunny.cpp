// Makes bunny.off: the Stanford bunny of CGAL's demo data, decimated and brought to metres.
#include <cstdio>

#include "framework/core/check.hpp"
#include "framework/core/input_file.hpp"
#include "meshes/bunny_size.hpp"
#include "meshes/decimate.hpp"
#include "meshes/write_off.hpp"
#include "nodes/scene/mesh_formats.hpp"
#include "nodes/scene/mesh_repair.hpp"

using namespace tactor;

namespace {

constexpr std::size_t face_count = 20990;
constexpr std::uint64_t most_bytes = std::uint64_t{100} << 20U;

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) throw InputError("usage: make_bunny SOURCE.off OUTPUT.off");
  MeshReport report;
  const TriangleMesh source = make_solid(read_off(argv[1], read_input_file(argv[1], most_bytes)), argv[1], report);
  for (const std::string& repair : report.repairs) std::printf("%s: %s\n", argv[1], repair.c_str());
  TriangleMesh mesh = decimate(source, face_count, "bunny");
  bring_to_metres(mesh);
  write_off(argv[2], mesh, "Stanford bunny, Stanford Computer Graphics Laboratory; decimated; metres");
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "make_bunny: %s\n", e.what());
  return 1;
}
