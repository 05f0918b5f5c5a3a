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

BOOST_AUTO_TEST_CASE(a_name_in_backticks_is_drawn_and_not_run) {
  const std::filesystem::path trace = std::filesystem::temp_directory_path() / "tactor-chart-test-trace";
  std::filesystem::remove(trace);
  Chart chart{"it's \"a\" \\ title", "", "N", {}, {}};
  chart.curves.push_back({"`touch " + trace.string() + "`", {0, 1}, {0, 1}, series_color(0)});
  const std::string svg = draw_svg({chart}, 400, 200);
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
        const std::string svg = draw_svg({chart, whole}, 400, 200);
        BOOST_TEST(svg.find("</svg>") != std::string::npos);
      }
    }
  }
  const Chart empty{"", "", "N", {}, {}};
  BOOST_TEST(draw_svg({empty}, 400, 200).find("no values") != std::string::npos);
}

BOOST_AUTO_TEST_CASE(a_figure_tells_the_script_of_the_page_where_its_axes_are) {
  Chart chart{"t", "x", "y", {{"<a>", {1, 10}, {2, 4}, series_color(0)}, {"", {1}, {3}, series_color(1), true}}, {}};
  chart.log_x = true;
  const std::string figure = chart_figure({chart}, 400, 200);
  BOOST_TEST(figure.find("<svg data-charts=\"[{&quot;curves&quot;:[{&quot;color&quot;:&quot;#0072B2&quot;,"
                         "&quot;name&quot;:&quot;&lt;a&gt;&quot;}") != std::string::npos);
  BOOST_TEST(figure.find("1.0,10.0,2.0,4.0]") != std::string::npos);  // the ends of the axes, behind the frame's places
  BOOST_TEST(figure.find("&quot;log&quot;:[true,false]") != std::string::npos);
  // A curve with bars has marks too.
  chart.curves.front().x_low = chart.curves.front().x_high = chart.curves.front().x;
  chart.curves.front().y_low = chart.curves.front().y_high = chart.curves.front().y;
  BOOST_TEST(chart_figure({chart}, 400, 200).find("&quot;mark&quot;:0,&quot;name&quot;:&quot;&lt;a&gt;&quot;}") !=
             std::string::npos);
  // The script cannot draw rings, so gnuplot's picture stays.
  chart.curves.front().ring = true;
  BOOST_TEST(chart_figure({chart}, 400, 200).find("data-charts") == std::string::npos);
}

BOOST_AUTO_TEST_SUITE_END()
