// What a unit of a mesh file may be: the files do not say.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tactor {

inline constexpr double millimetre = 1e-3;  // m

/// Units by name, in m: what `--unit` takes.
const std::vector<std::pair<std::string, double>>& mesh_units();

/// Whether a body of that length (m) is one that a hand goes about: 20 mm to 0.5 m.
bool is_usual_size(double length);

/// The `scale` that a file whose body is `longest` units long needs in a graph: 0.001 where a graph refuses it in m and
/// it is of usual size in mm; absent where m will do, or mm would not either.
std::optional<double> guessed_scale(double longest);

}  // namespace tactor
