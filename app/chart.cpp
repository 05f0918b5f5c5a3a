#include "app/chart.hpp"

#include <fmt/format.h>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "framework/core/check.hpp"
#include "framework/core/temporary_folder.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'') out += '\'';
    out += c == '\n' ? ' ' : c;
  }
  return out + "'";
}

/// How gnuplot draws a curve.
std::string curve_style(const Curve& curve) {
  if (curve.points) {
    static constexpr std::array<int, 4> shapes{7, 5, 9, 13};  // gnuplot's filled circle, square, triangle, diamond
    return fmt::format("with points pointtype {} pointsize 0.8 linecolor rgb \"{}\"",
                       shapes[curve.mark % shapes.size()], curve.color);
  }
  return fmt::format("with {} linewidth {} linecolor rgb \"{}\"{}", curve.steps ? "steps" : "lines", curve.width,
                     curve.color, curve.dashed ? " dashtype 2" : "");
}

}  // namespace

std::string series_color(std::size_t index) {
  static constexpr std::array<const char*, series_colors> colors{"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                                                 "#E69F00", "#56B4E9", "#7F5539"};
  return colors[index % colors.size()];
}

std::string draw_svg(const std::vector<Chart>& charts, int width, int height) {
  const TemporaryFolder folder;
  const fs::path script_file = folder.path() / "chart.gp";
  const fs::path svg_file = folder.path() / "chart.svg";
  {
    std::ofstream script(script_file);
    script << fmt::format("set terminal svg size {},{} noenhanced font 'sans-serif,13' background '#ffffff'\n", width,
                          height * static_cast<int>(charts.size()));
    script << "set output " << quoted(svg_file.string()) << "\n";
    script << "set encoding utf8\nset border 3 linecolor rgb '#555555'\nset tics nomirror textcolor rgb '#333333'\n"
              "set grid linecolor rgb '#dddddd' linewidth 0.6\nset key outside right top vertical Left reverse\n"
              "set lmargin 11\nset rmargin 26\n";
    script << fmt::format("set multiplot layout {},1\n", charts.size());
    for (const Chart& chart : charts) {
      script << "set title " << quoted(chart.title) << "\nset xlabel " << quoted(chart.x_label) << "\nset ylabel "
             << quoted(chart.y_label) << " offset 1\n";
      script << (chart.log_x ? "set logscale x\n" : "unset logscale x\n");
      script << (chart.log_y ? "set logscale y\n" : "unset logscale y\n");
      if (chart.x_range) {
        script << fmt::format("set xrange [{:.9g}:{:.9g}]\n", chart.x_range->first, chart.x_range->second);
      } else {
        script << "set xrange [*:*]\n";
      }
      script << "unset yrange\nset autoscale y\n";
      std::string plot;
      std::size_t block = 0;
      for (const Curve& curve : chart.curves) {
        script << "$data" << block << " << EOD\n";
        for (std::size_t i = 0; i < curve.x.size(); ++i) {
          if (std::isfinite(curve.x[i]) && std::isfinite(curve.y[i])) {
            script << fmt::format("{:.8g} {:.6g}\n", curve.x[i], curve.y[i]);
          }
        }
        script << "EOD\n";
        plot += fmt::format("{}$data{} using 1:2 title {} {}", plot.empty() ? "plot " : ", ", block, quoted(curve.name),
                            curve_style(curve));
        ++block;
      }
      script << plot << "\n";
    }
    script << "unset multiplot\n";
    if (!script.flush()) throw RunError("cannot write " + script_file.string());
  }
  const std::string command = "gnuplot '" + script_file.string() + "' 2>&1";
  std::string said;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) throw RunError("cannot start gnuplot");
  std::array<char, 512> buffer{};
  while (std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) said += buffer.data();
  const int status = pclose(pipe);
  std::ifstream svg(svg_file);
  if (status != 0 || !svg) {
    throw RunError("gnuplot could not draw the report's charts (Debian package gnuplot-nox): " + said);
  }
  std::string text(std::istreambuf_iterator<char>(svg), {});
  // Only the element itself goes into a page.
  return text.substr(text.find("<svg"));
}

}  // namespace tactor
