// The contacts of a query as the contacts around the bodies, for physics that looks at one pose alone.
#pragma once

#include "framework/core/messages.hpp"
#include "nodes/physics/contact/local_contacts.hpp"

namespace tactor {

/// Sets `around` to the contacts of `set` at one anchor, where the bodies were for its query; of too many the nearest.
void take_told(const ContactSet& set, LocalContacts& around);

}  // namespace tactor
