// Chooses the contacts that stand for all where a query finds more than a message holds.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "framework/core/messages.hpp"

namespace tactor {

/// Names a contact: the number of its pair of bodies (all of a pair's contacts have one material), which of the two
/// has the sample, and the sample.
constexpr std::uint64_t contact_key(std::uint64_t pair, bool from_b, std::uint64_t sample) {
  return pair << 40U | static_cast<std::uint64_t>(from_b) << 39U | sample;
}
constexpr std::uint64_t pair_number(std::uint64_t key) {
  return key >> 40U;
}
constexpr bool is_from_b(std::uint64_t key) {
  return (key >> 39U & 1U) != 0;
}
constexpr std::uint64_t sample_of(std::uint64_t key) {
  return key & ((std::uint64_t{1} << 39U) - 1);
}

/// What a query found, in parallel vectors.
struct FoundContacts {
  std::vector<Contact> contact;
  std::vector<ContactPair> pair;
  /// What names a contact from query to query, each at most once; see contact_key. Those of a pair stand together.
  std::vector<std::uint64_t> key;

  void clear();
  /// Keeps the first `count` of them.
  void shorten(std::size_t count);
  void reserve(std::size_t most);
};

/// Keeps at most `max_contacts`, in the order in which they were found; all of them and unchanged where they are no
/// more.
///
/// Penetrating contacts come first. Where they are too many beside those places of the others, they are picked one by
/// one, each time the one of the largest force at rest (weight * stiffness * depth) times squared distance from those
/// already picked, so that they spread over the patch; directions count as distance too, other pairs of bodies as
/// infinite. Contacts kept last time count double their distance, which holds the choice where little changes. What is
/// left out gives its force to the nearest one kept. Then the weights of each pair are changed by the least squares of
/// relative changes that restores the force and torque at rest of all that was found, so that the wrench does not
/// depend on the choice; where a weight would have to change by more than half, in a few smaller changes. It takes some
/// contacts a pair to make up six numbers: with fewer the force is the nearest that they can make.
///
/// Contacts that do not touch yet carry no force. They fill the places that are left, the nearest to touching first. Up
/// to a quarter of the places is kept for them: else a body that rebounds from a wall within a period would meet
/// nothing on the other side. Where that takes places from penetrating contacts, they too are picked so that they
/// spread, those near to touching before others, and each left out gives the nearest one kept its weight, less where it
/// is farther from touching: in proportion to the distances.
class ContactReduction {
 public:
  /// `max_contacts`: from 4 to ContactSet::capacity. Queries of up to `most` contacts allocate nothing.
  ContactReduction(int max_contacts, std::size_t most);
  /// From here on queries of up to `most` contacts allocate nothing.
  void reserve(std::size_t most);

  /// Sets `count`, `penetrating`, `truncated`, `contact` and `pair` of the set.
  void reduce(const FoundContacts& found, ContactSet& set);
  /// The indices of those that were kept, in the order of the set.
  [[nodiscard]] const std::vector<std::size_t>& kept() const { return kept_; }

 private:
  void pick_spread(const FoundContacts& found, const std::vector<std::size_t>& of, std::size_t count);
  void pick_nearest(const FoundContacts& found, std::size_t count);
  void give(const FoundContacts& found, ContactSet& set) const;
  bool restore_wrench(const FoundContacts& found, std::uint64_t pair, ContactSet& set);
  [[nodiscard]] bool was_kept(std::uint64_t key) const;

  std::size_t max_contacts_;
  std::vector<std::uint64_t> last_keys_;                    // sorted
  std::vector<std::size_t> penetrating_, others_;           // indices of what was found
  std::vector<std::size_t> kept_;                           // the same, sorted in the end
  std::vector<std::pair<std::size_t, std::size_t>> gifts_;  // the same: who is left out, and who stands for it
  // Of each contact that may be picked, filled up to whole eights: place and direction, what counts against distance,
  // squared distance from the nearest one picked, and that one.
  std::vector<float> place_[6];
  std::vector<float> importance_, apart_;
  std::vector<std::int32_t> pair_of_, nearest_;
};

}  // namespace tactor
