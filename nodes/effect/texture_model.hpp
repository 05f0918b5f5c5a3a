// A surface's vibration under a tool that slides: auto-regressive models over speed and normal force, read from a file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "nodes/effect/lattice.hpp"

namespace tactor {

/// What a tool does at one speed and force.
struct TextureState {
  Reflection reflection;
  double deviation = 0;  ///< m/s^2, of the acceleration: the root of its variance
};

/// The file is YAML:
///   title: one line
///   rate: 1 kHz                       of the samples
///   models:                           one for each speed with each force, in any order
///     - {speed: 50 mm/s, force: 0.5 N, variance: 0.04, coefficients: [1.2, -0.7]}
/// A model is x_t = sum phi_i x_{t-i} + e_t, x the acceleration in m/s^2, with the coefficients phi and the variance of
/// e in (m/s^2)^2.
///
/// Between speeds and forces, reflection coefficients and the deviation of x are interpolated, linearly in each. So
/// every filter between stable ones is stable, because all their reflection coefficients lie inside (-1, 1). Beyond the
/// fastest and the strongest, theirs hold. Below the slowest and the weakest, theirs hold with a deviation in
/// proportion to speed and force, so that a tool that rests is quiet.
class TextureModel {
 public:
  /// Throws YamlError, with place and key, where the file is no such model: a filter that is not stable, a speed
  /// without a force that another speed has, ...
  static TextureModel read(const std::filesystem::path& file);
  /// The same of a text; `name` is that of the file in errors.
  static TextureModel parse(const std::string& text, const std::string& name);

  [[nodiscard]] TextureState at(double speed, double force) const;  ///< m/s, N
  [[nodiscard]] double rate() const { return rate_; }               ///< Hz
  [[nodiscard]] const std::vector<double>& speeds() const { return speeds_; }
  [[nodiscard]] const std::vector<double>& forces() const { return forces_; }

 private:
  friend class TextureReader;
  [[nodiscard]] const TextureState& node(std::size_t force, std::size_t speed) const {
    return nodes_[force * speeds_.size() + speed];
  }

  double rate_ = 0;
  std::vector<double> speeds_, forces_;  // rising
  std::vector<TextureState> nodes_;      // the speeds of the first force, then of the next
};

}  // namespace tactor
