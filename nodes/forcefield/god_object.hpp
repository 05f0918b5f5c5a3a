// A point, or a ball, that stays outside of the fixed bodies of a scene and as near to the handle as it can.
#pragma once

#include <array>
#include <limits>
#include <memory>
#include <vector>

#include "framework/core/scene.hpp"
#include "nodes/forcefield/ball_cast.hpp"
#include "nodes/forcefield/half_spaces.hpp"

namespace tactor {

/// The god-object, or virtual proxy, of haptic rendering: D. Ruspini, K. Kolarov, O. Khatib, "The haptic display of
/// complex graphical environments", 1997, and M. Ortega, S. Redon, S. Coquillart, "A Six Degree-of-Freedom God-Object
/// Method for Haptic Display of Rigid Bodies with Surface Properties", whose subject is its generalisation (known here
/// by their abstracts). The steps below are this project's own.
///
/// A move goes straight towards the handle until a surface is met. From then on the goal is the point nearest to the
/// handle that the planes met so far allow (HalfSpaces: of three at most the way is bounded), and so on until nothing
/// more is met. Then all planes are forgotten and met anew, because a plane ends where its surface does, until a round
/// moves the proxy by less than 0.1 um. In each part of the way the distance to the handle falls, and none of it leads
/// through a surface, whatever the handle did: it cannot get through a thin wall or between two faces.
///
/// Friction is Coulomb's: with x the goal on the planes, N = sum of pushes (m; times the stiffness the normal force)
/// and mu the planes' coefficients, the proxy stays where |x - p| <= sum mu_i push_i, which is the friction cone, and
/// else comes no nearer to x than that. So the handle may press and turn within the cone and nothing slips.
class GodObject {
 public:
  struct Options {
    double radius = 0;     ///< m, of the proxy; a point has `point_radius`
    bool friction = true;  ///< as the materials of tool and body have it
    double crease = 0;     ///< rad, see ball_surface
    int most_casts = 0;    ///< ways looked along in a move at most; the next move goes on
    int most_looks = 0;    ///< for those, see BallSurface::cast; where they are used up the next move goes on
  };
  /// A point is a ball so small that it makes no force that can be felt and so large that no rounding lets it through
  /// the edge between two faces.
  static constexpr double point_radius = 1e-7;

  /// Throws InputError where a mesh is no solid; `notes` as for load_body_mesh.
  GodObject(const Scene& scene, const Options& options, Notes* notes);

  /// The handle is at `goal` (m, in W, finite). The first move, and the next after `lost`, puts the proxy at the
  /// handle, or where that is inside of a body at the nearest place outside. Where several bodies overlap, more than
  /// one move may look for that; the proxy is lost until then.
  void move(const Vec3& goal);

  /// m, in W.
  [[nodiscard]] const Vec3& position() const { return p_; }
  /// No place outside has been found near the handle, where bodies overlap: nothing is known.
  [[nodiscard]] bool lost() const { return !placed_; }
  /// The planes that push at the end of the last move: 0 in the air.
  [[nodiscard]] int contacts() const { return contacts_; }
  /// m, the proxy less the handle: times the stiffness the force on the device. `shaded`: each plane pushes along the
  /// shaded normal of its surface by as much as before (H. Morgenbesser and M. Srinivasan, "Force Shading for Shape
  /// Perception in Haptic Virtual Environments", 1996); friction is not turned.
  [[nodiscard]] Vec3 stretch(bool shaded) const;
  /// m, the sum of the planes' pushes: times the stiffness the sum of the normal forces. Zero in the air.
  [[nodiscard]] double normal_stretch() const { return pushes_; }
  /// Unit, along the sum of the planes' pushes; zero in the air.
  [[nodiscard]] const Vec3& normal() const { return normal_; }

  [[nodiscard]] int casts() const { return casts_; }  ///< of the last move
  /// Faces and boxes about them that those looked at.
  [[nodiscard]] int looked() const { return options_.most_looks - looks_left_; }
  /// The last move ended because `most_looks` were used up.
  [[nodiscard]] bool starved() const { return starved_; }
  /// Nearest points that the last move asked of bodies to find a place: a few for each body at most.
  [[nodiscard]] int queries() const { return queries_; }

 private:
  struct FixedBody {
    Pose X_WB;
    double friction = 0;
    std::unique_ptr<BallSurface> surface;
  };
  struct Plane {
    Vec3 n, shaded;  // unit, in W
    double friction = 0;
  };

  void place(const Vec3& goal);
  bool slide(const Vec3& goal);
  bool cast(const Vec3& way, BallHit& hit, double& friction);
  bool keep_plane(const BallHit& hit, double friction);
  void settle(const Vec3& goal);

  Options options_;
  std::vector<FixedBody> bodies_;
  Vec3 p_, goal_;
  bool placed_ = false;
  Vec3 tried_;          // m, where the search for a place is
  int pushes_out_ = 0;  // of that search
  /// m, the longest way that is looked along: shorter after one for which the looks of a move were too few.
  double reach_ = std::numeric_limits<double>::infinity();
  bool starved_ = false;
  HalfSpaces spaces_;
  std::array<Plane, HalfSpaces::capacity> planes_;
  HalfSpaces::NearestAllowed allowed_;
  Vec3 turned_;  // m, what shading adds to the stretch
  Vec3 normal_;
  double pushes_ = 0;
  int contacts_ = 0, casts_ = 0, looks_left_ = 0, queries_ = 0;
};

}  // namespace tactor
