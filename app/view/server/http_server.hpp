// The server of the view, over HTTP and WebSocket.
#pragma once

#include <memory>

#include "app/view/view_server.hpp"

namespace tactor {

/// `ViewLibrary::serve`.
std::unique_ptr<ViewServer> make_http_server(ViewSource& source, const ViewPorts& ports);

/// The program of the page, made while building.
std::span<const ViewFile> view_files();

}  // namespace tactor
