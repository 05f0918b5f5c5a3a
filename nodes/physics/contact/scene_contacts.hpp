// The contacts of every two bodies of a scene that can meet.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "framework/core/messages.hpp"
#include "framework/node/node.hpp"
#include "nodes/physics/contact/body_pair.hpp"
#include "nodes/physics/contact/local_contacts.hpp"

namespace tactor {

struct ContactOptions {
  double margin = 0;   ///< m, distance below which contacts are reported before they touch
  double spacing = 0;  ///< m, between contact samples; 0: as the bodies suggest
  std::int32_t max_contacts = ContactSet::capacity;
  std::int32_t local_contacts = 24;  ///< contacts of find_ahead at most
  std::int32_t anchors = 3;          ///< poses that find_ahead looks at
  double anchor_time = 0;            ///< s, between them
};

/// Looks at each pair of a moving body with a fixed one and of two moving bodies, as BodyPair does, and never at two
/// fixed ones. A contact is reported where the distance is below `margin`, with the pair that it belongs to: the body
/// that comes first in Scene::moving() is the moving one, T of the contact, and its normal points to that body.
/// Contacts stand in the order of pairs, sides and samples; beyond `max_contacts` ContactReduction chooses.
class SceneContacts {
 public:
  /// Adds to `notes`, where that is not null, what makes contacts doubtful before anything has moved (doubts.hpp);
  /// `hand`: where the tool is led, null where nobody knows. Throws InputError where a mesh is no solid.
  SceneContacts(const Scene& scene, const ContactOptions& options, const MakeMeshDistance& make_distance,
                const HandPath* hand = nullptr, Notes* notes = nullptr);

  /// The contacts where the moving bodies are. Allocates nothing once it has met the most contacts, but for
  /// ExactDistance, whose search does.
  void find(const BodyStates& bodies, ContactSet& set);
  /// The same with at most `work` steps of work, of which SampleTree::find says what they are. False, and `set` is as
  /// it was, where that is not enough. `used`, where not null, is set to the work that it took.
  bool find_within(int work, const BodyStates& bodies, ContactSet& set, int* used = nullptr);
  /// From here on find_within with at most that work allocates nothing, but for ExactDistance.
  void reserve_within(int work);

  /// The contacts on the way that the bodies take from `age` s ago, where they were at `bodies`, if they keep their
  /// velocities. The anchors are where the bodies are by now, and where they will be `anchor_time` and twice that
  /// later. Every sample within the margin at one of them is a contact, looked up at all. Of more than
  /// `local_contacts`, ContactReduction chooses by the middle one.
  ///
  /// Where both bodies of a pair have samples, those of the body that keeps its samples in contact on this way count
  /// more than in `find`. So a box that slides over a larger one is known by its own samples: those of the larger one
  /// that it leaves, and those that it comes over, would be known too late. The pair's sum of weight times depth is
  /// that of `find` at each anchor.
  void find_ahead(const BodyStates& bodies, double age, LocalContacts& around);

 private:
  void tell_doubts(const Scene& scene, double spacing, const HandPath* hand, Notes& notes) const;
  [[nodiscard]] const Pose& pose(const BodyStates& bodies, std::int32_t index, std::size_t body) const;

  /// Fills found_; false where the work was not enough.
  bool look(const BodyStates& bodies, int* left);
  void keep(const BodyStates& bodies, ContactSet& set);

  struct Entry {
    std::size_t a, b;  // indices into bodies_
    BodyPair pair;
  };
  std::vector<ContactBody> bodies_;  // those that move first, in the order of Scene::moving()
  std::vector<Entry> pairs_;
  FoundContacts found_;
  ContactReduction reduction_;
  /// What find_ahead looked at.
  struct Anchor {
    BodyStates bodies;
    /// By pair: as `find` has them, and after prefer_lasting_sides as they count here, where they need not sum to 1.
    std::vector<BodyPair::Shares> shares;
  };
  /// A sample found at an anchor, of a pair that has samples on both sides.
  struct NearSample {
    std::uint64_t key;
    std::size_t anchor;
    double extent;  // weight * (margin - distance)
    double push;    // weight * (depth + a little of (margin - distance), for pairs that do not touch)
  };
  /// The samples of one side of a pair, over the anchors.
  struct SideAhead {
    double least = 0, most = 0;                             // sums of each sample's least and greatest extent
    std::array<double, LocalContacts::max_anchors> push{};  // sums over the samples, by anchor
    /// 1 where all samples stay as near as they are, 0 where none is near at all anchors.
    [[nodiscard]] double lasting() const { return most > 0 ? least / most : 0; }
  };
  void find_at(std::size_t j);
  void fill_shares();
  void look_at_sides();
  void prefer_lasting_sides();
  [[nodiscard]] bool counts(std::uint64_t key) const;
  [[nodiscard]] Contact contact_at(const Anchor& anchor, std::uint64_t key) const;
  [[nodiscard]] std::span<Anchor> anchors() { return std::span(anchors_).first(anchor_count_); }

  double margin_;  // m
  std::size_t anchor_count_;
  double anchor_time_;  // s
  std::array<Anchor, LocalContacts::max_anchors> anchors_;
  FoundContacts found_ahead_;                    // at one anchor
  std::vector<NearSample> near_;                 // at all anchors
  std::vector<std::array<SideAhead, 2>> ahead_;  // of either side, by pair
  std::vector<std::uint64_t> keys_;              // of all anchors, sorted
  FoundContacts around_;                         // at the middle one
  ContactReduction local_reduction_;
  ContactSet local_set_;
};

/// Whether a body of the scene has contact samples whose distances `spacing` sets: a box or a capsule that meets
/// another body, or a mesh that meets one that is no ball.
bool has_spaced_samples(const Scene& scene);

}  // namespace tactor
