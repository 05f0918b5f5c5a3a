#include "app/report/html_page.hpp"

#include <fmt/format.h>

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

std::string page(const std::string& title, const std::string& body) {
  return fmt::format(
      R"(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>{0}</title>
<style>
body {{ font: 15px/1.5 system-ui, sans-serif; color: #222; max-width: 1240px; margin: 2em auto; padding: 0 1.5em; }}
h1 {{ font-size: 1.6em; margin-bottom: 0; }} h2 {{ font-size: 1.2em; margin-top: 2em; }}
p.sub {{ color: #555; margin-top: .3em; }}
table {{ border-collapse: collapse; margin: 1em 0; font-variant-numeric: tabular-nums; }}
th, td {{ padding: .25em .8em; text-align: right; border-bottom: 1px solid #e4e4e4; }}
th:first-child, td:first-child {{ text-align: left; }} td {{ white-space: nowrap; }}
thead th {{ border-bottom: 2px solid #888; }} tr.group td {{ background: #f4f4f4; font-weight: 600; }}
td.sd {{ color: #777; padding-left: 0; text-align: left; }}
svg {{ max-width: 100%; height: auto; }}
.wide {{ overflow-x: auto; }}
pre {{ background: #f6f6f6; padding: 1em; overflow-x: auto; font-size: 13px; }}
.best {{ font-weight: 600; }} .bad {{ color: #b00020; font-weight: 600; }}
</style></head><body>
<h1>{0}</h1>
{1}
</body></html>
)",
      escape(title), body);
}

}  // namespace tactor
