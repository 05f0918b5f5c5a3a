// Line charts and maps of cells, drawn by gnuplot.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace tactor {

/// How many marks can be told apart.
inline constexpr std::size_t mark_shapes = 8;

/// A curve, or marks where `points` is set. Without values it stands in the key alone.
struct Curve {
  std::string name;
  std::vector<double> x;
  std::vector<double> y;
  std::string color = "#000000";
  bool points = false;
  std::size_t mark = 0;  ///< which of `mark_shapes` the marks have
  bool hollow = false;   ///< marks are not filled
  std::size_t dash = 0;  ///< which dashes a line has; 0: none
  bool steps = false;    ///< hold each value until the next
  double width = 1.4;
  bool joined = false;  ///< marks with a line through them
  bool ring = false;    ///< marks are large rings, to be laid round others
  bool cross = false;   ///< marks are large crosses, to be laid over others
  /// Ends of error bars, as long as x and y, or empty.
  std::vector<double> x_low, x_high, y_low, y_high;
};

struct Chart {
  std::string title;
  std::string x_label;
  std::string y_label;
  std::vector<Curve> curves;
  std::optional<std::pair<double, double>> x_range;
  bool log_x = false;
  bool log_y = false;
  bool close = false;  ///< logarithmic axes end near the data, marked at 1, 2 and 5, instead of at powers of ten
  std::string name{};  ///< by which `tactor export --figure` finds it
};

/// How many names the chart's key has.
std::size_t named_curves(const Chart& chart);
inline constexpr int key_line = 24;  ///< pixels of a chart's height for each of them

/// A kind of cell of a map.
struct CellKind {
  std::string name;  ///< for the key
  std::string color;
  std::string letter;  ///< in the cell, so that kinds can be told apart without colour
};

/// A map of cells: a column for each name of `x`, a row for each of `y`, upwards.
struct CellMap {
  std::string title, x_label, y_label;
  std::vector<std::string> x, y;
  std::vector<CellKind> kinds;
  std::vector<std::vector<int>> kind;                         ///< [row][column], an index into `kinds`; -1: no cell
  std::optional<std::pair<std::size_t, std::size_t>> framed;  ///< column and row of a cell with a frame round it
  std::string name{};                                         ///< by which `tactor export --figure` finds it
};

/// Charts under each other, or a map.
using Drawing = std::variant<std::vector<Chart>, CellMap>;

enum class PictureFormat { svg, png, pdf };

enum class PaperWidth { one_column, two_columns };

// Without gnuplot the SVG of a page says why there is no chart, and all others are empty. A note goes to standard
// error.

/// For a page: `width` by `height` pixels a chart; a PNG has twice the pixels each way.
std::string draw(const Drawing& drawing, PictureFormat format, int width, int height);
/// For a paper: 84 mm or 174 mm wide, fonts of 8 points, which a PDF embeds, and the names above the curves.
/// Lines of colours that are alike in grey differ in their dashes.
std::string draw_for_paper(const Drawing& drawing, PictureFormat format, PaperWidth width);

/// Colours that stay apart for colour-blind readers (Okabe and Ito), by index; they repeat after `series_colors`.
inline constexpr std::size_t series_colors = 7;
std::string series_color(std::size_t index);

}  // namespace tactor
