// Charts: what gnuplot makes of the texts it is given.
#include "app/report/chart.hpp"

#include <boost/test/unit_test.hpp>
#include <filesystem>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

BOOST_AUTO_TEST_SUITE(chart_test)

using namespace tactor;

namespace {
std::string svg_of(const std::vector<Chart>& charts) {
  return draw(charts, PictureFormat::svg, 400, 200);
}
}  // namespace

BOOST_AUTO_TEST_CASE(a_name_in_backticks_is_drawn_and_not_run) {
  const std::filesystem::path trace = std::filesystem::temp_directory_path() / "tactor-chart-test-trace";
  std::filesystem::remove(trace);
  Chart chart{"it's \"a\" \\ title", "", "N", {}, {}};
  chart.curves.push_back({"`touch " + trace.string() + "`", {0, 1}, {0, 1}, series_color(0)});
  const std::string svg = svg_of({chart});
  BOOST_TEST(!std::filesystem::exists(trace));
  BOOST_TEST(svg.find("`touch ") != std::string::npos);
  BOOST_TEST(svg.find("it's \"a\" \\ title") != std::string::npos);
}

BOOST_AUTO_TEST_CASE(a_chart_without_a_value_or_with_one_alone_is_drawn) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<Curve> curves;
  const auto add = [&curves](std::vector<double> x, std::vector<double> y) {
    curves.push_back({"c", std::move(x), std::move(y), series_color(0)});
  };
  add({}, {});
  add({0.5}, {nan});
  add({0.5}, {0});
  add({0.5}, {1});
  add({-3, 3}, {1, 1});   // before the frame and behind it
  add({-3, -2}, {1, 2});  // outside
  add({0.5, 0.6}, {-1, 0});
  for (const Curve& curve : curves) {
    for (const auto& range : std::vector<std::optional<std::pair<double, double>>>{{}, {{0, 1}}, {{0, 0}}, {{0, -1}}}) {
      for (int axes = 0; axes < 8; ++axes) {
        Chart chart{"", "", "N", {curve}, range};
        chart.log_x = (axes & 1) != 0;
        chart.log_y = (axes & 2) != 0;
        chart.close = (axes & 4) != 0;
        if (chart.log_x && range && !(range->first > 0)) continue;  // nobody asks for it
        Chart whole{"", "", "N", {{"c", {0, 1}, {0, 1}, series_color(0)}}, {}};
        const std::string svg = svg_of({chart, whole});
        BOOST_TEST(svg.find("</svg>") != std::string::npos);
      }
    }
  }
  const Chart empty{"", "", "N", {}, {}};
  BOOST_TEST(svg_of({empty}).find("no values") != std::string::npos);
}

BOOST_AUTO_TEST_CASE(each_format_is_drawn_for_a_page_and_for_a_paper) {
  const std::vector<Chart> charts{{"t", "x", "y", {{"a", {0, 1}, {0, 1}}}, {}}};
  const CellMap map{"t", "x", "y", {"1"}, {"2"}, {{"stable", "#ffffff", "S"}}, {{0}}, {}};
  for (const auto& [format, begin] :
       {std::pair{PictureFormat::svg, "<svg"}, {PictureFormat::png, "\x89PNG"}, {PictureFormat::pdf, "%PDF-"}}) {
    for (const Drawing& drawing : {Drawing(charts), Drawing(map)}) {
      BOOST_TEST(draw(drawing, format, 400, 200).starts_with(begin));
      for (const PaperWidth width : {PaperWidth::one_column, PaperWidth::two_columns})
        BOOST_TEST(draw_for_paper(drawing, format, width).starts_with(begin));
    }
  }
}

BOOST_AUTO_TEST_SUITE_END()
