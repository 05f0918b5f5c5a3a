// A ball that moves along a straight way, and the first place at which it meets the surface of a fixed body.
#pragma once

#include <memory>

#include "framework/core/scene.hpp"
#include "nodes/physics/geometry/signed_distance.hpp"
#include "nodes/physics/mesh/body_mesh.hpp"

namespace tactor {

/// The first contact of a moving ball with a surface, in the frame of the body or in W, as the function says.
struct BallHit {
  double share = 1;  ///< of the way, 0 to 1
  bool met = false;
  Vec3 n;             ///< unit, from the surface towards the ball's centre
  double within = 0;  ///< m, by how much the ball reaches into the surface there: rounding, where it touched before
  Vec3 shaded;        ///< unit, the normal that the surface is shaded with there
};

/// The surface of a solid, in the body's frame. Nothing of it allocates once it is made.
class BallSurface {
 public:
  virtual ~BallSurface() = default;

  /// Moves a ball of `radius` > 0 (m), whose centre is outside of the solid, from `from` along `way` (m). Where it
  /// meets the surface before `hit.share`, `hit` becomes that place. A place that it does not approach does not count:
  /// a ball that slides along a plane or leaves it meets nothing. One that touches already and approaches meets at 0.
  /// Each face, and each box about eight of them or of their boxes, is a look. They are taken off `looks`; where these
  /// are used up before it is known what is met, the result is false, and `hit` says nothing.
  virtual bool cast(const Vec3& from, const Vec3& way, double radius, BallHit& hit, int& looks) const = 0;

  /// The nearest surface point of x (m). Where it lies on an edge that only one face has (see ball_surface), all faces
  /// are looked at to tell inside from outside.
  [[nodiscard]] virtual Nearest nearest(const Vec3& x) const = 0;
};

/// The surface of a body: of a mesh its faces, edges and corners, which a ball meets at a distance of its radius; a box
/// is a mesh of twelve faces; sphere, capsule and plane are met in closed form.
/// `crease` (rad): faces that meet at a larger angle are not shaded into each other. A corner's normal is the mean of
/// those of its faces, weighted by their angles there, that are within the crease of the face; between the corners of a
/// face it is interpolated linearly and normalised, as colours are in graphics. What is met at an edge or a corner that
/// is a crease, and all but meshes, has n for its shaded normal.
/// Throws InputError where the mesh is no solid; `notes` as for load_body_mesh.
std::unique_ptr<BallSurface> ball_surface(const Body& body, double crease, Notes* notes);

/// The same of a mesh. A face whose height is less than 1e-9 of its longest edge, or that has no area, has no direction
/// and is left out; what a ball meets there are the edges of its neighbours, which are creases then. Throws InputError
/// where no face is left.
std::unique_ptr<BallSurface> ball_surface(TriangleMesh mesh, double crease);

}  // namespace tactor
