// Charts: what gnuplot makes of the texts it is given.
#include "app/report/chart.hpp"

#include <boost/test/unit_test.hpp>
#include <filesystem>

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
