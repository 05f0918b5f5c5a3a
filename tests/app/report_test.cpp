// What reports say first, and what their tables mark.
#include <boost/test/unit_test.hpp>
#include <functional>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "app/report/figure.hpp"
#include "app/report/html_page.hpp"
#include "app/report/method_style.hpp"
#include "app/report/run_report.hpp"
#include "app/run/headline.hpp"
#include "app/study/report/compare_report.hpp"
#include "app/study/report/study_report.hpp"
#include "app/study/report/verdict.hpp"
#include "framework/core/stability.hpp"
#include "tests/support/page_text.hpp"

BOOST_AUTO_TEST_SUITE(report_test)

using namespace tactor;
using namespace tactor::test;

namespace {

constexpr double nan_ = std::numeric_limits<double>::quiet_NaN();
const std::string rms = "delivered.force.rms_error_N";
const std::string roughness = "delivered.force.rms_d2_N_per_ms2";
const std::string delay = "delivered.force.delay_ms";

using Values = std::vector<std::vector<double>>;  // [column][seed]

/// Columns of error, roughness, delay and CPU time, and one that has no direction.
Comparison comparison(std::size_t seeds) {
  Comparison c;
  for (std::size_t s = 0; s < seeds; ++s) c.seeds.push_back(s + 1);
  c.columns = {{rms, "error"}, {roughness, "2nd diff"}, {delay, "delay"}, {"cpu_ms_per_s", "CPU", true}, {"n", "n"}};
  for (const MetricInfo& info : {MetricInfo{rms, "N", "RMS error <of the force>", Better::lower},
                                 MetricInfo{roughness, "N/ms^2", "RMS second difference", Better::lower},
                                 MetricInfo{delay, "ms", "delay behind it", Better::lower},
                                 MetricInfo{"cpu_ms_per_s", "ms/s", "CPU time", Better::lower},
                                 MetricInfo{"n", "1", "a number", Better::neither}}) {
    c.declared.emplace(info.name, info);
  }
  return c;
}

CompareRow& add_row(Comparison& c, const std::string& name, Values values) {
  CompareRow row;
  row.graph = name;
  row.values = std::move(values);
  row.runs.resize(c.seeds.size());
  row.status.assign(c.seeds.size(), RunStatus::done);
  row.message.assign(c.seeds.size(), "");
  row.spread.assign(c.seeds.size(), nan_);
  row.control_us.assign(c.seeds.size(), 1000);
  c.rows.push_back(std::move(row));
  return c.rows.back();
}

void fail(CompareRow& row, std::size_t seed) {
  row.status[seed] = RunStatus::failed;
  row.message[seed] = "it broke";
  for (std::vector<double>& column : row.values) column[seed] = nan_;
}

std::string verdict_of(const Comparison& c, const TimingNote& timing = {}) {
  return text_of(verdict_html(c, timing));
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

/// Four values, then the first two again.
Values six(Values four) {
  for (std::vector<double>& values : four) values.insert(values.end(), {values[0], values[1]});
  return four;
}

// The second is nearest, in force and in time, the first smoothest; their costs tie.
Comparison six_seeds() {
  Comparison c = comparison(6);
  add_row(c, "off", six({{0.4, 0.5, 0.4, 0.5}, {1, 1.1, 1, 1.1}, {20, 21, 20, 21}, {9, 11, 10, 10}, {1, 2, 3, 4}}));
  add_row(c, "local", six({{0.1, 0.2, 0.1, 0.2}, {2, 2.1, 2, 2.1}, {1, 2, 1, 2}, {10, 9.5, 11, 9.4}, {2, 2, 3, 4}}));
  return c;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_verdict_names_the_nearest_the_smoothest_and_what_each_costs) {
  const std::string text = verdict_of(six_seeds());
  says(text,
       "local is nearest to the reference: RMS error 0.150 ± 0.0548 N; next is off with 0.450 ± 0.0548 N, 3.0 "
       "times as much.");
  says(text, "off is smoothest: RMS second difference 1.05 ± 0.0548 N/ms²; next is local with");
  says(text, "local is nearest in time: delay 1.50 ± 0.548 ms");
  says(text, "CPU time for each second of the run: local 9.90 ± 0.600 ms/s and off 10 ± 0.894 ms/s.");
  says_not(text, "chance");
}

BOOST_AUTO_TEST_CASE(a_difference_within_the_spread_of_the_seeds_is_a_tie) {
  Comparison c = six_seeds();
  add_row(c, "blend",
          six({{0.2, 0.1, 0.2, 0.11}, {nan_, nan_, nan_, nan_}, {30, 30, 30, 30}, {50, 50, 50, 50}, {1, 1, 1, 1}}));
  const std::string text = verdict_of(c);
  says(text,
       "local (0.150 ± 0.0548 N) and blend (0.152 ± 0.0531 N) are nearest to the reference by their RMS error, a tie "
       "within the spread of the seeds; next is off");
  says(text, "No RMS second difference is reported of blend.");
}

BOOST_AUTO_TEST_CASE(where_all_tie_no_method_is_called_the_best) {
  Comparison c = comparison(1);
  add_row(c, "a", {{0.1}, {1}, {1}, {10}, {1}});
  add_row(c, "b", {{0.10001}, {2}, {nan_}, {10}, {1}});
  const std::string text = verdict_of(c);
  says(text, "No method is nearer to the reference than the others, a tie: RMS error 0.100 N.");
  says(text, "a has the least RMS second difference: 1 N/ms²");
  says(text, "Only a has a value of delay: 1 ms. No delay is reported of b.");
  says(text, "With one seed, it is unknown how much of this is chance.");
}

BOOST_AUTO_TEST_CASE(few_seeds_tie_where_they_do_not_agree) {
  Comparison c = comparison(2);
  add_row(c, "a", {{0.1, 0.2}, {1, 1}, {1, 1}, {10, 10}, {1, 1}});
  add_row(c, "b", {{0.2, 0.5}, {2, 0.9}, {2, 3}, {20, 20}, {1, 1}});
  const std::string text = verdict_of(c);
  says(text, "a has the least RMS error: 0.150 ± 0.0707 N; next is b");
  says(text, "No method is smoother than the others");
  says(text, "With 2 seeds, differences may be chance; 6 can be tested.");
}

BOOST_AUTO_TEST_CASE(a_row_that_lacks_seeds_is_not_ranked_and_a_metric_that_nobody_has_is_told) {
  Comparison c = six_seeds();
  const Values zero(5, std::vector<double>(6, 0));
  add_row(c, "broken", zero);
  for (std::size_t s = 0; s < 6; ++s) fail(c.rows.back(), s);
  fail(add_row(c, "partly", zero), 2);
  for (CompareRow& row : c.rows) row.values[2].assign(6, nan_);
  const std::string text = verdict_of(c);
  says(text, "local is nearest to the reference");
  says(text, "No method is called nearest in time: no run reports its delay.");
  says(text, "Not ranked, because every run failed: broken.");
  says(text, "the seeds that are missing may be the hard ones: partly (5 of 6 seeds).");
  // A seed that all lack costs nobody its rank.
  Comparison all = six_seeds();
  for (CompareRow& row : all.rows) fail(row, 1);
  says(verdict_of(all), "local (5 of 6 seeds) has the least RMS error");
}

BOOST_AUTO_TEST_CASE(without_another_graph_or_without_contact_nothing_is_compared) {
  Comparison one = comparison(1);
  add_row(one, "a", {{0.1}, {1}, {1}, {10}, {1}});
  const std::string alone = verdict_of(one);
  says(alone,
       "One graph was run: there is nothing to compare it with. a: RMS error 0.100 N, RMS second difference 1 N/ms², "
       "delay 1 ms and CPU time 10 ms/s.");
  BOOST_TEST(ranking(one, 0).best.empty());

  Comparison untouched = six_seeds();
  for (CompareRow& row : untouched.rows) {
    for (RunResult& run : row.runs) run.metrics = {{"collision.touching_queries", 0}};
  }
  const std::string text = verdict_of(untouched);
  says(text, "No method can be ranked: nothing is compared.");
  says(text, "Not ranked, because nothing touches: off and local.");
  says_not(text, "nearest");

  Comparison unlike = six_seeds();
  unlike.rows[1].unlike = "its scene is another";
  says(verdict_of(unlike), "Only off can be ranked: nothing is compared.");
  says(verdict_of(unlike), "Not ranked, because more than the method differs: local.");
  TimingNote noisy;
  noisy.warning = "not quiet";
  says(verdict_of(six_seeds(), noisy), "the machine was not quiet, so take these with care.");
}

BOOST_AUTO_TEST_CASE(a_row_without_a_reference_is_left_out_of_every_ranking_and_said_to_be) {
  Comparison c = six_seeds();
  add_row(c, "blind", six({{nan_, nan_, nan_, nan_}, {0.1, 0.2, 0.1, 0.2}, {0, 0, 0, 0}, {1, 1, 1, 1}, {1, 2, 3, 4}}));
  const std::string text = verdict_of(c);
  says(text, "local is nearest to the reference");
  says(text, "off is smoothest");
  says(text, "local is nearest in time");
  says(text, "Not ranked, because no reference judged the runs: blind.");
  for (std::size_t column = 0; column < 4; ++column) BOOST_TEST(ranking(c, column).rows.size() == 2U);
  // The reference of one run is enough: a method may have no force to be judged.
  c.rows[2].runs[3].metrics = {{"reference.rate_hz", 10000}};
  says(verdict_of(c), "blind is smoothest");
}

BOOST_AUTO_TEST_CASE(the_best_are_those_of_the_declared_direction) {
  Comparison c = comparison(1);
  add_row(c, "a", {{3}, {1}, {1}, {10}, {5}});
  add_row(c, "b", {{2}, {1}, {1}, {10}, {6}});
  add_row(c, "c", {{1}, {2}, {nan_}, {10}, {7}});
  const auto best = [&c](std::size_t column) { return ranking(c, column).best; };
  BOOST_TEST(best(0) == std::vector<std::size_t>{2}, boost::test_tools::per_element());
  BOOST_TEST(best(1) == (std::vector<std::size_t>{0, 1}), boost::test_tools::per_element());
  BOOST_TEST(best(2) == (std::vector<std::size_t>{0, 1}), boost::test_tools::per_element());
  BOOST_TEST(best(4).empty());
  c.declared.find(rms)->second.better = Better::higher;
  BOOST_TEST(best(0) == std::vector<std::size_t>{0}, boost::test_tools::per_element());
  // A force that is 5 ms early is worse than one that is 2 ms late.
  c.declared.find(delay)->second.better = Better::near_zero;
  c.rows[0].values[2] = {-5};
  c.rows[1].values[2] = {2};
  c.rows[2].values[2] = {3};
  BOOST_TEST(best(2) == std::vector<std::size_t>{1}, boost::test_tools::per_element());
  BOOST_TEST(ranking(c, 2).rows == (std::vector<std::size_t>{1, 2, 0}), boost::test_tools::per_element());
  says(compare_report(c, {}), "→0");
}

namespace {

/// Rows of `methods` methods, each a tenth worse than the one before, with a spread over the seeds that hides nothing.
Comparison many(std::size_t methods, std::size_t seeds) {
  Comparison c = comparison(seeds);
  for (std::size_t m = 0; m < methods; ++m) {
    std::vector<double> values;
    for (std::size_t s = 0; s < seeds; ++s)
      values.push_back((1 + 0.1 * static_cast<double>(m)) * (1 + 1e-3 * static_cast<double>((s * 7 + m) % 5)));
    add_row(c, "m" + std::to_string(m), Values(5, values));
  }
  return c;
}

struct Misleading {
  const char* what;
  std::function<void(Comparison&)> make;
  std::vector<const char*> says, says_not;  ///< of any number of methods and seeds
  std::size_t best_from = 99;               ///< of so many methods six seeds tell the best one
};

}  // namespace

BOOST_AUTO_TEST_CASE(no_report_says_more_than_its_runs_tell) {
  const std::vector<Misleading> cases{
      {"as it is", [](Comparison&) {}, {"least error"}, {"nothing touches", "no error"}, 2},
      {"identical rows",
       [](Comparison& c) {
         for (CompareRow& row : c.rows) row.values = c.rows.front().values;
       },
       {"tied for the least error"},
       {"× the least error"}},
      {"seeds that are copies",
       [](Comparison& c) {
         for (CompareRow& row : c.rows) {
           for (std::vector<double>& by_seed : row.values) by_seed.assign(by_seed.size(), by_seed.front());
           row.identical_seeds = true;
         }
       },
       {},
       {}},
      {"nothing touches",
       [](Comparison& c) {
         for (CompareRow& row : c.rows) {
           for (RunResult& run : row.runs) run.metrics = {{"collision.touching_queries", 0}};
         }
       },
       {"nothing touches"},
       {"× the least error", "tied for"}},
      {"no truth that is finer",
       [](Comparison& c) {
         for (CompareRow& row : c.rows) {
           row.too_coarse = "why";
           row.values[0].assign(row.values[0].size(), nan_);
         }
       },
       {"no error: the reference is no finer than the run"},
       {"× the least error", "tied for", "(least)"}},
      {"no reference",
       [](Comparison& c) {
         for (CompareRow& row : c.rows) row.values[0].assign(row.values[0].size(), nan_);
       },
       {"No method is ranked.", "Not ranked, because no reference judged the runs: m0",
        "no error: no reference judged the runs"},
       {"× the least error", "tied for", "(least)", "smoothest", "nearest", "Pareto front"}},
      {"every run of the best failed",
       [](Comparison& c) {
         for (std::size_t s = 0; s < c.seeds.size(); ++s) fail(c.rows.front(), s);
       },
       {"every run failed"},
       {},
       3},
      {"another coupling",
       [](Comparison& c) {
         for (std::size_t m = 1; m < c.rows.size(); ++m) c.rows[m].unlike = "its coupling differs";
       },
       {"not ranked: another scene or coupling", "nothing to compare with"},
       {"× the least error", "tied for"}},
  };
  for (const Misleading& one : cases) {
    for (const std::size_t methods : {2U, 6U, 40U}) {
      for (const std::size_t seeds : {1U, 2U, 20U}) {
        BOOST_TEST_CONTEXT(one.what << ", methods: " << methods << ", seeds: " << seeds) {
          Comparison c = many(methods, seeds);
          one.make(c);
          const std::string html = compare_report(c, {}), text = text_of(html.substr(html.find("</style>")));
          for (const char* said : one.says) says(text, said);
          for (const char* said : one.says_not) says_not(text, said);
          const std::size_t marked = count(html, "aria-label=\"best\"");
          BOOST_TEST((marked > 0) == (methods >= one.best_from && seeds >= 6));
          if (seeds < 6) {
            for (const char* tested : {"95 %", "Wilcoxon", "ANOVA", "★"}) says_not(text, tested);
            says(text, seeds == 1 ? "one seed has no spread" : "nothing is tested with fewer than 6 seeds");
          }
          if (seeds == 1) says_not(text, "±");
        }
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(a_cell_says_how_near_a_method_is_and_names_no_winner_within_noise) {
  const auto cells = [](const Comparison& c) {
    std::vector<std::string> texts;
    for (std::size_t row = 0; row < c.rows.size(); ++row) texts.push_back(verdict_text(c, row));
    return texts;
  };
  const auto are = [&](const Comparison& c, const std::vector<std::string>& expected) {
    BOOST_TEST(cells(c) == expected, boost::test_tools::per_element());
  };
  Comparison c = six_seeds();
  are(c, {"3.00 × the least error", "least error"});
  const std::string alone = "nothing to compare with";
  c.rows[0].unlike = "its coupling differs";
  are(c, {"not ranked: another scene or coupling", alone});
  c = six_seeds();
  c.rows[0].too_coarse = "why";
  are(c, {"no error: the reference is no finer than the run", alone});
  c = six_seeds();
  fail(c.rows[1], 3);
  are(c, {alone, "not ranked: runs failed"});
  for (std::size_t s = 0; s < 6; ++s) {
    if (s != 3) fail(c.rows[1], s);
  }
  are(c, {alone, "every run failed"});
  // The differences have either sign, or the runs of all seeds are the same.
  c = six_seeds();
  add_row(c, "blend", six({{0.2, 0.1, 0.2, 0.11}, {1, 1, 1, 1}, {1, 1, 1, 1}, {1, 1, 1, 1}, {1, 1, 1, 1}}));
  are(c, {"3.00 × the least error", "tied for the least error", "tied for the least error"});
  // However small a difference is, the seeds may show it; however large, it can be read.
  c = six_seeds();
  c.rows[0].values[0] = {0.102, 0.203, 0.102, 0.203, 0.102, 0.203};
  are(c, {"a little above the least error", "least error"});
  for (double& v : c.rows[0].values[0]) v *= 200;
  are(c, {"203 × the least error", "least error"});
  c = six_seeds();
  for (CompareRow& row : c.rows) row.identical_seeds = true;
  are(c, {"3.00 × the least error", "least error, not tested"});
  // Of few seeds no method is the winner, in no part of the page.
  for (const std::size_t seeds : {1U, 2U, 5U}) {
    Comparison few = comparison(seeds);
    const auto row = [&](double v) { return Values(5, std::vector<double>(seeds, v)); };
    add_row(few, "off", row(0.3));
    add_row(few, "local", row(0.1));
    are(few, {"3.00 × the least error", "least error, not tested"});
    const std::string html = compare_report(few, {});
    BOOST_TEST(count(html, "aria-label=\"best\"") == 0U);
    says_not(text_of(html), "nearest");
    says_not(text_of(html), "(least)");
  }
  c = six_seeds();
  for (RunResult& run : c.rows[1].runs) run.metrics = {{"collision.touching_queries", 0}};
  are(c, {alone, "nothing touches"});
  BOOST_TEST(count(compare_report(c, {}), "aria-label=\"best\"") == 0U);
  c = comparison(1);
  add_row(c, "a", {{nan_}, {1}, {1}, {1}, {1}});
  are(c, {"no error: no reference judged the runs"});
  c.rows[0].runs[0].metrics = {{"reference.rate_hz", 10000}};
  are(c, {"no error is known"});
}

BOOST_AUTO_TEST_CASE(the_page_of_a_comparison_shows_error_and_cost_first_and_folds_the_rest) {
  Comparison c = six_seeds();
  const std::string html = compare_report(c, {});
  const std::string first = html.substr(0, html.find("<details>"));
  says(first, "Error against run time");
  says(first, "3.00 × the least error");
  says_not(first, "nearest to the reference");
  const std::size_t chart = first.find("Error against run time"), table = first.find("<table");
  BOOST_TEST(chart < table);
  // Six rows: what is not reported is told so.
  BOOST_TEST(count(first, "<tr><th scope=\"row\">") == 6U);
  says(first, "<tr><th scope=\"row\">vibration over what is felt</th>");
  // Error, roughness and delay have one in both tables. The costs tie, and the number has no direction.
  BOOST_TEST(count(html, "class=\"value best\"") == 6U);
  BOOST_TEST(count(html, "aria-label=\"best\"") == 6U);
  says(html, "<abbr tabindex=\"0\" title=\"RMS error &lt;of the force&gt;, N; lower is better\">RMS error N ↓</abbr>");
  says(html, "<i class=\"mark\" style=\"--color:#0072B2\">●</i> local");
  // As many columns as there is room for, in the six rows and among all metrics.
  for (int i = 0; i < 11; ++i) add_row(c, "m" + std::to_string(i), c.rows.front().values);
  const std::string many = compare_report(c, {});
  BOOST_TEST(count(many, "<table class=\"rows even\"") == 4U);
  says(many, "<h1>off, local, m0 and 10 more</h1>");
}

BOOST_AUTO_TEST_CASE(a_method_has_its_colour_on_every_page_and_rows_of_one_colour_differ_in_their_marks) {
  const std::vector<MethodStyle> a = method_styles({"bunny_off", "bunny_local", "mine", "bunny_local_exact"});
  const std::vector<MethodStyle> b = method_styles({"local", "hold", "also mine", "refit stiffness=800"});
  BOOST_TEST(a[1].color == b[0].color);
  BOOST_TEST(a[0].color == b[1].color);
  BOOST_TEST(a[3].color == a[1].color);
  BOOST_TEST(a[3].mark != a[1].mark);
  // Others have what is left.
  for (const MethodStyle& known : {a[0], a[1]}) BOOST_TEST(known.color != a[2].color);
  // Fifty-six rows can be told apart, whatever their names are.
  for (const std::string family : {"m", "local_", "hermite_", "fixed"}) {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < series_colors * mark_shapes; ++i) names.push_back(family + std::to_string(i));
    std::set<std::string> seen;
    for (const MethodStyle& style : method_styles(names)) seen.insert(style.html());
    BOOST_TEST(seen.size() == names.size());
  }
}

BOOST_AUTO_TEST_CASE(a_comparison_says_at_its_top_that_there_are_warnings_and_draws_what_is_not_ranked_hollow) {
  Comparison c = six_seeds();
  says_not(compare_report(c, {}), "#doubts");
  TimingNote noisy;
  noisy.warning = "The machine was not quiet.";
  for (const bool unlike : {true, false}) {
    if (unlike) c.rows[1].unlike = "its coupling differs from that of off in k_0";
    const std::string html = compare_report(c, unlike ? TimingNote{} : noisy);
    const std::string first = html.substr(0, html.find("<details>"));
    says(first.substr(0, first.find("<svg")), "<a class=\"bad\" href=\"#doubts\">1 warning</a>");
    says(first, unlike ? "Warning: local: its coupling differs" : "Warning: The machine was not quiet.");
    if (unlike) says(first, "local (not ranked)");
    c = six_seeds();
  }
  // Rows are named by what they do not share.
  c.rows[0].graph = c.rows[1].graph = "wall";
  c.rows[0].configuration = "hold";
  c.rows[1].configuration = "local";
  says(compare_report(c, {}), "<h1>wall: hold, local</h1>");
  c.rows[0].graph = "wall_hold";
  c.rows[0].configuration.clear();
  says(compare_report(c, {}), "<h1>wall: hold, local</h1>");
}

BOOST_AUTO_TEST_CASE(the_terminal_tells_nothing_of_the_force_of_a_blind_run) {
  RunResult run;
  run.graph = "study";
  run.duration_s = run.planned_s = 1;
  run.wall_s = 0.5;
  run.metrics = {{rms, 0.1}, {delay, 4}, {roughness, 0.002}, {"device.engaged_share", 0.9}};
  run.metrics.emplace_back("stability.verdict", static_cast<double>(StabilityVerdict::limit_cycle));
  run.nodes.push_back({.node = "rollout", .total_s = 1});
  EdgeResult edge;
  edge.edge = "rollout.segment -> select.fourth";
  edge.metrics.dropped = 3;
  run.edges.push_back(edge);
  for (const char* told : {"0.100 N RMS", "4 ms", "rollout", "second difference", "limit cycle"}) {
    says(headline_text(run, "report.html", false, 200), told);
  }
  run.remarks = {"the device displayed less force than was wanted"};
  run.blind = true;
  const std::string text = headline_text(run, "report.html", false, 200);
  for (const char* told : {"0.100 N RMS", "4 ms", "rollout", "second difference", "limit cycle", "--all"})
    says_not(text, told);
  for (const char* told : {"done, 1 s", "let the force through 90 % of the time", "dropped 3 messages", "blind",
                           "the device displayed less force than was wanted"})
    says(text, told);
}

BOOST_AUTO_TEST_CASE(a_script_comes_with_charts_alone_and_is_small) {
  const std::string plain = page("t", ""), figure = chart_figure({{"t", "", "", {{"a", {0}, {0}}}, {}}}, 300, 200);
  const std::string charts = page("t", figure);
  says_not(plain, "<script");
  says(charts, "<script>");
  says(charts, "prefers-color-scheme: dark");
  BOOST_TEST(charts.size() - plain.size() - figure.size() < 12'288U);
}

BOOST_AUTO_TEST_SUITE_END()
