// Objects that are expensive to make, shared by all libraries of the process.
#pragma once

#include <functional>
#include <memory>
#include <string>

namespace tactor {

/// The object of that key that somebody still holds, or else the result of `make`. The key must name the type as well.
/// Callers wait for each other, so use it when nodes are made and not in their steps.
std::shared_ptr<const void> shared_object(const std::string& key,
                                          const std::function<std::shared_ptr<const void>()>& make);

}  // namespace tactor
