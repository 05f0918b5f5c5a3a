// Makes bunny.off: the Stanford bunny of CGAL's demo data, decimated and brought to metres.
#include <cstdio>
#include <filesystem>
#include <string>

#include "framework/core/check.hpp"
#include "meshes/bunny_size.hpp"
#include "meshes/decimate.hpp"
#include "meshes/write_off.hpp"
#include "nodes/physics/mesh/solid_file.hpp"

using namespace tactor;

namespace {

constexpr std::size_t face_count = 20990;

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) throw InputError("usage: make_bunny SOURCE.off OUTPUT.off");
  // What the solid is kept in stays in the build.
  const SolidFile source = load_solid(argv[1], std::filesystem::path(argv[2]).parent_path() / "cache");
  for (const std::string& repair : source.report.repairs) std::printf("%s: %s\n", argv[1], repair.c_str());
  TriangleMesh mesh = decimate(source.mesh, face_count, "bunny");
  bring_to_metres(mesh);
  write_off(argv[2], mesh, "Stanford bunny, Stanford Computer Graphics Laboratory; decimated; metres");
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "make_bunny: %s\n", e.what());
  return 1;
}
