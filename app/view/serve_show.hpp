// Serves a show to pages until somebody ends it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "app/view/show.hpp"

namespace tactor {

/// `opened` is called with the address of the page; `stop_asked` is asked about ten times a second. Throws InputError
/// where the port is taken or the build has no view.
void serve_show(Show show, std::uint16_t port, const std::function<void(const std::string& url)>& opened,
                const std::function<bool()>& stop_asked);

}  // namespace tactor
