// The contacts of two bodies, at least one of which moves.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "framework/core/messages.hpp"
#include "nodes/physics/contact/contact_body.hpp"
#include "nodes/physics/contact/contact_reduction.hpp"
#include "nodes/physics/geometry/sample_tree.hpp"

namespace tactor {

/// Samples of either body against the other's signed distance. Which side has samples depends on the shapes alone, not
/// on the order of the bodies:
///   sphere with any      the sphere's centre, whose distance less the radius is exact: one contact of weight 1;
///   capsule with others  the capsule's balls;
///   all else             both bodies' samples (a plane has none): capsule with capsule, boxes and meshes.
/// The weight of a sample is its area over the patch area of the material, as far as it faces the other body
/// (area_facing), which lies against the contact's normal where the sample is of a, along it where it is of b; or what
/// ContactSamples counts. So a box that lies on a face is pushed by the area of that face, and a sample of a wall that
/// is nearest to a side of the box pushes nothing: it makes no contact. Where both sides have samples,
///   weight = share * weight of the sample,
/// with shares that sum to 1, in proportion to (1 + c) e of a and (1 - c) e of b, where e = sum(weight * (margin -
/// distance)) over the samples of the side, and c = lean + (1 - |lean|) preference. They change continuously as samples
/// come and go.
///
/// The finer side is preferred. A sample of a large triangle stands for more than a small tool covers, and is below it
/// or is not. With A the mean weight of a side's samples (each counts by its part of e) and f = A_b / A_a,
///   preference = (f^3 - 1) / (f^3 + 1)
/// as far as the finer side is as deep as the other: all of it where its deepest sample lacks at most a quarter of the
/// other's depth and 25 um, none where it lacks three times as much. The error that the coarse side then leaves in a
/// face of n fine samples is of the order of 1 / (f n^2).
///
/// Where a small face lies on a large one, the samples of the small one end where the contact does, and their areas sum
/// to what it has. Those of the large one below it have the area of a few more or less, as it lies. So the shares lean
/// to the side that has the rim:
///   lean = (r_a^3 / (r_a^3 + (r_b / f)^3 + l^3) - r_b^3 / (r_b^3 + (r_a f)^3 + l^3)) * likeness,
/// r being the part of e that samples at edges and corners have, and l = 0.005 (e_a + e_b). They lean to a side only as
/// far as that one pushes all that the other does, so that no push of one side alone is lost: for a that leads, the
/// likeness is 1 up to
///   |c f_a - f_b| / (p_a + p_b) + |c t_a - t_b| / (s (p_a + p_b)) = 0.3
/// and 0 from 0.5 on, where f (N) is the sum of the springs' forces over the contacts of a side, p (N) that of their
/// sizes, t (N m) the torque about the middle of all contacts, and s (m) how far they spread about it (root mean
/// square). c is p_b / p_a where a pushes more and a fiftieth of that or more is pushed by its rim, less so below that,
/// else 1: the samples of b below the rim push nothing once they are nearer to a side of a than to its face.
/// Where no sample is at an edge or corner, as between round meshes, lean is 0.
///
/// A pair whose bounding spheres are farther apart than the margin is not looked at. Where neither body rotates no
/// rotation between them is computed.
class BodyPair {
 public:
  struct Shares {
    double a = 0, b = 0;
  };

  /// `a` moves; both must outlive the pair. `indices`: of the bodies in Scene::moving(); `number`: one for each pair of
  /// a node, which its contacts' keys begin with; margin in m.
  BodyPair(const ContactBody& a, const ContactBody& b, ContactPair indices, std::uint32_t number, double margin);

  [[nodiscard]] ContactPair indices() const { return indices_; }

  /// Adds the contacts at these poses nearer than the margin, those of a's samples first, in the order of SampleTree.
  /// `left`: as of SampleTree::find; where it goes below zero, none of this pair are added.
  void find(const Pose& X_WA, const Pose& X_WB, FoundContacts& found, int* left = nullptr);
  /// As of SampleTree: queries of at most `work` steps allocate nothing from here on, but for what they add to `found`.
  /// Returns how many contacts such a query adds at most.
  std::size_t reserve_within(int work);
  /// The shares of both sides in the last `find` (above); zero where it found nothing.
  [[nodiscard]] Shares shares() const { return shares_; }
  /// Whether both sides have samples.
  [[nodiscard]] bool has_two_sides() const { return side_a_ && side_b_; }
  /// The contact of that key (see contact_key) at these poses, however far away, with the weight that shares give it.
  [[nodiscard]] Contact at(std::uint64_t key, const Pose& X_WA, const Pose& X_WB, const Shares& shares) const;

 private:
  /// A ball's centre against the other's distance.
  struct Ball {
    double radius;  // m
    Nearest last;   // at `asked_at`, where `asked`
    Vec3 asked_at;  // m, in the frame of the other body
    bool asked = false;
  };
  [[nodiscard]] double weight(const Contact& contact, bool from_b, std::size_t sample, const Quat& R_WK) const;
  [[nodiscard]] bool may_meet(const Pose& X_WA, const Pose& X_WB) const;
  void find_ball(const Pose& X_WA, const Pose& X_WB, FoundContacts& found);
  void add(Contact contact, double weight, bool from_b, std::size_t sample, FoundContacts& found) const;
  [[nodiscard]] Contact of_a(const Pose& X_WA, const Pose& X_WB, const Vec3& p_A, double radius,
                             const Nearest& n) const;
  [[nodiscard]] Contact of_b(const Pose& X_WA, const Pose& X_WB, const Vec3& p_B, double radius,
                             const Nearest& n) const;
  [[nodiscard]] std::array<double, 6> curvature(bool from_b, const Pose& X_WA, const Pose& X_WB, const Nearest& n,
                                                const Vec3& x) const;

  const ContactBody& a_;
  const ContactBody& b_;
  ContactPair indices_;
  std::uint64_t number_;
  double margin_;      // m
  Material material_;  // of both
  std::optional<Ball> ball_;
  bool ball_is_a_ = false;
  Shares shares_;
  std::optional<SampleTree> side_a_, side_b_;  // of one body's samples against the other's distance
  std::optional<Quat> R_BA_;                   // where neither rotates
  std::optional<Vec3> p_WM_of_b_;              // m, where it is fixed
};

}  // namespace tactor
