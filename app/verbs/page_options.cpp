#include "app/verbs/page_options.hpp"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "app/verbs/value_types.hpp"

namespace tactor {

namespace {

void open_in_browser(const std::string& url) {
  if (std::getenv("DISPLAY") == nullptr && std::getenv("WAYLAND_DISPLAY") == nullptr) return;
  std::string program = "xdg-open", address = url;
  char* arguments[] = {program.data(), address.data(), nullptr};
  pid_t child = 0;
  if (posix_spawnp(&child, program.c_str(), nullptr, nullptr, arguments, environ) != 0) return;
  std::thread([child] { waitpid(child, nullptr, 0); }).detach();
}

/// Empty for an origin as browsers send it: a scheme, and a host with or without a port.
std::string origin_trouble(const std::string& text) {
  const std::size_t scheme = text.find("://");
  const bool has_host = text == "file://" || (scheme != std::string::npos && text.size() > scheme + 3);
  const bool is_origin = scheme != std::string::npos && scheme > 0 && has_host &&
                         text.find_first_of("/?#*,", scheme + 3) == std::string::npos &&
                         std::all_of(text.begin(), text.end(), [](char c) { return c > ' ' && c <= '~'; });
  if (is_origin) return {};
  return "expected an origin such as https://app.foxglove.dev or http://localhost:8080, found " + text;
}

}  // namespace

void PageOptions::add_to(CLI::App& verb, CLI::Option* needed) {
  CLI::Option* at =
      verb.add_option("--port", ports.page, "Port of the page (default: any free port)")->type_name(value_type::port);
  CLI::Option* closed = verb.add_flag("--no-open", no_open, "Print the address of the page without opening it");
  // A text: CLI11 takes numbers behind flags for counts, and checks none of them.
  CLI::Option* foxglove =
      verb.add_flag("--foxglove{8765}", foxglove_port,
                    "Also serve scene, frames and curves to Foxglove and Lichtblick, on port 8765 or --foxglove=PORT")
          ->type_name(value_type::port)
          ->check(CLI::Range(0, 65535).description(""))
          ->each([this](const std::string& given) { ports.foxglove = static_cast<std::uint16_t>(std::stoi(given)); });
  // The protocol has no password: who may read is decided by where a page comes from.
  CLI::Option* allowed =
      verb.add_option("--allow-origin", ports.allowed_origins,
                      "Let pages of this origin read the stream for Foxglove, such as https://app.foxglove.dev; may be "
                      "repeated")
          ->type_name(value_type::origin)
          ->allow_extra_args(false)
          ->check(CLI::Validator(origin_trouble, ""))
          ->needs(foxglove);
  if (needed == nullptr) return;
  at->needs(needed);
  allowed->needs(needed);
  foxglove->needs(needed);
  closed->needs(needed);
}

void show_page(const PageOptions& options, const std::string& url, const std::string& foxglove, std::FILE* out) {
  fmt::print(out, "  {}\n", url);
  if (!foxglove.empty()) fmt::print(out, "  {} for Foxglove: Open connection, Foxglove WebSocket\n", foxglove);
  fmt::print(out, "  Ctrl-C ends it\n");
  std::fflush(out);
  if (!options.no_open) open_in_browser(url);
}

}  // namespace tactor
