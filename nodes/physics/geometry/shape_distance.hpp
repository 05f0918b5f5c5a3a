// The signed distance of a point to a sphere, a capsule, a box or a plane, in closed form.
#pragma once

#include <memory>

#include "framework/core/scene.hpp"
#include "nodes/physics/geometry/signed_distance.hpp"

namespace tactor {

/// Distance, nearest point and gradient of a shape that is no mesh, in the body's frame (see Shape). Where several
/// points of the surface are as near, the choice is fixed:
///   sphere   at the centre the point on +z;
///   capsule  on the axis the point towards +x;
///   box      inside, the face of the first axis, and of its two sides the positive one;
///   plane    has none.
/// `Nearest::face`: sphere and plane 0; capsule 0 its side, 1 the cap at +z, 2 that at -z; box 2 * axis + (1 on the
/// positive side), at an edge or a corner of the first axis there. `Nearest::of_face`: of a box's edge the axis that it
/// runs along, of a corner the sum of 1, 2, 4 for positive x, y, z. On the edges and corners of a box the gradient is
/// the mean of the normals that meet there.
/// The Hessian is (1 - n n^T) / |x| for a sphere, where x is the way from its centre, and likewise from the axis for a
/// capsule, less its share along the axis beside the segment; zero within 1e-12 m of centre or axis, where it has no
/// bound. For a box it is that of its edges and corners outside, and zero inside.
/// Throws InputError for a mesh, whose distance is made by MakeMeshDistance.
std::unique_ptr<SignedDistance> shape_distance(const Shape& shape);

}  // namespace tactor
