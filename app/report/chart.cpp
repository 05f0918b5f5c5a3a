#include "app/report/chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
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
/// What a line of gnuplot's standard error begins with that is for us.
constexpr std::string_view frame_mark = "frame ";

enum class Format { svg, png };

/// The first line of a script.
std::string terminal(Format format, int width, int height) {
  if (format == Format::svg) {
    return fmt::format("set terminal svg size {},{} noenhanced font 'sans-serif,13' background '#ffffff'\n", width,
                       height);
  }
  return fmt::format(
      "set terminal pngcairo size {},{} noenhanced font 'sans-serif,13' fontscale 2 linewidth 2 pointscale 2\n",
      2 * width, 2 * height);
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

/// What gnuplot makes of a script.
struct Picture {
  std::string bytes;
  std::string frames;     ///< where the charts are, see print_frame
  bool is_drawn = false;  ///< else the bytes say why there is none
};

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

bool is_whole_picture(const std::string& bytes, Format format) {
  using namespace std::string_view_literals;
  if (format == Format::svg) return bytes.find("<svg") != std::string::npos && trimmed(bytes).ends_with("</svg>");
  return bytes.starts_with("\x89PNG\r\n"sv) && bytes.ends_with("IEND\xae\x42\x60\x82"sv);
}

/// Why there is no picture; empty where there is one.
std::string why_none(const CommandResult& result, Format format) {
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
Picture gnuplot(const std::string& script_text, Format format, int width, int height) {
  static const auto note = once(tell_note);
  static std::string too_slow;  // each chart would wait for it again
  std::string why = too_slow;
  CommandResult result;
  if (why.empty()) {
    try {
      // As a file its input is read in blocks; as what a person types it would be read by single bytes.
      result = run_command({.words = {"gnuplot", "--default-settings", "/dev/stdin"},
                            .input = terminal(format, width, height) + style + script_text,
                            .environment = environment_of_gnuplot(),
                            .longest = longest_drawing,
                            .most_bytes = most_picture_bytes});
      why = why_none(result, format);
      if (result.end == CommandEnd::too_slow) too_slow = why;
    } catch (const RunError& error) {
      why = "gnuplot cannot be started: " + one_line(error.what());
    }
  }
  if (!why.empty()) {
    note("no chart: " + why);
    return {format == Format::svg ? no_chart(width, why) : std::string(), {}, false};
  }
  // Only the element itself goes into a page.
  if (format == Format::svg) result.out.erase(0, result.out.find("<svg"));
  Picture picture{std::move(result.out), {}, true};
  std::istringstream lines(result.err);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(frame_mark)) picture.frames += line.substr(frame_mark.size()) + "\n";
  }
  return picture;
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

/// Prints the frame of the chart just drawn: left, right, bottom and top in pixels from below, then the values there.
constexpr const char* print_frame =
    "print sprintf('frame %.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g', GPVAL_TERM_XMIN, GPVAL_TERM_XMAX, GPVAL_TERM_YMIN, "
    "GPVAL_TERM_YMAX, GPVAL_X_MIN, GPVAL_X_MAX, GPVAL_Y_MIN, GPVAL_Y_MAX)\n";

/// `width` and `height`: of each chart, in pixels.
std::string script_of(const std::vector<Chart>& charts, int width, int height) {
  std::string script =
      "set grid linecolor rgb '#dddddd' linewidth 0.6\nset key outside right top vertical Left reverse\n"
      "set errorbars 0\n"
      "set lmargin 13\n";
  script += fmt::format("set rmargin {}\n", margin_of_key(charts, width));
  script += fmt::format("set multiplot layout {},1\n", charts.size());
  for (const Chart& chart : charts) {
    script += "set title " + quoted(chart.title) + "\nset xlabel " + quoted(chart.x_label) + "\nset ylabel " +
              quoted(chart.y_label) + "\n";
    script += has_key(chart, height) ? "set key on\n" : "set key off\n";
    script += chart.log_x ? "set logscale x\n" : "unset logscale x\n";
    script += chart.log_y ? "set logscale y\n" : "unset logscale y\n";
    bool drawn = false;
    script += ranges(chart, drawn) + "set xtics autofreq\nset ytics autofreq\n";
    if (!drawn) {
      script +=
          "set label 1 'no values' at graph 0.5,0.5 center textcolor rgb '#555555'\nplot NaN notitle\nunset label 1\n"
          "print 'frame no values'\n";
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
    script += plot + "\n" + print_frame;
  }
  return script + "unset multiplot\n";
}

/// What a page's script must know to draw the charts itself; the curves it reads from the picture. Empty where they
/// have marks that it cannot draw.
std::string for_script(const std::vector<Chart>& charts, const std::string& frames) {
  nlohmann::json list = nlohmann::json::array();
  std::istringstream lines(frames);
  for (const Chart& chart : charts) {
    if (chart.close) return {};
    nlohmann::json one{{"title", chart.title}, {"x", chart.x_label}, {"y", chart.y_label}};
    one["log"] = {chart.log_x, chart.log_y};
    std::string line;
    std::getline(lines, line);
    std::istringstream numbers(line);
    std::array<double, 8> frame{};
    for (double& number : frame) numbers >> number;
    if (numbers) one["frame"] = frame;  // a chart without values has none
    one["curves"] = nlohmann::json::array();
    for (const Curve& curve : chart.curves) {
      if (curve.ring || curve.cross) return {};
      nlohmann::json& drawn = one["curves"].emplace_back();
      drawn = {{"name", curve.name}, {"color", curve.color}};
      if (curve.points || !curve.x_low.empty()) drawn["mark"] = curve.mark;
      if (curve.hollow) drawn["hollow"] = true;
      if (curve.dash > 0) drawn["dash"] = curve.dash;
    }
    list.push_back(std::move(one));
  }
  return list.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string tics(const char* axis, const std::vector<std::string>& names, const char* more) {
  std::string list;
  for (std::size_t i = 0; i < names.size(); ++i)
    list += fmt::format("{}{} {}", i == 0 ? "" : ", ", quoted(names[i]), i);
  return fmt::format("set {} {} ({})\n", axis, more, list);
}

std::string script_of(const CellMap& map) {
  std::string script =
      "set key at graph 1.03,1 left top vertical Left reverse\nset rmargin 28\nset bmargin 7\nunset grid\n";
  std::size_t widest = 0;
  for (const std::string& name : map.y) widest = std::max(widest, name.size());
  script += fmt::format("set lmargin {}\n", widest + 8);
  script += "set title " + quoted(map.title) + "\nset xlabel " + quoted(map.x_label) + "\nset ylabel " +
            quoted(map.y_label) + "\n";
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

std::string draw_svg(const std::vector<Chart>& charts, int width, int height) {
  return gnuplot(script_of(charts, width, height), Format::svg, width, height * static_cast<int>(charts.size())).bytes;
}

std::string chart_figure(const std::vector<Chart>& charts, int width, int height) {
  Picture picture =
      gnuplot(script_of(charts, width, height), Format::svg, width, height * static_cast<int>(charts.size()));
  const std::string data = picture.is_drawn ? for_script(charts, picture.frames) : std::string();
  if (!data.empty()) picture.bytes.insert(4, " data-charts=\"" + escape(data) + "\"");
  return figure(picture.bytes);
}

std::string draw_png(const std::vector<Chart>& charts, int width, int height) {
  return gnuplot(script_of(charts, width, height), Format::png, width, height * static_cast<int>(charts.size())).bytes;
}

std::string draw_map_svg(const CellMap& map, int width, int height) {
  return gnuplot(script_of(map), Format::svg, width, height).bytes;
}

std::string draw_map_png(const CellMap& map, int width, int height) {
  return gnuplot(script_of(map), Format::png, width, height).bytes;
}

}  // namespace tactor
