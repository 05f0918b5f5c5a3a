#include "app/report/provenance_html.hpp"

#include <fmt/format.h>

#include "app/report/html_page.hpp"

namespace tactor {

std::string provenance_html(const Provenance& made) {
  if (made.empty()) return {};
  std::string html =
      fmt::format("<p>{}, on {} ({}, {}). Tactor {}, commit {}{}; {}, {}.</p>\n", made.date, escape(made.host.node),
                  escape(made.host.processor), escape(made.host.c_library), escape(made.version), escape(made.commit),
                  made.dirty ? " with changes that were not committed" : "", escape(made.compiler), escape(made.flags));
  constexpr std::size_t digits = 16;
  HtmlTable table({"file", "of", "SHA-256, first digits"});
  const auto add = [&table](const HashedFile& one) {
    table.add({breakable(one.file.string()), breakable(one.of), escape(one.sha256.substr(0, digits))});
  };
  for (const HashedFile& one : made.files) add(one);
  table.add_group("Program and libraries");
  for (const HashedFile& one : made.libraries) add(one);
  return folded("Provenance", html + table.html());
}

}  // namespace tactor
