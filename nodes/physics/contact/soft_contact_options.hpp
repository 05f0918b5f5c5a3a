// How contacts with deforming surfaces are found.
#pragma once

#include <cstdint>

#include "framework/core/messages.hpp"

namespace tactor {

/// What SoftContacts is told, and the nodes' parameters of the same names.
struct SoftContactOptions {
  double soft_margin = 0.002;  ///< m, distance below which contacts are found before they touch
  double soft_spacing = 0;     ///< m, between samples of the surface; 0: by the rigid body's shape
  std::int32_t soft_contacts = ContactSet::capacity;  ///< 4 to ContactSet::capacity; of more, some stand for all
  std::int32_t soft_work = 20'000;                    ///< steps of work of SoftContacts::find_on
};

}  // namespace tactor
