#include "app/report/chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <string_view>

#include "app/command_output.hpp"
#include "app/output.hpp"
#include "app/report/html_page.hpp"
#include "framework/core/check.hpp"
#include "framework/core/text.hpp"

namespace tactor {

namespace {

/// A text of gnuplot's, which runs nothing of what is in it. It has to be on one line.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'') out += '\'';
    out += static_cast<unsigned char>(c) < ' ' || c == '\x7f' ? ' ' : c;
  }
  return out + "'";
}

constexpr std::chrono::seconds longest_drawing{30};  // a chart takes a tenth of a second
constexpr std::size_t most_picture_bytes = std::size_t{64} << 20U;
constexpr double pixels_per_mm = 96 / 25.4;

/// A picture in pixels of 1/96 inch.
struct Sheet {
  PictureFormat format = PictureFormat::svg;
  int width = 0, height = 0;
  double font = 13;    ///< pixels
  bool paper = false;  ///< names stand above the curves, and a title below a picture is the paper's
};

/// The first line of a script.
std::string terminal(const Sheet& sheet) {
  switch (sheet.format) {
    case PictureFormat::svg:
      return fmt::format("set terminal svg size {},{} noenhanced font 'sans-serif,{:.4g}' background '#ffffff'\n",
                         sheet.width, sheet.height, sheet.font);
    case PictureFormat::png:
      return fmt::format(
          "set terminal pngcairo size {},{} noenhanced font 'sans-serif,{:.4g}' fontscale 2 linewidth 2 pointscale 2\n",
          2 * sheet.width, 2 * sheet.height, sheet.font);
    case PictureFormat::pdf: {
      // It cuts a size to whole points.
      const auto inches = [](int pixels) { return (std::round(pixels * 0.75) + 0.01) / 72; };
      return fmt::format("set terminal pdfcairo size {:.6g}in,{:.6g}in noenhanced font 'sans-serif,{:.4g}'\n",
                         inches(sheet.width), inches(sheet.height), sheet.font * 0.75);
    }
  }
  TACTOR_DEMAND(false);
}

constexpr const char* style =
    "set encoding utf8\nset border 3 linecolor rgb '#555555'\nset tics nomirror textcolor rgb '#333333'\n";

/// How gnuplot draws a curve.
std::string curve_style(const Curve& curve) {
  // gnuplot's circle, square, triangle, diamond, triangle downwards, pentagon, plus, star.
  static constexpr std::array<int, mark_shapes> filled{7, 5, 9, 13, 11, 15, 1, 3};
  static constexpr std::array<int, mark_shapes> open{6, 4, 8, 12, 10, 14, 1, 3};
  const auto& shapes = curve.hollow ? open : filled;
  if (curve.ring)
    return fmt::format("with points pointtype 6 pointsize 1.9 linewidth 1.6 linecolor rgb \"{}\"", curve.color);
  if (curve.cross)
    return fmt::format("with points pointtype 2 pointsize 1.6 linewidth 1.6 linecolor rgb \"{}\"", curve.color);
  if (!curve.x_low.empty()) {
    return fmt::format("with xyerrorbars pointtype {} pointsize 0.8 linewidth {} linecolor rgb \"{}\"",
                       shapes[curve.mark % shapes.size()], curve.width, curve.color);
  }
  if (curve.points || curve.joined) {
    return fmt::format("with {} pointtype {} pointsize 0.8 linecolor rgb \"{}\"",
                       curve.joined ? "linespoints" : "points", shapes[curve.mark % shapes.size()], curve.color);
  }
  return fmt::format("with {} linewidth {} linecolor rgb \"{}\"{}", curve.steps ? "steps" : "lines", curve.width,
                     curve.color, curve.dash > 0 ? fmt::format(" dashtype {}", curve.dash + 1) : "");
}

/// What stands in a page where a chart would: the tables count more.
std::string no_chart(int width, const std::string& why) {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"40\"><text x=\"8\" y=\"25\" "
      "font-family=\"sans-serif\" font-size=\"14\">No chart: {}.</text></svg>",
      width, escape(why));
}

/// As text that a page and a terminal can show, and no longer than a line.
std::string one_line(const std::string& text) {
  constexpr std::size_t longest = 200;
  std::string line(trimmed(text).substr(0, longest));
  std::replace_if(
      line.begin(), line.end(), [](char c) { return c < ' ' || c > '~'; }, ' ');
  return line;
}

/// The few variables that gnuplot needs: what it draws must not depend on the settings of who calls.
std::vector<std::string> environment_of_gnuplot() {
  constexpr std::array<std::string_view, 3> handed_on{"PATH=", "HOME=", "LD_LIBRARY_PATH="};
  std::vector<std::string> entries = environment_for_others();
  std::erase_if(entries, [&](const std::string& entry) {
    return std::none_of(handed_on.begin(), handed_on.end(), [&](auto name) { return entry.starts_with(name); });
  });
  entries.emplace_back("LC_ALL=C.UTF-8");
  return entries;
}

bool is_whole_picture(const std::string& bytes, PictureFormat format) {
  using namespace std::string_view_literals;
  switch (format) {
    case PictureFormat::svg:
      return bytes.find("<svg") != std::string::npos && trimmed(bytes).ends_with("</svg>");
    case PictureFormat::png:
      return bytes.starts_with("\x89PNG\r\n"sv) && bytes.ends_with("IEND\xae\x42\x60\x82"sv);
    case PictureFormat::pdf:
      return bytes.starts_with("%PDF-") && trimmed(bytes).ends_with("%%EOF");
  }
  TACTOR_DEMAND(false);
}

/// Why there is no picture; empty where there is one.
std::string why_none(const CommandResult& result, PictureFormat format) {
  switch (result.end) {
    case CommandEnd::exited:
      if (result.code != 0) {
        const std::string said = one_line(result.err);
        return "gnuplot could not draw it: " + (said.empty() ? fmt::format("exit code {}", result.code) : said);
      }
      return is_whole_picture(result.out, format) ? "" : "what gnuplot has drawn is not whole";
    case CommandEnd::not_there:
      return "gnuplot is not installed where this was written (Debian package gnuplot-nox)";
    case CommandEnd::too_slow:
      return fmt::format("gnuplot took longer than {} s and was ended", longest_drawing.count());
    case CommandEnd::killed:
    case CommandEnd::not_started:
    case CommandEnd::too_much:
    case CommandEnd::interrupted:
      return "gnuplot " + one_line(failure_of(result));
  }
  TACTOR_DEMAND(false);
}

/// Runs the script behind its first lines. A report without its charts is better than none, so that whatever keeps
/// gnuplot from drawing them is a note.
std::string gnuplot(const std::string& script_text, const Sheet& sheet) {
  static const auto note = once(tell_note);
  static std::string too_slow;  // each chart would wait for it again
  std::string why = too_slow;
  CommandResult result;
  if (why.empty()) {
    try {
      // As a file its input is read in blocks; as what a person types it would be read by single bytes.
      result = run_command({.words = {"gnuplot", "--default-settings", "/dev/stdin"},
                            .input = terminal(sheet) + style + script_text,
                            .environment = environment_of_gnuplot(),
                            .longest = longest_drawing,
                            .most_bytes = most_picture_bytes});
      why = why_none(result, sheet.format);
      if (result.end == CommandEnd::too_slow) too_slow = why;
    } catch (const RunError& error) {
      why = "gnuplot cannot be started: " + one_line(error.what());
    }
  }
  const bool svg = sheet.format == PictureFormat::svg;
  if (!why.empty()) {
    note("no chart: " + why);
    return svg && !sheet.paper ? no_chart(sheet.width, why) : std::string();
  }
  // Only the element itself goes into a page.
  if (svg) result.out.erase(0, result.out.find("<svg"));
  return std::move(result.out);
}

/// Where a logarithmic axis from low to high has tics: at powers of ten, at 1, 2 and 5, or where it is short at equal
/// steps.
std::vector<double> close_tics(double low, double high) {
  std::vector<double> tics;
  if (high / low < 12) {
    const double wish = (high - low) / 4;
    const double decade = std::pow(10, std::floor(std::log10(wish)));
    const double step = decade * (wish < 2 * decade ? 1 : wish < 5 * decade ? 2 : 5);
    for (double k = std::ceil(low / step); k * step <= high; ++k) tics.push_back(k * step);
    return tics;
  }
  for (int decade = static_cast<int>(std::floor(std::log10(low))); std::pow(10, decade) <= high; ++decade) {
    for (const int step : {1, 2, 5}) {
      const double at = step * std::pow(10, decade);
      if (at >= low && at <= high && (high / low <= 300 || step == 1)) tics.push_back(at);
    }
  }
  return tics;
}

/// Ends near the values (above 0) and tics at 1, 2 and 5 for a logarithmic axis, `x` or `y`.
std::string close_axis(const std::string& axis, const Chart& chart, std::vector<double> Curve::*values,
                       std::vector<double> Curve::*lows, std::vector<double> Curve::*highs) {
  double low = std::numeric_limits<double>::infinity(), high = 0;
  for (const Curve& curve : chart.curves) {
    for (const auto list : {values, lows, highs}) {
      for (const double v : curve.*list) {
        if (!(v > 0) || !std::isfinite(v)) continue;
        low = std::min(low, v);
        high = std::max(high, v);
      }
    }
  }
  if (!(high > 0)) return {};
  const double margin = std::max(1.06, std::sqrt(1.3 * low / high));
  low /= margin;
  high *= margin;
  std::string list;
  for (const double at : close_tics(low, high)) {
    list += fmt::format("{}\"{:.6g}\" {:.6g}", list.empty() ? "" : ", ", at, at);
  }
  return fmt::format("set {0}range [{1:.9g}:{2:.9g}]\nset {0}tics ({3})\n", axis, low, high, list);
}

/// The margin at the right, in characters, into which the longest name of a curve goes: at most half of the width.
std::size_t margin_of_key(const std::vector<Chart>& charts, int width) {
  constexpr int character = 8;  // pixels
  std::size_t longest = 0;
  for (const Chart& chart : charts) {
    for (const Curve& curve : chart.curves) longest = std::max(longest, curve.name.size());
  }
  const auto most = static_cast<std::size_t>(width / (2 * character));
  return std::clamp<std::size_t>(longest + 8, std::min<std::size_t>(26, most), most);
}

/// The smallest and the largest of some values; `low` is above `high` where there are none.
struct Extent {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void add(double v) {
    low = std::min(low, v);
    high = std::max(high, v);
  }
  [[nodiscard]] bool empty() const { return low > high; }
};

/// gnuplot refuses a chart without a value inside of its frame. `drawn` says whether there is anything to draw.
std::string ranges(const Chart& chart, bool& drawn) {
  std::optional<std::pair<double, double>> x_range = chart.x_range;
  if (x_range && !(x_range->first < x_range->second)) x_range.reset();  // of a run that ended where it began
  Extent inside, all;
  for (const Curve& curve : chart.curves) {
    for (std::size_t i = 0; i < curve.x.size(); ++i) {
      const double x = curve.x[i], y = curve.y[i];
      if (!std::isfinite(x) || !std::isfinite(y) || (chart.log_x && !(x > 0)) || (chart.log_y && !(y > 0))) continue;
      all.add(y);
      if (!x_range || (x >= x_range->first && x <= x_range->second)) inside.add(y);
    }
  }
  drawn = !all.empty();
  std::string script = x_range ? fmt::format("set xrange [{:.9g}:{:.9g}]\n", x_range->first, x_range->second)
                               : std::string(drawn ? "set xrange [*:*]\n" : "set xrange [0.1:1]\n");
  if (!drawn) return script + "set yrange [0.1:1]\n";
  if (!inside.empty()) return script + "unset yrange\nset autoscale y\n";
  // Lines that cross the frame, from values before it to values behind it.
  const double margin = all.low < all.high || chart.log_y ? 0 : 1;
  const double factor = all.low < all.high || !chart.log_y ? 1 : 2;
  return script +
         fmt::format("set yrange [{:.9g}:{:.9g}]\n", (all.low - margin) / factor, (all.high + margin) * factor);
}

/// A key that is longer than the chart would lie over it. The page's script writes one of its own.
bool has_key(const Chart& chart, int height) {
  return static_cast<int>(named_curves(chart)) * key_line <= height;
}

std::string margins_and_key(const std::vector<Chart>& charts, const Sheet& sheet) {
  if (sheet.paper) return "set key above horizontal Left reverse samplen 2.5\nset lmargin 9\nset rmargin 2\n";
  return fmt::format("set key outside right top vertical Left reverse\nset lmargin 13\nset rmargin {}\n",
                     margin_of_key(charts, sheet.width));
}

std::string script_of(const std::vector<Chart>& charts, const Sheet& sheet) {
  std::string script =
      "set grid linecolor rgb '#dddddd' linewidth 0.6\nset errorbars 0\n" + margins_and_key(charts, sheet);
  script += fmt::format("set multiplot layout {},1\n", charts.size());
  const int height = sheet.height / static_cast<int>(std::max<std::size_t>(1, charts.size()));
  for (const Chart& chart : charts) {
    // Charts under each other that share an axis name it once.
    const bool named = &chart == &charts.back() || chart.x_label != (&chart + 1)->x_label;
    const bool titled = !sheet.paper || charts.size() > 1;
    script += "set title " + quoted(titled ? chart.title : "") + "\nset xlabel " + quoted(named ? chart.x_label : "") +
              "\nset ylabel " + quoted(chart.y_label) + "\n";
    script += sheet.paper || has_key(chart, height) ? "set key on\n" : "set key off\n";
    script += chart.log_x ? "set logscale x\n" : "unset logscale x\n";
    script += chart.log_y ? "set logscale y\n" : "unset logscale y\n";
    bool drawn = false;
    script += ranges(chart, drawn) + "set xtics autofreq\nset ytics autofreq\n";
    if (!drawn) {
      script +=
          "set label 1 'no values' at graph 0.5,0.5 center textcolor rgb '#555555'\nplot NaN notitle\nunset label 1\n";
      continue;
    }
    if (chart.close) {
      script += close_axis("x", chart, &Curve::x, &Curve::x_low, &Curve::x_high) +
                close_axis("y", chart, &Curve::y, &Curve::y_low, &Curve::y_high);
    }
    std::string plot;
    std::size_t block = 0;
    for (const Curve& curve : chart.curves) {
      const char* comma = plot.empty() ? "plot " : ", ";
      if (curve.x.empty()) {
        plot += fmt::format("{}keyentry {} title {}", comma, curve_style(curve), quoted(curve.name));
        continue;
      }
      const bool bars = !curve.x_low.empty();
      script += fmt::format("$data{} << EOD\n", block);
      for (std::size_t i = 0; i < curve.x.size(); ++i) {
        if (!std::isfinite(curve.x[i]) || !std::isfinite(curve.y[i])) continue;
        script += fmt::format("{:.8g} {:.6g}", curve.x[i], curve.y[i]);
        if (bars) {
          script += fmt::format(" {:.8g} {:.8g} {:.6g} {:.6g}", curve.x_low[i], curve.x_high[i], curve.y_low[i],
                                curve.y_high[i]);
        }
        script += "\n";
      }
      script += "EOD\n";
      plot += fmt::format("{}$data{} using {} title {} {}", comma, block, bars ? "1:2:3:4:5:6" : "1:2",
                          quoted(curve.name), curve_style(curve));
      ++block;
    }
    script += plot + "\n";
  }
  return script + "unset multiplot\n";
}

std::string tics(const char* axis, const std::vector<std::string>& names, const char* more) {
  std::string list;
  for (std::size_t i = 0; i < names.size(); ++i)
    list += fmt::format("{}{} {}", i == 0 ? "" : ", ", quoted(names[i]), i);
  return fmt::format("set {} {} ({})\n", axis, more, list);
}

std::string script_of(const CellMap& map, const Sheet& sheet) {
  std::string script = sheet.paper ? "set key above horizontal Left reverse\nset rmargin 2\n"
                                   : "set key at graph 1.03,1 left top vertical Left reverse\nset rmargin 28\n";
  script += "set bmargin 7\nunset grid\n";
  std::size_t widest = 0;
  for (const std::string& name : map.y) widest = std::max(widest, name.size());
  script += fmt::format("set lmargin {}\n", widest + 8);
  script += "set title " + quoted(sheet.paper ? "" : map.title) + "\nset xlabel " + quoted(map.x_label) +
            "\nset ylabel " + quoted(map.y_label) + "\n";
  script += fmt::format("set xrange [-0.5:{}]\nset yrange [-0.5:{}]\n", static_cast<double>(map.x.size()) - 0.5,
                        static_cast<double>(map.y.size()) - 0.5);
  script += tics("xtics", map.x, "rotate by -30") + tics("ytics", map.y, "");
  std::string plot;
  std::string letters = "$letters << EOD\n";
  bool any = false;
  for (std::size_t k = 0; k < map.kinds.size(); ++k) {
    std::string cells;
    for (std::size_t row = 0; row < map.kind.size(); ++row) {
      for (std::size_t column = 0; column < map.kind[row].size(); ++column) {
        if (map.kind[row][column] != static_cast<int>(k)) continue;
        cells += fmt::format("{} {}\n", column, row);
        letters += fmt::format("{} {} {}\n", column, row, map.kinds[k].letter);
        any = true;
      }
    }
    if (cells.empty()) continue;
    script += fmt::format("$cells{} << EOD\n{}EOD\n", k, cells);
    plot += fmt::format(
        "{}$cells{} using 1:2:(0.5):(0.5) with boxxyerror fillstyle solid 1.0 border rgb '#ffffff' linecolor rgb "
        "'{}' title {}",
        plot.empty() ? "plot " : ", ", k, map.kinds[k].color, quoted(map.kinds[k].letter + "  " + map.kinds[k].name));
  }
  if (map.framed) {
    const auto [column, row] = *map.framed;
    script += fmt::format(
        "set object rectangle center {},{} size 0.92,0.92 front fillstyle empty border rgb '#222222' linewidth 2.4\n",
        column, row);
  }
  if (!any) return script + "plot NaN notitle\n";
  return script + letters + "EOD\n" + plot + ", $letters using 1:2:3 with labels textcolor rgb '#222222' notitle\n";
}

/// How bright a colour is in grey, 0 to 1, by ITU-R BT.601.
double brightness(const std::string& color) {
  const auto part = [&](std::size_t at) { return std::stoi(color.substr(at, 2), nullptr, 16) / 255.0; };
  return 0.299 * part(1) + 0.587 * part(3) + 0.114 * part(5);
}

bool is_line(const Curve& curve) {
  return !curve.points && !curve.joined && !curve.ring && !curve.cross && curve.x_low.empty();
}

std::vector<Chart> apart_in_grey(std::vector<Chart> charts) {
  constexpr double alike = 0.15;
  for (Chart& chart : charts) {
    for (auto curve = chart.curves.begin(); curve != chart.curves.end(); ++curve) {
      if (!is_line(*curve)) continue;
      const auto looks_like = [&](const Curve& other) {
        return is_line(other) && other.dash == curve->dash &&
               std::abs(brightness(other.color) - brightness(curve->color)) < alike;
      };
      while (std::any_of(chart.curves.begin(), curve, looks_like)) ++curve->dash;
    }
  }
  return charts;
}

/// The height of the names above the curves, without that of their first line.
double height_of_names_mm(const std::vector<Chart>& charts, double width_mm) {
  constexpr double character_mm = 1.75, sample_mm = 9, line_mm = 3.6;
  double height = 0;
  for (const Chart& chart : charts) {
    std::size_t longest = 0;
    for (const Curve& curve : chart.curves) longest = std::max(longest, curve.name.size());
    const double each_mm = sample_mm + character_mm * static_cast<double>(longest);
    const double in_line = std::max(1.0, std::floor((width_mm - 20) / each_mm));
    height += line_mm * std::max(0.0, std::ceil(static_cast<double>(named_curves(chart)) / in_line) - 1);
  }
  return height;
}

}  // namespace

std::size_t named_curves(const Chart& chart) {
  return static_cast<std::size_t>(
      std::count_if(chart.curves.begin(), chart.curves.end(), [](const Curve& c) { return !c.name.empty(); }));
}

std::string series_color(std::size_t index) {
  static constexpr std::array<const char*, series_colors> colors{"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                                                 "#E69F00", "#56B4E9", "#7F5539"};
  return colors[index % colors.size()];
}

std::string draw(const Drawing& drawing, PictureFormat format, int width, int height) {
  Sheet sheet{format, width, height};
  if (const auto* map = std::get_if<CellMap>(&drawing)) return gnuplot(script_of(*map, sheet), sheet);
  const auto& charts = std::get<std::vector<Chart>>(drawing);
  sheet.height *= static_cast<int>(charts.size());
  return gnuplot(script_of(charts, sheet), sheet);
}

std::string draw_for_paper(const Drawing& drawing, PictureFormat format, PaperWidth width) {
  const bool narrow = width == PaperWidth::one_column;
  const double width_mm = narrow ? 84 : 174;
  const auto pixels = [](double mm) { return static_cast<int>(std::lround(mm * pixels_per_mm)); };
  Sheet sheet{format, pixels(width_mm), 0, 8 * 96 / 72.0, true};
  if (const auto* map = std::get_if<CellMap>(&drawing)) {
    sheet.height = pixels(60 + 7 * static_cast<double>(map->y.size()));
    return gnuplot(script_of(*map, sheet), sheet);
  }
  const std::vector<Chart> charts = apart_in_grey(std::get<std::vector<Chart>>(drawing));
  const double height_mm = charts.size() > 1 ? (narrow ? 38 : 45) : (narrow ? 55 : 75);
  sheet.height = pixels(static_cast<double>(charts.size()) * height_mm + height_of_names_mm(charts, width_mm));
  return gnuplot(script_of(charts, sheet), sheet);
}

}  // namespace tactor
