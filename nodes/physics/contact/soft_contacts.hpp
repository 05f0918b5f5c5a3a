// The contacts of rigid bodies with surfaces that deform.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "framework/core/messages.hpp"
#include "nodes/physics/contact/contact_body.hpp"
#include "nodes/physics/contact/contact_reduction.hpp"
#include "nodes/physics/contact/soft_contact.hpp"
#include "nodes/physics/contact/soft_contact_options.hpp"
#include "nodes/physics/contact/soft_samples.hpp"
#include "nodes/physics/contact/soft_surface.hpp"

namespace tactor {

/// The faces of all deformable bodies, counter-clockwise as seen from outside.
struct SoftSurface {
  std::vector<std::array<std::int32_t, 3>> faces;  ///< nodes, counted through all bodies
  std::vector<std::int32_t> body;                  ///< of each face: index in Scene::deformable()
  std::vector<double> area;                        ///< m^2 of each face, at rest
};

/// What pushes:
///
/// Samples of the surface. Each stands for an area of the surface at rest, and its weight is area / patch area of the
/// combined material. So the pressure is (stiffness / patch area) * depth, however fine the faces are. A face of area
/// a at rest is cut into n^2 triangles of equal areas, whose middles are the samples:
///   n = ceil(4/3 sqrt(a) / spacing), at most 64.
/// Neighbours are no farther apart than the spacing on faces whose medians are no longer than 2 sqrt(a). n goes by the
/// area at rest, so it does not change as the face deforms.
/// Only the samples in the rigid body's box and the margin about it are made. Where no spacing is given it is a third
/// of the radius of a ball or a capsule and a sixteenth of the longest side of a box or a mesh; a fixed body meets at
/// least three samples of a face. The rigid body's signed distance phi at the sample x gives
///   distance = phi(x),   n_W = -grad phi(x),   p_TC = the nearest point of the rigid body,   p_WC = x.
/// A sample counts less where its face does not face the rigid body: the weight is multiplied by
///   clamp(4 dot(n_W, normal of the face), 0, 1).
/// Else the far side of a thin body, or a surface that a body has sunk in by more than half, would pull it inwards.
///
/// Deep balls. A sphere, or a ball of a capsule (see shape_samples), whose centre c is nearer to the surface than a
/// quarter of its radius r, or inside, is also pushed by one contact with the nearest point p of the surface:
///   n_W = the mean normal about p, out of the surface,   distance = dot(n_W, c - p) - r,   p_TC = c - r n_W,
///   weight = that of the ball * max(1, r^2 / patch area) * clamp(1 - 4 d / r, 0, 1),
/// d being the signed distance of c to the surface. The samples' push fades as the centre comes near the surface (that
/// of a flat surface is pi stiffness / patch area * (r - depth) depth^2); this one grows in its place. The mean normal
/// is that of MovingSurface over r, or over three times the root of the mean area of the faces where that is less: the
/// force turns continuously as p goes from face to face.
///
/// Samples of boxes and meshes. Where they are nearer to the surface than the margin, or inside, each makes a contact
/// with the nearest point of the surface, with a mean normal over an eighth of the body's longest side, likewise. Its
/// weight is its area over the patch area, as far as it faces the surface (area_facing). The
/// body's samples and the surface's share the contact in proportion to
///   e = sum(weight * (margin - signed distance)),
/// as BodyPair has it, so that both together count once, and it stays continuous as samples come and go.
///
/// Sign: see MovingSurface. A point beyond the rim of an open surface makes none of the deep contacts.
/// Faces, poses and areas that are no numbers make no contacts, and every number of a contact is finite.
/// Contacts stand in the order of the rigid bodies (those that move first), then of the deformable ones. Same input
/// after the same calls: the same bytes.
class SoftContacts {
 public:
  /// Takes each body of the scene that is not deformable. Throws InputError where a mesh is no solid or the options are
  /// out of bounds. `notes` as for load_body_mesh.
  SoftContacts(const Scene& scene, const SoftContactOptions& options, const MakeMeshDistance& make_distance,
               Notes* notes = nullptr);

  /// Takes the whole surface, before the first `find`. `nodes_at_rest`: m, in W, as many as `find` is given.
  void set_surface(SoftSurface surface, std::span<const Vec3> nodes_at_rest);
  /// Sets `found` to the contacts of all rigid bodies, with the nodes at nodes_W (m). Of more than soft_contacts
  /// ContactReduction chooses. Allocates nothing once it has met the most contacts.
  void find(std::span<const Vec3> nodes_W, const BodyStates& bodies, std::vector<SoftContact>& found);

  /// The contacts of the tool alone with a few faces, at most 96 of them over at most 48 nodes, which need not be those
  /// of the last call: the surface ends where they do. `body`, `areas`: of each face, as in SoftSurface.
  /// SoftContact::node counts in nodes_W. What it finds is what `find` would find of these faces. False, and none are
  /// found, where it takes more than `soft_work` steps: looks at a face or a box of them, at a row of samples, at a
  /// sample, or at a leaf of the tree of faces. Allocates nothing where `found` has room for soft_contacts.
  bool find_on(std::span<const std::array<std::int32_t, 3>> faces, std::span<const std::int32_t> body,
               std::span<const double> areas, std::span<const Vec3> nodes_W, const Pose& X_WT,
               std::vector<SoftContact>& found);
  static constexpr std::size_t most_patch_faces = 96, most_patch_nodes = 48;

  /// Bodies of the scene that deform.
  [[nodiscard]] int deformable() const { return static_cast<int>(deformable_); }
  /// Steps of work that the last find_on took.
  [[nodiscard]] int work() const { return work_; }

 private:
  struct Rigid {
    ContactBody body;
    std::int32_t index;              // in Scene::moving(), or ContactPair::fixed
    double spacing;                  // m, of the surface's samples; 0: none
    int least_parts;                 // of a face
    std::vector<Material> material;  // with each deformable body
    SoftSampleTree samples;          // of boxes and meshes
  };
  /// A face in the frame of a rigid body: a corner, the ways to the others and the normal; m, unit.
  struct TurnedFace {
    std::int32_t face;
    Vec3 a, ab, ac, facing;
  };
  /// Where on the surface a contact is.
  struct Spot {
    std::int32_t face;
    std::array<double, 3> share;
  };
  /// A sample of a face.
  struct FaceSample {
    Vec3 p_T, facing;  // m; unit, the normal of the face, in the frame of the rigid body
    Spot spot;
    double weight;      // where the face faces the body
    std::uint64_t key;  // of the face and the sample
  };
  /// Samples that are looked at together.
  struct FaceSamples {
    std::array<FaceSample, 8> sample;
    Points8 points{};
    std::size_t count = 0;
    std::int32_t hint = -1;  // the face of the rigid body that was nearest last
  };
  /// One surface and what was found on it.
  struct Side {
    explicit Side(const SoftContactOptions& options, std::size_t most);
    MovingSurface surface;
    std::span<const std::int32_t> body;
    std::span<const double> area;
    std::vector<std::int32_t> near;        // faces
    std::vector<NearSoftSample> own;       // samples of the rigid body
    std::vector<SoftSampleMemory> memory;  // of each rigid body
    FoundContacts contacts, sorted;
    std::vector<Spot> spots, sorted_spots;
    std::vector<std::size_t> order;
    ContactReduction reduction;
    std::vector<std::array<double, 2>> extents;  // of each deformable body: e of the surface's and the body's samples
    double smoothing = 0;                        // m, how far normals of faces are averaged at most
    std::int32_t last_face = -1;                 // that was nearest to a ball
    int* left = nullptr;                         // steps of work, or null
    [[nodiscard]] bool over() const { return left != nullptr && *left < 0; }
    void work() const {
      if (left != nullptr) --*left;
    }
  };
  void look(Rigid& rigid, std::size_t number, const Pose& X_WT, Side& side);
  void look_at_faces(const Rigid& rigid, std::size_t number, const Pose& X_WT, Side& side);
  void look_at_face(const Rigid& rigid, std::size_t number, const Pose& X_WT, const Bounds& box,
                    const TurnedFace& turned, FaceSamples& samples, Side& side);
  void look_at_face_samples(const Rigid& rigid, std::size_t number, const Pose& X_WT, FaceSamples& samples, Side& side);
  void look_at_balls(Rigid& rigid, std::size_t number, const Pose& X_WT, Side& side);
  void look_at_samples(Rigid& rigid, std::size_t number, const Pose& X_WT, Side& side);
  void share_out(std::size_t first, Side& side) const;
  void add(const Contact& contact, const Rigid& rigid, std::size_t number, bool of_rigid, std::uint64_t sample,
           const Spot& spot, Side& side) const;
  void keep(Side& side, std::vector<SoftContact>& found);

  double margin_;  // m
  int most_work_, work_ = 0;
  std::size_t deformable_;     // bodies
  std::vector<Rigid> bodies_;  // those that move first
  SoftSurface whole_;
  Side all_, patch_;
  std::size_t patch_nodes_ = 0;  // of the last find_on
  std::unique_ptr<ContactSet> set_;
};

}  // namespace tactor
