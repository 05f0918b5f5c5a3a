// A figure of a page: its picture, and its data, out of which it can be drawn again.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "app/report/chart.hpp"

namespace tactor {

/// The picture with its data beside it. Where the page may run its script, that draws the charts anew, so that curves
/// can be hidden and zoomed, and saves them as files. `svg`: of the drawing; `height`: of a chart, in pixels.
std::string figure_html(const std::string& svg, const Drawing& drawing, int height);

/// The same, drawn with `width` by `height` pixels a chart.
std::string chart_figure(const std::vector<Chart>& charts, int width, int height);

/// A chart or a map of a page, by the name that it has there.
struct NamedFigure {
  std::string name;
  Drawing drawing;
};

/// The figures of a page in their order, each chart by itself. Throws InputError where one cannot be read.
std::vector<NamedFigure> figures_of(std::string_view page);

/// All values as CSV: `curve` and the two axes, for several charts `chart` before them, and behind them the ends of
/// bars where there are some; for a map `x`, `y` and `kind`.
std::string figure_csv(const Drawing& drawing);

}  // namespace tactor
