// One HTML file that replays a show without a server.
#pragma once

#include <string>

#include "app/view/show.hpp"

namespace tactor {

/// The page. Throws InputError where the build has no view.
std::string saved_page(const Show& show);

}  // namespace tactor
