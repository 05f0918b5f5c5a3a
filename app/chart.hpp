// Line charts as self-contained SVG, drawn by gnuplot.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tactor {

/// A curve, or marks where `points` is set.
struct Curve {
  std::string name;
  std::vector<double> x;
  std::vector<double> y;
  std::string color = "#000000";
  bool points = false;
  std::size_t mark = 0;  ///< which of four shapes the marks have, where there are more curves than colours
  bool dashed = false;
  bool steps = false;  ///< hold each value until the next
  double width = 1.4;
};

struct Chart {
  std::string title;
  std::string x_label;
  std::string y_label;
  std::vector<Curve> curves;
  std::optional<std::pair<double, double>> x_range;
  bool log_x = false;
  bool log_y = false;
};

/// The charts under each other, `width` by `height` pixels each. Throws RunError where gnuplot is missing or fails.
std::string draw_svg(const std::vector<Chart>& charts, int width, int height);

/// Colours that stay apart for colour-blind readers (Okabe and Ito), by index; they repeat after `series_colors`.
inline constexpr std::size_t series_colors = 7;
std::string series_color(std::size_t index);

}  // namespace tactor
