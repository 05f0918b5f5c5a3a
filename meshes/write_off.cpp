#include "meshes/write_off.hpp"

#include <fstream>
#include <limits>

#include "framework/core/check.hpp"

namespace tactor {

void write_off(const std::filesystem::path& path, const TriangleMesh& mesh, const std::string& comment) {
  std::ofstream out(path);
  out.precision(std::numeric_limits<double>::max_digits10);
  out << "OFF\n# " << comment << '\n' << mesh.vertices.size() << ' ' << mesh.faces.size() << " 0\n";
  for (const Vec3& v : mesh.vertices) out << v.x << ' ' << v.y << ' ' << v.z << '\n';
  for (const auto& f : mesh.faces) out << "3 " << f[0] << ' ' << f[1] << ' ' << f[2] << '\n';
  out.close();
  if (!out) throw RunError(path.string() + ": cannot be written");
}

}  // namespace tactor
