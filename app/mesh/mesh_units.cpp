#include "app/mesh/mesh_units.hpp"

#include "nodes/physics/mesh/body_mesh.hpp"

namespace tactor {

const std::vector<std::pair<std::string, double>>& mesh_units() {
  static const std::vector<std::pair<std::string, double>> units{
      {"m", 1}, {"cm", 1e-2}, {"mm", millimetre}, {"um", 1e-6}, {"in", 0.0254}};
  return units;
}

bool is_usual_size(double length) {
  constexpr double least = 0.02, most = 0.5;
  return length >= least && length <= most;
}

std::optional<double> guessed_scale(double longest) {
  if (judge_size(longest, false).refusal.empty() || !is_usual_size(millimetre * longest)) return std::nullopt;
  return millimetre;
}

}  // namespace tactor
