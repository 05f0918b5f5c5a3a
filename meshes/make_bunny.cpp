// Makes bunny.off: the Stanford bunny of CGAL's demo data, decimated and brought to metres.
#include <cstdio>
#include <fstream>

#include <CGAL/IO/OFF.h>

#include "framework/core/check.hpp"
#include "meshes/bunny_size.hpp"
#include "meshes/decimate.hpp"
#include "meshes/write_off.hpp"

using namespace tactor;

namespace {

constexpr std::size_t face_count = 20990;

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) throw InputError("usage: make_bunny SOURCE.off OUTPUT.off");
  Surface surface;
  std::ifstream in(argv[1]);
  if (!in || !CGAL::IO::read_OFF(in, surface)) throw InputError(std::string(argv[1]) + ": cannot be read as OFF");
  TriangleMesh mesh = decimate(surface, face_count, "bunny");
  bring_to_metres(mesh);
  write_off(argv[2], mesh, "Stanford bunny, Stanford Computer Graphics Laboratory; decimated; metres");
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "make_bunny: %s\n", e.what());
  return 1;
}
