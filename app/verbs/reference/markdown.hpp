// Pages of Markdown that read the same on a forge and through Sphinx: texts escaped, node types and pages linked.
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace tactor {

/// The pages by their paths in the folder of the reference: `nodes/sink.metrics.md`.
using Pages = std::map<std::string, std::string>;

/// Writes texts into one page.
class PageWriter {
 public:
  /// `path` of the page in the folder of the reference; `types`: the node types, which texts link to.
  PageWriter(std::string path, std::string title, const std::set<std::string>& types);

  void heading(int level, std::string_view text);
  /// Prose: every paragraph (between empty lines) is folded at 120 characters.
  void prose(std::string_view text);
  /// Markdown as it is, folded.
  void markdown(std::string_view text);
  void code(std::string_view language, std::string_view text);
  /// A table of cells that are Markdown already; a column without any text is left out.
  void table(const std::vector<std::string>& heads, const std::vector<std::vector<std::string>>& rows);
  void list(const std::vector<std::string>& items);

  /// A text as Markdown: what Markdown would take for a mark is escaped, `code` stays, node types are linked.
  [[nodiscard]] std::string text(std::string_view plain) const;
  /// A link from this page to another of the reference.
  [[nodiscard]] std::string link(std::string_view shown, const std::string& to) const;
  /// The way from this page to a path in the folder of the reference.
  [[nodiscard]] std::string path_to(const std::string& to) const;

  void put_into(Pages& pages) const;

 private:
  std::string path_;
  const std::set<std::string>& types_;
  std::string page_;
};

/// A text as code, `[0, 0, 0]`; empty where it is.
std::string code_span(std::string_view text);
/// The anchor of a heading, as forges and Sphinx make it: `mesh check` is `mesh-check`.
std::string anchor_of(std::string_view heading);

}  // namespace tactor
