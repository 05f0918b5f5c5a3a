#include "nodes/physics/contact/told_contacts.hpp"

#include <algorithm>
#include <numeric>
#include <span>

namespace tactor {

void take_told(const ContactSet& set, LocalContacts& around) {
  const auto count = static_cast<std::size_t>(std::clamp(set.count, 0, ContactSet::capacity));
  const std::size_t kept = std::min<std::size_t>(count, LocalContacts::capacity);
  std::array<std::size_t, ContactSet::capacity> order;
  const std::span all(order.data(), count);
  std::iota(all.begin(), all.end(), std::size_t{0});
  if (kept < count) {
    std::nth_element(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(kept), all.end(),
                     [&](std::size_t a, std::size_t b) {
                       const double at_a = set.contact[a].distance, at_b = set.contact[b].distance;
                       return at_a != at_b ? at_a < at_b : a < b;
                     });
    std::sort(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(kept));
  }
  around.anchors = 1;
  around.bodies = set.bodies.count;
  around.count = static_cast<std::int32_t>(kept);
  around.X_WB[0] = set.bodies.X_WB;
  for (std::size_t i = 0; i < kept; ++i) {
    around.contact[i][0] = set.contact[order[i]];
    around.pair[i] = set.pair[order[i]];
  }
}

}  // namespace tactor
