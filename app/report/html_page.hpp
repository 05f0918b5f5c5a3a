// The frame of every report: one HTML file that needs nothing else.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "framework/node/info.hpp"

namespace tactor {

/// The text with what HTML gives a meaning replaced.
std::string escape(std::string_view text);

/// `escape` of a name that may break behind each of its parts.
std::string breakable(std::string_view name);

/// What the metric is, its unit and which direction is better: `RMS error against the reference, N; lower is better`.
std::string definition(const MetricInfo& metric);

/// `html`, with the definition of the metric under the pointer and the keyboard's focus; as it is where `metric` is
/// null.
std::string defined(const std::string& html, const MetricInfo* metric);

/// A part of a page that is folded until it is asked for; empty where `html` is.
std::string folded(const std::string& summary, const std::string& html);

/// A table whose rows become blocks on a narrow screen. All texts are HTML.
class HtmlTable {
 public:
  explicit HtmlTable(std::vector<std::string> heads) : heads_(std::move(heads)) {}

  /// The first cell names the row. As many cells as heads.
  void add(const std::vector<std::string>& cells);
  /// A line over the whole width.
  void add_group(const std::string& text);
  /// The columns behind the first one are equally wide.
  void make_even() { even_ = true; }
  [[nodiscard]] std::string html() const;

 private:
  std::vector<std::string> heads_;
  std::string rows_;
  bool even_ = false;
};

/// A page of that title with its style, and its script where it has charts; `body` is HTML.
std::string page(const std::string& title, const std::string& body);

}  // namespace tactor
