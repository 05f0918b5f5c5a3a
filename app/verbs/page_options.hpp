// Options of the verbs that open a page in the browser.
#pragma once

#include <cstdio>
#include <string>

#include "app/view/view_server.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace tactor {

/// --port, --foxglove, --allow-origin and --no-open.
struct PageOptions {
  ViewPorts ports;
  bool no_open = false;
  std::string foxglove_port;  ///< as it was given; see ports

  /// `needed`: not null where they are only for runs with that option.
  void add_to(CLI::App& verb, CLI::Option* needed = nullptr);
};

/// Prints the address of a page to `out` and opens it with the program that the desktop has for it, where there is a
/// desktop. `foxglove`: what a Foxglove viewer connects to, or empty.
void show_page(const PageOptions& options, const std::string& url, const std::string& foxglove,
               std::FILE* out = stdout);

}  // namespace tactor
