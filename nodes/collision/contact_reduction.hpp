// Chooses the contacts that stand for all where a query finds more than a message holds.
#pragma once

#include <cstdint>
#include <vector>

#include "framework/core/messages.hpp"

namespace tactor {

/// What a query found, in parallel vectors.
struct FoundContacts {
  std::vector<Contact> contact;
  std::vector<ContactPair> pair;
  std::vector<std::uint64_t> key;  ///< what names a contact from query to query, each at most once

  void clear();
  void reserve(std::size_t most);
};

/// Keeps at most `max_contacts`, in the order in which they were found; all of them and unchanged where they are no
/// more.
///
/// Penetrating contacts come first. Where they alone are too many, they are picked one by one, each time the one of the
/// largest pressure (weight * depth) times squared distance from those already picked, so that they spread over the
/// patch; directions count as distance too, other pairs of bodies as infinite. Contacts kept last time count double
/// their distance, which holds the choice where little changes. What is left out gives its pressure to the nearest one
/// kept. Then the weights of each pair are changed by the least squares of relative changes that restores the force and
/// torque at rest of all that was found, so that the wrench does not depend on the choice; where a weight would have to
/// change by more than half, in a few smaller changes.
///
/// Contacts that do not touch yet carry no force. They fill the places that are left, the nearest to touching first,
/// and give nothing away: one that stood for many would strike hard where it alone touches.
class ContactReduction {
 public:
  /// `max_contacts`: from 1 to ContactSet::capacity. Queries of up to `most` contacts allocate nothing.
  ContactReduction(int max_contacts, std::size_t most);

  /// Sets `count`, `penetrating`, `truncated`, `contact` and `pair` of the set.
  void reduce(const FoundContacts& found, ContactSet& set);

 private:
  void pick_spread(const FoundContacts& found, std::size_t count);
  void pick_nearest(const FoundContacts& found, std::size_t count);
  void give_pressure(const FoundContacts& found, ContactSet& set);
  bool restore_wrench(const FoundContacts& found, ContactPair pair, ContactSet& set);
  [[nodiscard]] bool was_kept(std::uint64_t key) const;

  std::size_t max_contacts_;
  std::vector<std::uint64_t> last_keys_;           // sorted
  std::vector<std::size_t> penetrating_, others_;  // indices of what was found
  std::vector<std::size_t> kept_;                  // the same, sorted in the end
  // Of each penetrating contact while they are picked, filled up to whole eights: place and direction, what counts
  // against distance, squared distance from the nearest one picked, and that one.
  std::vector<float> place_[6];
  std::vector<float> importance_, apart_;
  std::vector<std::int32_t> pair_of_, nearest_;
};

}  // namespace tactor
