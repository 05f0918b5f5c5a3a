#include "app/report/figure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/csv_cell.hpp"
#include "framework/core/check.hpp"

namespace tactor {

namespace {

constexpr std::string_view data_begin = "<script type=\"application/json\">", data_end = "</script>";

/// The flags of a curve that a page's data tell where they are set.
constexpr std::array<std::pair<const char*, bool Curve::*>, 6> curve_flags{{{"points", &Curve::points},
                                                                            {"hollow", &Curve::hollow},
                                                                            {"steps", &Curve::steps},
                                                                            {"joined", &Curve::joined},
                                                                            {"ring", &Curve::ring},
                                                                            {"cross", &Curve::cross}}};
constexpr std::array<std::pair<const char*, std::vector<double> Curve::*>, 4> curve_bars{
    {{"x_low", &Curve::x_low}, {"x_high", &Curve::x_high}, {"y_low", &Curve::y_low}, {"y_high", &Curve::y_high}}};

/// With as many digits as a figure needs.
nlohmann::json json_of(const std::vector<double>& values, int digits = 6) {
  nlohmann::json list = nlohmann::json::array();
  for (const double value : values) {
    if (std::isfinite(value)) {
      list.push_back(std::strtod(fmt::format("{:.{}g}", value, digits).c_str(), nullptr));
    } else {
      list.push_back(nullptr);
    }
  }
  return list;
}

std::vector<double> values_of(const nlohmann::json& list) {
  std::vector<double> values;
  for (const nlohmann::json& value : list) values.push_back(value.is_null() ? std::nan("") : value.get<double>());
  return values;
}

/// The x of all curves of a figure, each list once.
class SharedLists {
 public:
  std::size_t index(const std::vector<double>& list) {
    const auto at = std::find(known_.begin(), known_.end(), list);
    if (at != known_.end()) return static_cast<std::size_t>(at - known_.begin());
    known_.push_back(list);
    lists_.push_back(json_of(list, 8));
    return known_.size() - 1;
  }
  [[nodiscard]] const nlohmann::json& lists() const { return lists_; }

 private:
  std::vector<std::vector<double>> known_;
  nlohmann::json lists_ = nlohmann::json::array();
};

nlohmann::json json_of(const Curve& curve, SharedLists& x) {
  nlohmann::json json{{"name", curve.name}, {"color", curve.color}, {"width", curve.width}, {"x", x.index(curve.x)}};
  json["y"] = json_of(curve.y);
  if (curve.mark > 0) json["mark"] = curve.mark;
  if (curve.dash > 0) json["dash"] = curve.dash;
  for (const auto& [name, flag] : curve_flags) {
    if (curve.*flag) json[name] = true;
  }
  for (const auto& [name, ends] : curve_bars) {
    if (!(curve.*ends).empty()) json[name] = json_of(curve.*ends);
  }
  return json;
}

/// A page that somebody sent may hold anything, and what is drawn goes to gnuplot: a colour is `#rrggbb` and nothing
/// else.
std::string color_of(const nlohmann::json& json) {
  auto color = json.get<std::string>();
  const bool is_color = color.size() == 7 && color[0] == '#' && std::all_of(color.begin() + 1, color.end(), [](char c) {
                          return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F');
                        });
  if (!is_color) throw InputError("a colour is not of the form #rrggbb");
  return color;
}

Curve curve_of(const nlohmann::json& json, const nlohmann::json& lists) {
  Curve curve;
  curve.name = json.at("name");
  curve.color = color_of(json.at("color"));
  curve.width = json.at("width");
  curve.x = values_of(lists.at(json.at("x").get<std::size_t>()));
  curve.y = values_of(json.at("y"));
  curve.mark = json.value("mark", std::size_t{0});
  curve.dash = json.value("dash", std::size_t{0});
  for (const auto& [name, flag] : curve_flags) curve.*flag = json.value(name, false);
  bool whole = curve.y.size() == curve.x.size();
  const bool has_bars = json.contains(curve_bars.front().first);
  for (const auto& [name, ends] : curve_bars) {
    if (json.contains(name)) curve.*ends = values_of(json.at(name));
    whole = whole && (curve.*ends).size() == (has_bars ? curve.x.size() : 0);
  }
  if (!whole) throw InputError("a curve has lists of different lengths");
  return curve;
}

nlohmann::json json_of(const Chart& chart, SharedLists& x) {
  nlohmann::json json{{"name", chart.name}, {"title", chart.title}, {"x", chart.x_label}, {"y", chart.y_label}};
  json["log"] = {chart.log_x, chart.log_y};
  if (chart.close) json["close"] = true;
  if (chart.x_range) json["range"] = {chart.x_range->first, chart.x_range->second};
  json["curves"] = nlohmann::json::array();
  for (const Curve& curve : chart.curves) json["curves"].push_back(json_of(curve, x));
  return json;
}

Chart chart_of(const nlohmann::json& json, const nlohmann::json& lists) {
  Chart chart;
  chart.name = json.at("name");
  chart.title = json.at("title");
  chart.x_label = json.at("x");
  chart.y_label = json.at("y");
  chart.log_x = json.at("log").at(0);
  chart.log_y = json.at("log").at(1);
  chart.close = json.value("close", false);
  if (json.contains("range")) chart.x_range = {json.at("range").at(0), json.at("range").at(1)};
  for (const nlohmann::json& curve : json.at("curves")) chart.curves.push_back(curve_of(curve, lists));
  return chart;
}

nlohmann::json json_of(const CellMap& map) {
  nlohmann::json json{{"name", map.name}, {"title", map.title}, {"x_label", map.x_label}, {"y_label", map.y_label},
                      {"x", map.x},       {"y", map.y},         {"kind", map.kind}};
  // Kinds that no cell has are left out.
  std::vector<int> place(map.kinds.size(), -1);
  json["kinds"] = nlohmann::json::array();
  for (nlohmann::json& row : json["kind"]) {
    for (nlohmann::json& cell : row) {
      if (cell < 0) continue;
      const auto kind = cell.get<std::size_t>();
      if (place[kind] < 0) {
        place[kind] = static_cast<int>(json["kinds"].size());
        json["kinds"].push_back({map.kinds[kind].name, map.kinds[kind].color, map.kinds[kind].letter});
      }
      cell = place[kind];
    }
  }
  if (map.framed) json["framed"] = {map.framed->first, map.framed->second};
  return json;
}

CellMap map_of(const nlohmann::json& json) {
  CellMap map;
  map.name = json.at("name");
  map.title = json.at("title");
  map.x_label = json.at("x_label");
  map.y_label = json.at("y_label");
  map.x = json.at("x").get<std::vector<std::string>>();
  map.y = json.at("y").get<std::vector<std::string>>();
  map.kind = json.at("kind").get<std::vector<std::vector<int>>>();
  for (const nlohmann::json& kind : json.at("kinds")) {
    map.kinds.push_back({kind.at(0), color_of(kind.at(1)), kind.at(2)});
    const std::string& letter = map.kinds.back().letter;
    if (letter.size() != 1 || std::isalpha(static_cast<unsigned char>(letter[0])) == 0)
      throw InputError("the mark of a kind is not one letter");
  }
  if (json.contains("framed")) map.framed = {json.at("framed").at(0), json.at("framed").at(1)};
  const bool whole =
      map.kind.size() == map.y.size() && std::all_of(map.kind.begin(), map.kind.end(), [&](const auto& row) {
        return row.size() == map.x.size() && std::all_of(row.begin(), row.end(), [&](int kind) {
                 return kind >= -1 && kind < static_cast<int>(map.kinds.size());
               });
      });
  if (!whole) throw InputError("a map has rows of different lengths");
  return map;
}

/// The text of the script element that holds the data; nothing in it can end the element.
std::string data_of(const Drawing& drawing, int height) {
  nlohmann::json json{{"height", height}};
  if (const auto* map = std::get_if<CellMap>(&drawing)) {
    json["map"] = json_of(*map);
  } else {
    SharedLists x;
    json["charts"] = nlohmann::json::array();
    for (const Chart& chart : std::get<std::vector<Chart>>(drawing)) json["charts"].push_back(json_of(chart, x));
    json["x"] = x.lists();
  }
  std::string text;
  for (const char c : json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)) {
    if (c == '<') {
      text += "\\u003c";
    } else {
      text += c;
    }
  }
  return text;
}

std::string csv_of(const std::vector<Chart>& charts) {
  const bool several = charts.size() > 1;
  const bool bars = std::any_of(charts.begin(), charts.end(), [](const Chart& chart) {
    return std::any_of(chart.curves.begin(), chart.curves.end(), [](const Curve& c) { return !c.x_low.empty(); });
  });
  std::string csv =
      several ? "chart,curve,x,y"
              : fmt::format("curve,{},{}", csv_cell(charts.front().x_label), csv_cell(charts.front().y_label));
  if (bars) csv += ",x_low,x_high,y_low,y_high";
  csv += "\n";
  for (const Chart& chart : charts) {
    for (const Curve& curve : chart.curves) {
      for (std::size_t i = 0; i < curve.x.size(); ++i) {
        if (several) csv += csv_cell(chart.name) + ",";
        csv += csv_cell(curve.name) + "," + csv_cell(curve.x[i]) + "," + csv_cell(curve.y[i]);
        for (const auto& [name, ends] : curve_bars) {
          if (bars) csv += "," + ((curve.*ends).empty() ? std::string() : csv_cell((curve.*ends)[i]));
        }
        csv += "\n";
      }
    }
  }
  return csv;
}

std::string csv_of(const CellMap& map) {
  std::string csv = fmt::format("{},{},kind\n", csv_cell(map.x_label), csv_cell(map.y_label));
  for (std::size_t row = 0; row < map.kind.size(); ++row) {
    for (std::size_t column = 0; column < map.x.size(); ++column) {
      const int kind = map.kind[row][column];
      if (kind < 0) continue;
      csv += csv_cell(map.x[column]) + "," + csv_cell(map.y[row]) + "," +
             csv_cell(map.kinds[static_cast<std::size_t>(kind)].name) + "\n";
    }
  }
  return csv;
}

void add_figures(std::string_view data, std::vector<NamedFigure>& figures) {
  const nlohmann::json json = nlohmann::json::parse(data);
  if (json.contains("map")) {
    const CellMap map = map_of(json.at("map"));
    figures.push_back({map.name, map});
    return;
  }
  for (const nlohmann::json& one : json.at("charts")) {
    const Chart chart = chart_of(one, json.at("x"));
    figures.push_back({chart.name, std::vector<Chart>{chart}});
  }
}

/// Rows of one name have figures of one name: the second gets `_2` behind it.
void number_names(std::vector<NamedFigure>& figures) {
  std::map<std::string, int> seen;
  for (NamedFigure& figure : figures) {
    const int count = ++seen[figure.name];
    if (count > 1) figure.name += fmt::format("_{}", count);
  }
}

}  // namespace

std::string figure_html(const std::string& svg, const Drawing& drawing, int height) {
  return "<figure>" + svg + std::string(data_begin) + data_of(drawing, height) + std::string(data_end) + "</figure>\n";
}

std::string chart_figure(const std::vector<Chart>& charts, int width, int height) {
  return figure_html(draw(charts, PictureFormat::svg, width, height), charts, height);
}

std::vector<NamedFigure> figures_of(std::string_view page) {
  std::vector<NamedFigure> figures;
  for (std::size_t at = 0; (at = page.find(data_begin, at)) != std::string_view::npos;) {
    at += data_begin.size();
    const std::size_t end = page.find(data_end, at);
    if (end == std::string_view::npos) throw InputError("the page is cut off in a figure");
    try {
      add_figures(page.substr(at, end - at), figures);
    } catch (const nlohmann::json::exception& error) {
      throw InputError(fmt::format("figure {} of the page cannot be read: {}", figures.size() + 1, error.what()));
    }
  }
  number_names(figures);
  return figures;
}

std::string figure_csv(const Drawing& drawing) {
  if (const auto* map = std::get_if<CellMap>(&drawing)) return csv_of(*map);
  return csv_of(std::get<std::vector<Chart>>(drawing));
}

}  // namespace tactor
