#include "nodes/physics/deformable/soft_body.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

/// Three digits.
std::string rounded(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", value);
  return text.data();
}

/// What is wrong with a tetrahedron, or nothing.
std::string fault_of(const TetMesh& mesh, std::size_t number) {
  const std::array<int, 4>& tet = mesh.tets[number];
  for (const int node : tet) {
    if (node < 0 || static_cast<std::size_t>(node) >= mesh.nodes.size()) {
      return "names node " + std::to_string(node) + "; expected 0 to " + std::to_string(mesh.nodes.size() - 1);
    }
  }
  const auto at = [&](std::size_t corner) { return mesh.nodes[static_cast<std::size_t>(tet[corner])]; };
  double longest = 0;
  for (std::size_t a = 0; a < 4; ++a) {
    for (std::size_t b = 0; b < a; ++b) longest = std::max(longest, norm(at(a) - at(b)));
  }
  const double volume = dot(at(1) - at(0), cross(at(2) - at(0), at(3) - at(0))) / 6;
  if (volume > 1e-9 * longest * longest * longest) return {};
  return "has a volume of " + rounded(volume) + " m^3 with an edge of " + rounded(longest) +
         " m; expected a mesh without flat or inverted tetrahedra";
}

}  // namespace

void check_soft_body(const SoftBody& body, std::size_t number) {
  const auto refuse = [&](const std::string& what) {
    throw InputError("deformable body " + std::to_string(number) + ": " + what);
  };
  const std::size_t tets = body.mesh.tets.size(), nodes = body.mesh.nodes.size();
  if (tets == 0) refuse("expected a mesh of tetrahedra, found none");
  if (body.young.size() != tets) {
    refuse("expected Young's modulus of each of " + std::to_string(tets) + " tetrahedra, found " +
           std::to_string(body.young.size()));
  }
  if (body.fixed.size() != nodes) {
    refuse("expected of each of " + std::to_string(nodes) + " nodes whether it is fixed, found " +
           std::to_string(body.fixed.size()));
  }
  if (!(body.poisson > -1 && body.poisson < 0.5)) {
    refuse("expected Poisson's ratio above -1 and below 0.5, found " + rounded(body.poisson));
  }
  if (!(body.density > 0 && std::isfinite(body.density))) {
    refuse("expected a density above 0 kg/m^3, found " + rounded(body.density));
  }
  for (std::size_t t = 0; t < tets; ++t) {
    if (!(body.young[t] > 0 && std::isfinite(body.young[t]))) {
      refuse("expected Young's modulus of tetrahedron " + std::to_string(t) + " above 0 Pa, found " +
             rounded(body.young[t]));
    }
    if (const std::string fault = fault_of(body.mesh, t); !fault.empty())
      refuse("tetrahedron " + std::to_string(t) + " " + fault);
  }
}

}  // namespace tactor
