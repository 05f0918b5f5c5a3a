// The protocol step by step: what is set when, how answers come in, and that a continued run goes on where it was.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "framework/core/check.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/core/value_error.hpp"
#include "nodes/experiment/protocol.hpp"
#include "tests/support/nodes.hpp"

BOOST_AUTO_TEST_SUITE(protocol_test)

using namespace tactor;
using namespace tactor::test;

namespace {

constexpr Duration look{5'000'000};

Protocol::Params small_study() {
  Protocol::Params params;
  params.participant = "P01";
  params.procedure = Procedure::constant;
  params.conditions = {{"A", "select.use=first; coupling.k_0=500 N/m"},
                       {"B", "select.use=fourth; coupling.k_0=800 N/m"}};
  params.mute = "gain.factor";
  params.level = "gain.factor";
  params.standard = 1;
  params.levels = {0.25, 0.5};
  params.repeats = 2;
  params.interval = Duration::from_seconds(0.1);
  params.change = Duration::from_seconds(0.2);
  params.free_below = 0.05;
  params.button_first = 2;
  params.button_second = 3;
  params.rate = 200;
  return params;
}

/// A protocol that is stepped by hand. What it asks for is made at once, while `makes` is true.
struct Driven {
  explicit Driven(const Protocol::Params& params, bool touching = false)
      : settings(Protocol::settings(params)), node(params, context()) {
    node.wanted.configure({QueuePolicy::drop_oldest, 64});
    node.device.configure({QueuePolicy::drop_oldest, 64});
    node.force.configure({QueuePolicy::latest, 1});
    node.answers.configure({QueuePolicy::drop_oldest, 4});
    node.felt.configure({QueuePolicy::drop_oldest, 64});
    touch(touching ? 1 : 0);
    StepContext c(now);
    node.start(c);
    collect();
  }
  static NodeContext context() {
    static const Scene scene;
    NodeContext context = context_for(scene);
    context.seed = 11;
    return context;
  }
  void touch(double newtons) {
    const Wrench wrench{{0, 0, newtons}, {}};
    node.force.push({now, now, sequence++}, &wrench);
  }
  void step() {
    now = now + look;
    StepContext c(now);
    node.step(c);
    collect();
  }
  void collect() {
    for (std::size_t i = 0; i < node.requests.pending(); ++i) {
      const auto& request = sent(node.requests, i);
      if (request.kind != RequestKind::end_run) ++to_confirm;
      asked.push_back(text_of(request));
      abouts.emplace_back(about_of(request));
    }
    const bool made = makes && to_confirm > confirmed;
    for (std::size_t i = 0; i < node.row.pending(); ++i) rows.push_back(sent(node.row, i));
    if (node.screen.pending() > 0) screen = sent(node.screen, node.screen.pending() - 1);
    if (node.question.pending() > 0) question = sent(node.question);
    node.requests.clear_pending();
    node.row.clear_pending();
    node.screen.clear_pending();
    node.question.clear_pending();
    if (made) confirm(to_confirm);
  }
  [[nodiscard]] std::string text_of(const SetRequest& request) const {
    if (request.kind == RequestKind::end_run) return "end";
    const Setting& setting = settings.list.at(static_cast<std::size_t>(request.setting));
    return request.kind == RequestKind::set ? setting.text() : setting.parameter + "=" + std::to_string(request.number);
  }
  /// As a session does when the settings up to that number hold.
  void confirm(int number) {
    for (; confirmed < number; ++confirmed) node.request_done();
  }
  [[nodiscard]] TrialPhase phase() const { return screen.phase; }
  /// Steps until that phase; false where it does not come within 10 s.
  bool until(TrialPhase wanted) {
    for (int i = 0; i < 2000 && phase() != wanted; ++i) step();
    return phase() == wanted;
  }
  void answer(Protocol::Answer value) {
    Protocol::Params params = small_study();
    params.answer = value;
    node.tune(params);
    step();
  }
  /// All trials, each answered by `answers[i]`, or by 1.
  void run(const std::vector<int>& answers = {}, std::size_t most = 1000) {
    for (std::size_t i = 0; i < most;) {
      until_asked();
      if (phase() == TrialPhase::done) return;
      const bool counts = phase() == TrialPhase::answering;
      const int chosen = counts && i < answers.size() ? answers[i] : 1;
      answer(chosen == 1 ? Protocol::Answer::first : Protocol::Answer::second);
      if (counts) ++i;
    }
  }
  void until_asked() {
    for (int i = 0; i < 2000; ++i) {
      if (phase() == TrialPhase::waiting || phase() == TrialPhase::answering || phase() == TrialPhase::done) return;
      step();
    }
  }

  bool makes = true;
  int to_confirm = 0, confirmed = 0;
  std::vector<std::string> abouts;  // of what was asked
  Time now;
  std::uint64_t sequence = 0;
  ProtocolSettings settings;
  Protocol node;
  std::vector<std::string> asked;
  std::vector<ExperimentRow> rows;
  ExperimentScreen screen;
  ExperimentQuestion question;
};

}  // namespace

BOOST_AUTO_TEST_CASE(what_is_felt_changes_only_while_the_force_is_muted) {
  Driven d(small_study());
  d.run();
  for (int i = 0; i < 100; ++i) d.step();
  double factor = 1;
  double opened = 0;
  int changes = 0;
  for (const std::string& text : d.asked) {
    if (text.starts_with("gain.factor=")) {
      const double next = std::stod(text.substr(12));
      // From an interval back to nothing, and from nothing to an interval.
      if (factor != 1) BOOST_TEST((next == 0) != (factor == 0));
      factor = next;
      opened += factor > 0 ? 1 : 0;
    } else if (text != "end") {
      BOOST_TEST(factor == 0);
      ++changes;
    }
  }
  BOOST_TEST(opened == 2 * 8);
  BOOST_TEST(changes == 4 * 2 * 2 + 4 * 2 * 2);
  BOOST_TEST(d.asked.front() == "gain.factor=0");
  BOOST_TEST(d.asked.back() == "end");
  BOOST_TEST(d.rows.size() == 8U);
}

BOOST_AUTO_TEST_CASE(no_interval_begins_before_all_its_settings_hold) {
  Driven d(small_study());
  d.answer(Protocol::Answer::first);
  d.makes = false;
  const auto settle = [&d] {
    for (int i = 0; i < 200; ++i) d.step();
  };
  settle();
  // The two settings of the condition are asked for; the force stays muted until both hold.
  BOOST_TEST(d.asked.size() == 3U);
  BOOST_TEST(d.abouts[1] == "trial 1, interval 1");
  d.confirm(2);
  settle();
  BOOST_TEST(d.asked.size() == 3U);
  d.confirm(3);
  const Time held = d.now;
  while (d.asked.size() == 3U) d.step();
  // They have had the time `change` since.
  BOOST_TEST((d.now - held).seconds() >= 0.2);
  BOOST_TEST(d.asked.back().starts_with("gain.factor=1"));
  // And the interval waits for the force to be given back.
  settle();
  BOOST_TEST((d.phase() == TrialPhase::changing));
  d.confirm(4);
  d.step();
  BOOST_TEST((d.phase() == TrialPhase::first));
  // A mute that does not hold keeps the second interval shut.
  while (d.phase() == TrialPhase::first) d.step();
  settle();
  BOOST_TEST(d.asked.back() == "gain.factor=0");
  BOOST_TEST((d.phase() == TrialPhase::changing));
}

BOOST_AUTO_TEST_CASE(a_setting_that_is_not_made_ends_the_run_with_its_trial_and_the_table_keeps_the_others) {
  const TemporaryFolder folder;
  Protocol::Params params = small_study();
  params.folder = folder.path().string();
  Driven d(params);
  d.run({1, 2}, 2);
  d.makes = false;
  BOOST_REQUIRE(d.rows.size() == 2U);
  const auto says_where = [](const RunError& error) {
    const std::string said = error.what();
    return said.find("trial 3, interval 1: select.use=") == 0 && said.find("was not made within 5 s") != said.npos;
  };
  BOOST_CHECK_EXCEPTION(for (int i = 0; i < 3000; ++i) d.step(), RunError, says_where);
  std::ifstream file(folder.path() / "P01.csv");
  const std::string text(std::istreambuf_iterator<char>(file), {});
  BOOST_TEST(std::count(text.begin(), text.end(), '\n') == 3);
}

BOOST_AUTO_TEST_CASE(an_interval_begins_only_where_nothing_is_touched) {
  Driven d(small_study(), true);
  d.answer(Protocol::Answer::first);
  BOOST_TEST(d.until(TrialPhase::lift));
  for (int i = 0; i < 200; ++i) d.step();
  BOOST_TEST((d.phase() == TrialPhase::lift));
  d.touch(0.04);
  d.step();
  BOOST_TEST(d.asked.back().starts_with("gain.factor=1"));
  d.step();
  BOOST_TEST((d.phase() == TrialPhase::first));
}

BOOST_AUTO_TEST_CASE(a_button_answers_and_its_time_is_that_of_the_device) {
  Driven d(small_study());
  d.answer(Protocol::Answer::first);
  BOOST_TEST(d.until(TrialPhase::answering));
  const Time asked = d.now;
  const auto press = [&](std::int32_t buttons, Duration after) {
    DeviceState state;
    state.buttons = buttons;
    d.node.device.push({asked + after, asked + after, d.sequence++}, &state);
  };
  press(1, Duration{1'000'000});  // the dead-man button answers nothing
  d.step();
  BOOST_TEST(d.rows.empty());
  press(1 | 4, Duration{7'000'000});
  press(1, Duration{8'000'000});
  press(1 | 2, Duration{9'000'000});  // too late, the question is answered
  d.step();
  BOOST_REQUIRE(d.rows.size() == 1U);
  BOOST_TEST(d.rows[0].response == 2);
  BOOST_TEST(d.rows[0].response_time == 0.007, boost::test_tools::tolerance(1e-9));
  BOOST_TEST(d.rows[0].correct == (d.rows[0].comparison == 2 ? 1 : 0));
}

BOOST_AUTO_TEST_CASE(what_comes_during_an_interval_is_no_answer) {
  Driven d(small_study());
  d.answer(Protocol::Answer::first);
  BOOST_TEST(d.until(TrialPhase::second));
  d.answer(Protocol::Answer::second);
  DeviceState state;
  state.buttons = 2;
  d.node.device.push({d.now, d.now, d.sequence++}, &state);
  BOOST_TEST(d.until(TrialPhase::answering));
  for (int i = 0; i < 10; ++i) d.step();
  BOOST_TEST(d.rows.empty());
}

BOOST_AUTO_TEST_CASE(nothing_changes_before_the_felt_force_has_faded) {
  Driven d(small_study());
  d.answer(Protocol::Answer::first);
  const auto feel = [&](double newtons) {
    const Wrench wrench{{0, 0, newtons}, {}};
    d.node.felt.push({d.now, d.now, d.sequence++}, &wrench);
  };
  feel(0.2);
  for (int i = 0; i < 200; ++i) d.step();
  BOOST_TEST(d.asked.size() == 1U);
  feel(0.04);
  d.step();
  BOOST_TEST(d.asked.size() > 1U);
  // A parameter that does not mute ends the run.
  BOOST_TEST(d.until(TrialPhase::first));
  feel(2);
  BOOST_CHECK_THROW(for (int i = 0; i < 2000; ++i) d.step(), RunError);
}

BOOST_AUTO_TEST_CASE(the_largest_force_of_each_interval_is_kept) {
  Driven d(small_study());
  d.answer(Protocol::Answer::first);
  const auto feel = [&](double newtons) {
    const Wrench wrench{{0, -newtons, 0}, {}};
    d.node.felt.push({d.now, d.now, d.sequence++}, &wrench);
    d.step();
  };
  feel(9);
  feel(0);
  BOOST_TEST(d.until(TrialPhase::first));
  for (const double force : {0.5, 2.0, 1.0}) feel(force);
  feel(0);
  BOOST_TEST(d.until(TrialPhase::second));
  for (const double force : {0.1, 0.3, 0.2}) feel(force);
  BOOST_TEST(d.until(TrialPhase::answering));
  d.answer(Protocol::Answer::first);
  BOOST_REQUIRE(d.rows.size() == 1U);
  BOOST_TEST(d.rows[0].peak_first == 2);
  BOOST_TEST(d.rows[0].peak_second == 0.3);
}

BOOST_AUTO_TEST_CASE(a_device_that_displays_less_than_was_wanted_is_told) {
  Driven d(small_study());
  d.answer(Protocol::Answer::first);
  const auto feel = [&](double wanted, double displayed) {
    const Wrench as_wanted{{0, 0, wanted}, {}}, as_displayed{{0, 0, displayed}, {}};
    d.node.wanted.push({d.now, d.now, d.sequence++}, &as_wanted);
    d.node.felt.push({d.now, d.now, d.sequence++}, &as_displayed);
    d.step();
  };
  feel(9, 3);  // before the interval
  feel(0, 0);
  BOOST_TEST(d.until(TrialPhase::first));
  for (int i = 0; i < 4; ++i) feel(i == 0 ? 4 : 2, i == 0 ? 3 : 2);
  feel(0, 0);
  BOOST_TEST(d.until(TrialPhase::second));
  feel(3, 2.98);  // what rounding and a small vibration make
  feel(0, 0);
  BOOST_TEST(d.until(TrialPhase::answering));
  d.answer(Protocol::Answer::first);
  BOOST_REQUIRE(d.rows.size() == 1U);
  BOOST_TEST(d.rows[0].limited_first == 0.2);
  BOOST_TEST(d.rows[0].limited_second == 0);
  const Report report = report_of(d.node);
  BOOST_REQUIRE(report.remarks().size() == 1U);
  BOOST_TEST(report.remarks()[0].find("in 1 trials the device displayed less force than was wanted") !=
             std::string::npos);
}

BOOST_AUTO_TEST_CASE(a_device_that_displays_less_torque_than_was_wanted_is_told) {
  Driven d(small_study());
  d.answer(Protocol::Answer::first);
  const auto feel = [&](double wanted, double displayed) {
    const Wrench as_wanted{{0, 0, 1}, {0, wanted, 0}}, as_displayed{{0, 0, 1}, {0, displayed, 0}};
    d.node.wanted.push({d.now, d.now, d.sequence++}, &as_wanted);
    d.node.felt.push({d.now, d.now, d.sequence++}, &as_displayed);
    d.step();
  };
  const auto fade = [&] {
    const Wrench none;
    d.node.wanted.push({d.now, d.now, d.sequence++}, &none);
    d.node.felt.push({d.now, d.now, d.sequence++}, &none);
    d.step();
  };
  fade();
  BOOST_TEST(d.until(TrialPhase::first));
  feel(0.04, 0.034);  // 6 mN m less
  feel(0.04, 0.036);  // 4 mN m less
  fade();
  BOOST_TEST(d.until(TrialPhase::second));
  feel(1, 0.994);  // 6 mN m, but a part of 0.006
  fade();
  BOOST_TEST(d.until(TrialPhase::answering));
  d.answer(Protocol::Answer::first);
  BOOST_REQUIRE(d.rows.size() == 1U);
  BOOST_TEST(d.rows[0].limited_first == 1.0 / 3, boost::test_tools::tolerance(1e-12));
  BOOST_TEST(d.rows[0].limited_second == 0);
}

BOOST_AUTO_TEST_CASE(a_continued_run_makes_the_trials_that_were_left) {
  const std::vector<int> answers{1, 2, 2, 1, 2, 1, 1, 2};
  Driven whole(small_study());
  whole.run(answers);
  for (std::size_t done = 0; done < 8; ++done) {
    const TemporaryFolder folder;
    Protocol::Params params = small_study();
    params.folder = folder.path().string();
    std::vector<ExperimentRow> rows;
    {
      Driven first(params);
      first.run(answers, done);
      rows = first.rows;
    }
    BOOST_CHECK_THROW(Driven{params}, InputError);
    params.resume = true;
    Driven second(params);
    second.run({answers.begin() + static_cast<std::ptrdiff_t>(done), answers.end()});
    rows.insert(rows.end(), second.rows.begin(), second.rows.end());
    BOOST_REQUIRE(rows.size() == whole.rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      BOOST_TEST(rows[i].trial == whole.rows[i].trial);
      BOOST_TEST(rows[i].condition == whole.rows[i].condition);
      BOOST_TEST(rows[i].level == whole.rows[i].level);
      BOOST_TEST(rows[i].comparison == whole.rows[i].comparison);
      BOOST_TEST(rows[i].response == whole.rows[i].response);
      BOOST_TEST(rows[i].run == (i < done || done == 0 ? 1 : 2));
    }
    // It is complete, and another study's design does not go on with it.
    BOOST_CHECK_THROW(Driven{params}, InputError);
  }
}

BOOST_AUTO_TEST_CASE(a_table_is_not_continued_by_another_design) {
  using P = Protocol::Params;
  const TemporaryFolder folder;
  P params = small_study();
  params.folder = folder.path().string();
  Driven(params).run({1, 2, 1}, 3);
  params.resume = true;
  const auto refused = [&](const std::string& names, const auto& change) {
    P other = params;
    change(other);
    BOOST_CHECK_EXCEPTION(Driven{other}, InputError, [&](const InputError& error) {
      return std::string(error.what()).find("cannot be continued: " + names + " differ") != std::string::npos;
    });
  };
  refused("levels", [](P& p) { p.levels = {0.25, 0.75}; });
  // None of these changes a trial that was made.
  refused("conditions", [](P& p) { p.conditions[1].second = "select.use=third; coupling.k_0=800 N/m"; });
  refused("interval", [](P& p) { p.interval = Duration::from_seconds(0.2); });
  refused("change, standard", [](P& p) { p.standard = 2, p.change = Duration::from_seconds(0.3); });
  refused("order", [](P& p) { p.order = ConditionOrder::as_listed; });
  refused("mute, level", [](P& p) { p.mute = p.level = "other.factor"; });
  refused("repeats", [](P& p) { p.repeats = 3; });
  // What makes no difference to anybody: spaces, and the parameters of another procedure.
  params.conditions[0].second = " select.use=first ;coupling.k_0=500 N/m;";
  params.reversals = 99;
  BOOST_CHECK_NO_THROW(Driven{params});
}

BOOST_AUTO_TEST_CASE(a_table_of_a_staircase_is_not_continued_by_another_rule) {
  using P = Protocol::Params;
  const TemporaryFolder folder;
  P params = small_study();
  params.folder = folder.path().string();
  params.procedure = Procedure::staircase;
  params.steps = {0.1}, params.least = 0.1, params.start = 0.5, params.most = 1, params.reversals = 20;
  params.averaged = 2;
  Driven(params).run({}, 1);
  params.resume = true;
  const std::vector<std::pair<std::string, void (*)(P&)>> changes{{"start", [](P& p) { p.start = 0.6; }},
                                                                  {"steps",
                                                                   [](P& p) {
                                                                     p.steps = {0.1, 0.05};
                                                                   }},
                                                                  {"down", [](P& p) { p.down = 3; }},
                                                                  {"down_to_up", [](P& p) { p.down_to_up = 0.5; }},
                                                                  {"least", [](P& p) { p.least = 0.05; }},
                                                                  {"most", [](P& p) { p.most = 2; }},
                                                                  {"reversals", [](P& p) { p.reversals = 30; }},
                                                                  {"averaged", [](P& p) { p.averaged = 4; }},
                                                                  {"most_trials", [](P& p) { p.most_trials = 7; }},
                                                                  {"unit", [](P& p) { p.unit = "N"; }}};
  for (const auto& [name, change] : changes) {
    P other = params;
    change(other);
    BOOST_CHECK_EXCEPTION(Driven{other}, InputError, [&name = name](const InputError& error) {
      return std::string(error.what()).find("cannot be continued: " + name + " differ") != std::string::npos;
    });
  }
  BOOST_CHECK_NO_THROW(Driven{params});
}

BOOST_AUTO_TEST_CASE(the_table_tells_codes_and_neither_settings_nor_names) {
  const TemporaryFolder folder;
  Protocol::Params params = small_study();
  params.folder = folder.path().string();
  Driven(params).run();
  std::ifstream file(folder.path() / "P01.csv");
  const std::string text(std::istreambuf_iterator<char>(file), {});
  BOOST_TEST(std::count(text.begin(), text.end(), '\n') == 9);
  BOOST_TEST(text.find(",A,A,0.25,") != std::string::npos);
  for (const char* told : {"select", "first", "fourth", "coupling", "gain"}) {
    BOOST_TEST(text.find(told) == std::string::npos, told);
  }
}

BOOST_AUTO_TEST_CASE(practice_writes_nothing) {
  const TemporaryFolder folder;
  Protocol::Params params = small_study();
  params.folder = (folder.path() / "study").string();
  params.participant = "P0";
  Driven d(params);
  d.run();
  BOOST_TEST(d.rows.size() == 8U);
  BOOST_TEST(!std::filesystem::exists(params.folder));
}

BOOST_AUTO_TEST_CASE(a_study_that_makes_no_sense_is_refused_with_the_parameter) {
  const auto refused = [](const std::string& path, const auto& change) {
    Protocol::Params params = small_study();
    change(params);
    BOOST_CHECK_EXCEPTION(Protocol::check(params), ValueError,
                          [&](const ValueError& error) { return error.path() == path; });
  };
  using P = Protocol::Params;
  BOOST_CHECK_NO_THROW(Protocol::check(small_study()));
  refused("participant", [](P& p) { p.participant = "Anna"; });
  refused("participant", [](P& p) { p.participant = "Jan07"; });
  refused("conditions.local", [](P& p) { p.conditions[0].first = "local"; });
  refused("conditions.B", [](P& p) { p.conditions[1].second = "select.use=fourth"; });
  refused("conditions.A", [](P& p) { p.conditions[0].second += "; " + p.mute + "=1"; });
  refused("conditions.A", [](P& p) { p.conditions[0].second += ";" + p.level + " = 1"; });
  refused("level", [](P& p) { p.level.clear(); });
  refused("levels", [](P& p) { p.levels.clear(); });
  refused("levels", [](P& p) { p.levels = {0.1, 0}; });
  refused("levels", [](P& p) { p.levels = {0.1, 0.1}; });
  refused("button_second", [](P& p) { p.button_second = p.button_first; });
  refused("conditions", [](P& p) { p.procedure = Procedure::pairs, p.conditions.resize(1); });
  const auto staircase = [](P& p) {
    p.procedure = Procedure::staircase;
    p.steps = {0.1}, p.least = 0.1, p.start = 0.5, p.most = 1, p.reversals = 4, p.averaged = 2;
  };
  Protocol::Params good = small_study();
  staircase(good);
  BOOST_CHECK_NO_THROW(Protocol::check(good));
  refused("steps", [&](P& p) { staircase(p), p.steps.clear(); });
  refused("steps", [&](P& p) { staircase(p), p.scale = StepScale::factor; });
  refused("start", [&](P& p) { staircase(p), p.start = 2; });
  refused("least", [&](P& p) { staircase(p), p.least = 0; });
  refused("averaged", [&](P& p) { staircase(p), p.averaged = 5; });
}

BOOST_AUTO_TEST_SUITE_END()
