// Options of the verbs that open a page in the browser.
#pragma once

#include <cstdint>
#include <string>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace tactor {

/// --port and --no-open.
struct PageOptions {
  std::uint16_t port = 0;  ///< 0: any that is free
  bool no_open = false;

  /// `needed`: not null where both are only for runs with that option.
  void add_to(CLI::App& verb, CLI::Option* needed = nullptr);
};

/// Prints the address of a page and opens it with the program that the desktop has for it, where there is a desktop.
void show_page(const PageOptions& options, const std::string& url);

}  // namespace tactor
