// Figures of pages: what a page tells of them is what they are, whatever their names hold.
#include "app/report/figure.hpp"

#include <boost/test/unit_test.hpp>
#include <limits>
#include <sstream>
#include <string>
#include <variant>
#include <vector>

#include "framework/core/check.hpp"

BOOST_AUTO_TEST_SUITE(figure_test)

using namespace tactor;

namespace {

Chart chart_with(std::string name, std::vector<Curve> curves) {
  Chart chart{"title", "time s", "force, N", std::move(curves), {}};
  chart.name = std::move(name);
  return chart;
}

CellMap small_map() {
  CellMap map{"t",
              "k_0",
              "delay",
              {"1", "2"},
              {"a", "b"},
              {{"stable", "#ffffff", "S"}, {"energy", "#000000", "E"}},
              {{0, 1}, {-1, 0}},
              {{1, 0}}};
  map.name = "map";
  return map;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

/// How bright a colour `#rrggbb` is, 0 to 255: another formula than ours, that of linear light (ITU-R BT.709).
double luminance(const std::string& color) {
  const auto linear = [&](std::size_t at) {
    return std::pow(std::stoi(color.substr(at, 2), nullptr, 16) / 255.0, 2.2);
  };
  return 255 * std::pow(0.2126 * linear(1) + 0.7152 * linear(3) + 0.0722 * linear(5), 1 / 2.2);
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_page_gives_back_the_charts_that_went_into_it) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Curve steps{"</script><b> \"a\", 'b'", {0.001, 0.002, 0.003}, {1, nan, -3.25}, "#D55E00"};
  steps.steps = true;
  steps.dash = 2;
  steps.width = 0.5;
  Curve bars{"", {0.001, 0.002, 0.003}, {4, 5, 6}, "#000000", true, 3, true};
  bars.x_low = bars.x_high = bars.x;
  bars.y_low = {3, 4, 5};
  bars.y_high = {5, 6, 7};
  Chart first = chart_with("first", {steps, bars}), second = chart_with("second", {bars});
  first.x_range = {0, 0.004};
  first.log_y = second.close = second.log_x = true;
  second.curves.front().ring = true;
  const std::string html =
      figure_html("<svg></svg>", std::vector<Chart>{first, second}, 100) + figure_html("<svg></svg>", small_map(), 100);
  BOOST_TEST(html.find("<b>") == std::string::npos);
  const std::vector<NamedFigure> figures = figures_of("<html>" + html + "</html>");
  BOOST_REQUIRE(figures.size() == 3U);
  BOOST_TEST(figures[0].name == "first");
  BOOST_TEST(figures[1].name == "second");
  BOOST_TEST(figures[2].name == "map");
  const Chart& one = std::get<std::vector<Chart>>(figures[0].drawing).front();
  BOOST_TEST(one.title == "title");
  BOOST_TEST(one.x_label == "time s");
  BOOST_TEST(one.y_label == "force, N");
  BOOST_TEST((one.x_range == first.x_range));
  BOOST_TEST((one.log_y && !one.log_x && !one.close));
  BOOST_TEST(one.curves[0].name == steps.name);
  BOOST_TEST(one.curves[0].x == steps.x);
  BOOST_TEST(one.curves[0].y[2] == -3.25);
  BOOST_TEST(std::isnan(one.curves[0].y[1]));
  BOOST_TEST((one.curves[0].steps && one.curves[0].dash == 2 && one.curves[0].width == 0.5 &&
              one.curves[0].color == "#D55E00"));
  BOOST_TEST(
      (one.curves[1].points && one.curves[1].hollow && one.curves[1].mark == 3 && one.curves[1].y_high == bars.y_high));
  const Chart& other = std::get<std::vector<Chart>>(figures[1].drawing).front();
  BOOST_TEST((other.close && other.log_x && other.curves[0].ring));
  const auto& map = std::get<CellMap>(figures[2].drawing);
  BOOST_TEST((map.kind == small_map().kind && map.framed == small_map().framed && map.x == small_map().x));
  BOOST_TEST(map.kinds[1].name == "energy");
}

BOOST_AUTO_TEST_CASE(a_page_that_was_cut_or_changed_is_refused) {
  const std::string html =
      figure_html("<svg></svg>", std::vector<Chart>{chart_with("c", {{"a", {1, 2}, {3, 4}}})}, 100);
  for (std::size_t length = html.find("{\"charts\""); length + 20 < html.size(); ++length) {
    BOOST_CHECK_THROW(figures_of(html.substr(0, length)), InputError);
    BOOST_CHECK_THROW(figures_of(html.substr(0, length) + "</script>"), InputError);
  }
  for (const auto& [what, instead] : {std::pair{"[3.0,4.0]", "[3.0]"},
                                      {"\"x\":0", "\"x\":7"},
                                      {"\"x\":0", "\"x\":-1"},
                                      {"\"charts\"", "\"carts\""},
                                      {"[3.0,4.0]", "\"no\""}}) {
    std::string changed = html;
    const std::size_t at = changed.find(what);
    BOOST_REQUIRE(at != std::string::npos);
    changed.replace(at, std::string(what).size(), instead);
    BOOST_CHECK_THROW(figures_of(changed), InputError);
  }
  BOOST_TEST(figures_of("<html></html>").empty());
}

BOOST_AUTO_TEST_CASE(a_page_cannot_make_gnuplot_run_anything) {
  Curve bars{"b", {7}, {8}, "#123456"};
  bars.x_low = bars.x_high = {7};
  bars.y_low = bars.y_high = {8};
  const std::string html = figure_html("<svg></svg>", std::vector<Chart>{chart_with("c", {bars})}, 100) +
                           figure_html("<svg></svg>", small_map(), 100);
  BOOST_TEST(figures_of(html).size() == 2U);
  for (const auto& [what, instead] : {std::pair{"#123456", "#aabbcc`touch x`"},
                                      {"#123456", "red"},
                                      {"#123456", "#12345g"},
                                      {"\"#ffffff\"", "\"#fff'\\nsystem 'touch x'\\n#\""},
                                      {"\"S\"", "\"s\\nEOD\\nsystem 'touch x'\""},
                                      {"\"S\"", "\"`\""},
                                      {"\"y_low\":[8.0]", "\"other\":[8.0]"},
                                      {"\"y_low\":[8.0]", "\"y_low\":[]"},
                                      {"\"x_low\":[7.0]", "\"other\":[7.0]"}}) {
    std::string changed = html;
    const std::size_t at = changed.find(what);
    BOOST_REQUIRE(at != std::string::npos);
    changed.replace(at, std::string(what).size(), instead);
    BOOST_CHECK_THROW(figures_of(changed), InputError);
  }
}

BOOST_AUTO_TEST_CASE(figures_of_one_name_are_numbered) {
  const Chart chart = chart_with("a", {{"c", {1}, {2}}});
  const std::vector<NamedFigure> figures =
      figures_of(figure_html("<svg></svg>", std::vector<Chart>{chart, chart}, 100));
  BOOST_TEST(figures.at(0).name == "a");
  BOOST_TEST(figures.at(1).name == "a_2");
}

BOOST_AUTO_TEST_CASE(csv_has_a_row_a_value_and_quotes_names) {
  Curve bars{"b", {7}, {8}};
  bars.x_low = {6};
  bars.x_high = {7.5};
  bars.y_low = bars.y_high = {8};
  const Curve line{"a, \"x\"", {0.5, 1}, {2, std::numeric_limits<double>::infinity()}};
  BOOST_TEST(
      lines_of(figure_csv(std::vector<Chart>{chart_with("c", {line})})) ==
          (std::vector<std::string>{"curve,time s,\"force, N\"", "\"a, \"\"x\"\"\",0.5,2", "\"a, \"\"x\"\"\",1,"}),
      boost::test_tools::per_element());
  BOOST_TEST(lines_of(figure_csv(std::vector<Chart>{chart_with("c", {line}), chart_with("d", {bars})})) ==
                 (std::vector<std::string>{"chart,curve,x,y,x_low,x_high,y_low,y_high", "c,\"a, \"\"x\"\"\",0.5,2,,,,",
                                           "c,\"a, \"\"x\"\"\",1,,,,,", "d,b,7,8,6,7.5,8,8"}),
             boost::test_tools::per_element());
  BOOST_TEST(lines_of(figure_csv(small_map())) ==
                 (std::vector<std::string>{"k_0,delay,kind", "1,a,stable", "2,a,energy", "2,b,stable"}),
             boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(lines_for_a_paper_can_be_told_apart_in_grey) {
  std::vector<Curve> curves;
  for (std::size_t i = 0; i < series_colors; ++i)
    curves.push_back({"m" + std::to_string(i), {0, 1}, {0, static_cast<double>(i)}, series_color(i)});
  const std::string svg =
      draw_for_paper(std::vector<Chart>{chart_with("c", curves)}, PictureFormat::svg, PaperWidth::one_column);
  // gnuplot gives each line its group, with the dashes on the path.
  std::vector<std::pair<double, std::string>> looks;
  for (std::size_t i = 0; i < series_colors; ++i) {
    const std::size_t group = svg.find("id=\"gnuplot_plot_" + std::to_string(i + 1) + "a\"");
    BOOST_REQUIRE(group != std::string::npos);
    const std::string path = svg.substr(svg.find("<path", group), 300);
    const std::string line = path.substr(0, path.find("/>"));
    const std::size_t dash = line.find("stroke-dasharray='");
    looks.emplace_back(luminance(series_color(i)),
                       dash == std::string::npos ? "" : line.substr(dash, line.find('\'', dash + 18) - dash));
  }
  for (std::size_t i = 0; i < looks.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k)
      BOOST_TEST((std::abs(looks[i].first - looks[k].first) > 25 || looks[i].second != looks[k].second),
                 i << " and " << k);
  }
}

BOOST_AUTO_TEST_SUITE_END()
