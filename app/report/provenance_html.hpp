// The provenance of a result as a part of its page.
#pragma once

#include <string>

#include "app/run/provenance.hpp"

namespace tactor {

/// A folded part of a page; empty for an empty provenance.
std::string provenance_html(const Provenance& provenance);

}  // namespace tactor
