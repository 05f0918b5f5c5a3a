#include "app/report/html_page.hpp"

#include <fmt/format.h>

#include "app/report/page_files.hpp"
#include "app/run/run_metrics.hpp"
#include "framework/core/check.hpp"

namespace tactor {

std::string escape(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string breakable(std::string_view name) {
  std::string out;
  for (const char c : escape(name)) {
    out += c;
    if (c == '_' || c == '.' || c == '=' || c == '/') out += "<wbr>";
  }
  return out;
}

std::string definition(const MetricInfo& metric) {
  const std::string unit = unit_text(metric.unit);
  const std::string better = better_text(metric.better);
  return metric.doc + (unit.empty() ? "" : ", " + unit) + (better.empty() ? "" : "; " + better + " is better");
}

std::string defined(const std::string& html, const MetricInfo* metric) {
  if (metric == nullptr || metric->doc.empty()) return html;
  return "<abbr tabindex=\"0\" title=\"" + escape(definition(*metric)) + "\">" + html + "</abbr>";
}

std::string folded(const std::string& summary, const std::string& html) {
  return html.empty() ? html : fmt::format("<details><summary>{}</summary>\n{}</details>\n", summary, html);
}

namespace {
/// HTML without its elements, for an attribute.
std::string without_elements(const std::string& html) {
  std::string out;
  bool inside = false;
  for (const char c : html) {
    if (c == '<') inside = true;
    if (!inside) out += c;
    if (c == '>') inside = false;
  }
  return out;
}
}  // namespace

void HtmlTable::add(const std::vector<std::string>& cells) {
  TACTOR_DEMAND(cells.size() == heads_.size());
  rows_ += "<tr><th scope=\"row\">" + cells.front() + "</th>";
  for (std::size_t i = 1; i < cells.size(); ++i) {
    const std::string label = without_elements(heads_[i]);
    rows_ += (label.empty() ? "<td>" : "<td data-label=\"" + label + "\">") + cells[i] + "</td>";
  }
  rows_ += "</tr>\n";
}

void HtmlTable::add_group(const std::string& text) {
  rows_ += fmt::format("<tr class=\"group\"><th colspan=\"{}\">{}</th></tr>\n", heads_.size(), text);
}

std::string HtmlTable::html() const {
  std::string html = even_ ? fmt::format("<table class=\"rows even\" style=\"--columns:{}\">", heads_.size() - 1)
                           : "<table class=\"rows\">";
  html += "<thead><tr>";
  for (const std::string& head : heads_) html += head.empty() ? "<td></td>" : "<th scope=\"col\">" + head + "</th>";
  return html + "</tr></thead><tbody>\n" + rows_ + "</tbody></table>\n";
}

std::string page(const std::string& title, const std::string& body) {
  const bool charts = body.find("<figure><svg") != std::string::npos;
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\">\n<title>{0}</title>\n<style>\n{1}</style></head><body>\n"
      "<h1>{2}</h1>\n{3}{4}</body></html>\n",
      escape(title), page_style, breakable(title), body,
      charts ? fmt::format("<script>\n{}</script>\n", page_script) : std::string());
}

}  // namespace tactor
