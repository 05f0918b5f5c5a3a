// Objects that are dear to make, one of each in the process, whichever library asks for them.
#pragma once

#include <functional>
#include <memory>
#include <string>

namespace tactor {

/// The object of that key that somebody holds, or else what `make` makes. A key must tell the type as well. Callers
/// wait for each other, so it is for the making of nodes and not for their steps.
std::shared_ptr<const void> shared_object(const std::string& key,
                                          const std::function<std::shared_ptr<const void>()>& make);

}  // namespace tactor
