#include "devices/simulated/cogging.hpp"

#include <cmath>
#include <numbers>

namespace tactor {

Cogging::Cogging(const CoggingParameters& parameters)
    : amplitude_(parameters.force), wave_number_(2 * std::numbers::pi / parameters.period) {}

Vec3 Cogging::force(const Vec3& p_WD) const noexcept {
  if (!acts()) return {};
  const auto along = [this](double x) { return -amplitude_ * std::sin(wave_number_ * x); };
  return {along(p_WD.x), along(p_WD.y), along(p_WD.z)};
}

double Cogging::energy(const Vec3& p_WD) const noexcept {
  return -amplitude_ / wave_number_ *
         (std::cos(wave_number_ * p_WD.x) + std::cos(wave_number_ * p_WD.y) + std::cos(wave_number_ * p_WD.z));
}

}  // namespace tactor
