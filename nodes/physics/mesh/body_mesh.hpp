// The shape and inertia of a scene's body, in the body's frame.
#pragma once

#include <Eigen/Core>

#include <string>
#include <vector>

#include "framework/core/scene.hpp"
#include "nodes/physics/mesh/mesh.hpp"

namespace tactor {

/// What a user should know of a body and nothing stops for: repairs, warnings, troubles of the cache.
using Notes = std::vector<std::string>;

/// `12.3 mm`, `1.5 m`.
std::string metres(double length);

/// What is to be said of a body of that length (m); both empty where it is usual. Faults of the unit are the commonest
/// of all and give forces that are wrong by powers of a thousand.
struct SizeVerdict {
  std::string refusal, warning;
};
SizeVerdict judge_size(double length, bool has_scale);

/// Adds a note where it is not there yet and `notes` is not null.
void add_once(Notes* notes, std::string note);

/// Refuses or notes the size of a body whose mesh is so long (m), as judge_size says, with the path of what decides it.
void check_body_size(const Body& body, double length, Notes* notes);

/// Loads the body's mesh as a solid (solid_file.hpp) and applies its scale. A moving body's frame has its origin at the
/// centre of mass of uniform density and keeps the axes of the file; a fixed or deformable body keeps the frame of the
/// file.
/// Adds to `notes`, each once, beginning with the name of the body, where it is not null.
/// Throws InputError, beginning with the name of the body, where the file describes no solid, or where the solid is
/// longer than 10 m or shorter than 1 mm and the body says no scale: the file is in another unit then. With a scale it
/// may be 1 um to 1 km long.
TriangleMesh load_body_mesh(const Body& body, Notes* notes = nullptr);

/// The inertia of a moving body about its centre of mass in its own frame, kg m^2: `Body::inertia` on the diagonal
/// where given, else that of its shape at uniform density.
/// Notes and InputError as for load_body_mesh.
Eigen::Matrix3d body_inertia(const Body& body, Notes* notes = nullptr);

}  // namespace tactor
