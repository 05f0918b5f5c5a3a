#include "framework/core/refusals.hpp"

namespace tactor {

// Here, so that all libraries of nodes share one type.
Refusing::~Refusing() = default;

}  // namespace tactor
