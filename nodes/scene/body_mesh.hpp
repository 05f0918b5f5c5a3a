// The shape and inertia of a scene's body, in the body's frame.
#pragma once

#include <Eigen/Core>

#include "framework/core/scene.hpp"
#include "nodes/scene/mesh.hpp"

namespace tactor {

/// Reads the body's mesh and applies its scale. A moving body's frame has its origin at the centre of mass of uniform
/// density and keeps the axes of the file; a fixed body keeps the frame of the file.
/// Throws InputError where the file is no mesh or a moving body's mesh encloses no volume.
TriangleMesh load_body_mesh(const Body& body);

/// The inertia of a moving body about its centre of mass in its own frame, kg m^2: `Body::inertia` on the diagonal
/// where given, else that of its shape at uniform density.
/// Throws InputError as load_body_mesh does.
Eigen::Matrix3d body_inertia(const Body& body);

}  // namespace tactor
