// Every node type there is: its check refuses what its constructor refuses, and nothing else; its metrics and its role
// are declared.
#include <algorithm>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_int_distribution.hpp>
#include <boost/test/unit_test.hpp>
#include <fstream>
#include <map>
#include <set>

#include "framework/core/check.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/node/registry.hpp"
#include "tests/support/shapes.hpp"

BOOST_AUTO_TEST_SUITE(node_types_test)

using namespace tactor;

namespace {

struct Fixture {
  Fixture() {
    registry.load_all();
    good_csv = write("good.csv", "t_s,x_mm,F_N\n0,0,0\n0.001,1,1\n0.002,2,1\n0.003,1,2\n");
    bad_csv = write("bad.csv", "t_s,x_mm,F_N\n0,0,0\n0,1,1\n");
    broken_yaml = write("broken.yaml", "name: x\nregisters: [\n");
  }

  std::string write(const std::string& name, const std::string& text) {
    const std::filesystem::path path = folder.path() / name;
    std::ofstream(path) << text;
    return path.string();
  }

  TemporaryFolder folder;
  Registry registry{{TACTOR_NODE_FOLDER}};
  std::string good_csv, bad_csv, broken_yaml;
};

Body body(const std::string& name, Shape shape, Motion motion = Motion::fixed, Vec3 p_WB = {}) {
  Body made;
  made.name = name;
  made.shape = std::move(shape);
  made.motion = motion;
  made.X_WB.p = p_WB;
  return made;
}

Scene scene_of(std::vector<Body> bodies) {
  Scene scene;
  scene.bodies = std::move(bodies);
  return scene;
}

/// Scenes that some type refuses, and scenes that it takes.
std::vector<std::pair<std::string, Scene>> scenes() {
  const auto mesh = [](const char* name, const TriangleMesh& triangles) {
    return MeshShape{test::write_off(triangles, name)};
  };
  TriangleMesh open = test::box({0.01, 0.02, 0.03});
  open.faces.pop_back();
  const Shape good = mesh("good", test::box({0.01, 0.02, 0.03}));
  const Shape broken = mesh("open", open);
  const Shape huge = mesh("huge", test::box({20, 20, 20}));
  const Body wall = body("wall", PlaneShape{});
  const Body block = body("block", BoxShape{{0.02, 0.02, 0.02}});
  const Body ball = body("ball", SphereShape{0.004}, Motion::translation, {0, 0, 0.02});
  return {
      {"a ball and a wall", scene_of({wall, ball})},
      {"a ball and a block", scene_of({block, ball})},
      {"a ball and a mesh", scene_of({body("mesh", good), ball})},
      {"a ball and an open mesh", scene_of({body("mesh", broken), ball})},
      {"a ball and a mesh in mm", scene_of({body("mesh", huge), ball})},
      {"a mesh that rotates", scene_of({block, body("tool", good, Motion::rigid, {0, 0, 0.05})})},
      {"an open mesh that rotates", scene_of({block, body("tool", broken, Motion::rigid, {0, 0, 0.05})})},
      {"two that move", scene_of({wall, ball, body("other", good, Motion::translation, {0.1, 0, 0})})},
      {"two of which one rotates", scene_of({wall, ball, body("other", good, Motion::rigid, {0.1, 0, 0})})},
      {"a ball alone", scene_of({ball})},
      {"nothing that moves", scene_of({wall, block})},
      {"nothing", scene_of({})},
  };
}

/// Values of a parameter that a graph may give: within its bounds, for the loader sees to those.
std::vector<ParamValue> values_of(const NodeInfo& info, const ParamInfo& param, const Fixture& fixture) {
  // The largest ones take gigabytes or minutes.
  const std::map<std::string, std::vector<ParamValue>> chosen{
      {"resolution", {std::int64_t{8}, std::int64_t{32}}},
      {"most_points", {std::int64_t{8}, std::int64_t{3000}}},
      {"nodes", {std::int64_t{8}, std::int64_t{1024}}},
      {"spacing", {5e-4, 2e-3, 0.01}},
      {"rest", {0.0, 0.5, 3.0}},
      {"rate", {100.0, 1000.0, 20000.0}},
      {"connect", {"tcp:127.0.0.1:502", "rtu:/dev/ttyUSB0", "nonsense"}},
      {"region", {std::vector<double>{}, std::vector<double>{0, 0, 0, 0.01, 0.01, 0.01}, std::vector<double>{0, 1}}},
  };
  if (const auto found = chosen.find(param.name); found != chosen.end()) return found->second;
  std::vector<ParamValue> values;
  if (param.default_value) values.push_back(*param.default_value);
  const auto number = [&](double low, double high) {
    std::vector<double> numbers;
    const double usual = std::holds_alternative<double>(values.empty() ? ParamValue(1.0) : values[0])
                             ? std::get<double>(values.empty() ? ParamValue(1.0) : values[0])
                             : 1.0;
    if (std::isfinite(low))
      numbers.push_back(param.above_min ? low + 1e-3 * (std::isfinite(high) ? high - low : 1) : low);
    numbers.push_back(usual / 3);
    numbers.push_back(usual * 20);
    if (std::isfinite(high)) numbers.push_back(high);
    std::erase_if(numbers, [&](double x) { return x < low || x > high || (param.above_min && x <= low); });
    return numbers;
  };
  switch (param.kind) {
    case ParamKind::boolean:
      return {true, false};
    case ParamKind::integer: {
      const auto low = static_cast<std::int64_t>(param.min);
      values.insert(values.end(), {low, std::min(static_cast<std::int64_t>(param.max), low + 40)});
      return values;
    }
    case ParamKind::real:
      for (const double x : number(param.min, param.max)) values.emplace_back(x);
      return values;
    case ParamKind::text:
      values.insert(values.end(), {std::string(), std::string("x")});
      return values;
    case ParamKind::choice:
      for (const std::string& choice : param.choices) values.emplace_back(choice);
      return values;
    case ParamKind::file:
      if (param.name == "profile") {
        for (const auto& entry :
             std::filesystem::directory_iterator(TACTOR_SOURCE_DIR "/devices/" + param.file.part + "/profiles")) {
          values.emplace_back(entry.path().string());
        }
      }
      values.insert(values.end(), {fixture.good_csv, fixture.bad_csv, fixture.broken_yaml});
      return values;
    case ParamKind::reals:
      if (param.size > 0) values.emplace_back(std::vector<double>(param.size, std::max(param.min, 0.0)));
      if (param.size == 0) values.emplace_back(std::vector<double>(3, std::max(param.min, 0.5)));
      return values;
    case ParamKind::table: {
      const std::size_t n = param.columns.size();
      Table rises{n, std::vector<double>(2 * n, 0.0)}, falls = rises, wild = rises;
      rises.values[n] = 1;
      falls.values[n] = -1;
      wild.values[n] = std::numeric_limits<double>::quiet_NaN();
      values.insert(values.end(), {rises, falls, wild});
      return values;
    }
    case ParamKind::mapping:
      values.insert(values.end(), {Mapping{{"time", "t_s"}, {"force.x", "F_N"}}, Mapping{{"time", "nowhere"}},
                                   Mapping{{"what", "t_s"}}});
      return values;
  }
  BOOST_FAIL(info.type << "." << param.name << " is of no known kind");
  return {};
}

/// The message of the refusal, empty where there is none, and the notes.
template <class Work>
std::pair<std::string, std::vector<std::string>> outcome(NodeContext context, const Work& work) {
  std::vector<std::string> notes;
  context.notes = &notes;
  try {
    work(context);
  } catch (const InputError& error) {
    return {error.what(), {}};
  }
  return {"", notes};
}

void compare(const NodeInfo& info, const std::vector<ParamValue>& values, const std::string& name, const Scene& scene,
             std::set<std::string>& refusals) {
  NodeContext context;
  context.name = "node";
  context.scene = &scene;
  context.torque = scene.rotates();
  context.duration = Duration{1'000'000'000};
  const auto checked = outcome(context, [&](const NodeContext& c) { info.check(values, c); });
  const auto made = outcome(context, [&](const NodeContext& c) { static_cast<void>(info.create(values, c)); });
  BOOST_TEST_CONTEXT(info.type << " in " << name) {
    BOOST_TEST(checked.first == made.first);
    BOOST_TEST(checked.second == made.second, boost::test_tools::per_element());
  }
  if (!made.first.empty()) refusals.insert(info.type);
}

}  // namespace

/// Of what leads an experiment: no stage of the pipeline.
static bool is_beside_the_pipeline(const NodeInfo& info) {
  return info.type.starts_with("experiment.");
}

// A rate of its own would let a node go on at 1 kHz beside a device of 4 kHz.
BOOST_FIXTURE_TEST_CASE(every_type_that_steps_at_a_rate_has_that_of_the_haptic_loop, Fixture) {
  std::set<std::string> types;
  for (const NodeInfo* info : registry.types()) {
    // What leads an experiment looks at it as often as an answer needs, and is no part of the loop.
    if (!info->rate_parameter || is_beside_the_pipeline(*info)) continue;
    BOOST_TEST(info->haptic_rate, info->type);
    types.insert(info->type);
  }
  for (const char* type : {"device.simulated", "interpolation.rollout", "source.trajectory"}) {
    BOOST_TEST(types.contains(type), type << " is not among the types");
  }
}

BOOST_FIXTURE_TEST_CASE(the_check_of_every_type_refuses_what_its_constructor_refuses, Fixture) {
  const auto all_scenes = scenes();
  std::set<std::string> refusals, checked;
  for (const NodeInfo* info : registry.types()) {
    // Anew for each type, so that a further type changes nothing for the others.
    boost::random::mt19937 dice(17);
    if (info->stand_in() != nullptr) continue;
    checked.insert(info->type);
    std::vector<std::vector<ParamValue>> choices;
    for (const ParamInfo& param : info->params) choices.push_back(values_of(*info, param, *this));
    std::vector<ParamValue> first;
    for (std::size_t i = 0; i < choices.size(); ++i) {
      first.push_back(info->params[i].default_value.value_or(choices[i].front()));
    }
    for (const auto& [name, scene] : all_scenes) {
      compare(*info, first, name, scene, refusals);
      const bool meets_bodies =
          info->type.starts_with("collision.") || info->type == "forcefield.rbf" || info->type == "forcefield.proxy";
      for (int round = 0; round < (meets_bodies ? 3 : 12); ++round) {
        std::vector<ParamValue> values = first;
        for (std::size_t i = 0; i < choices.size(); ++i) {
          // Mostly few at a time, so that one fault does not hide the others.
          if (boost::random::uniform_int_distribution<int>(0, 3)(dice) > 0) continue;
          const auto last = static_cast<int>(choices[i].size()) - 1;
          values[i] = choices[i][static_cast<std::size_t>(boost::random::uniform_int_distribution<int>(0, last)(dice))];
        }
        compare(*info, values, name, scene, refusals);
      }
      // Each value by itself, once.
      if (&scene != &all_scenes.front().second) continue;
      for (std::size_t i = 0; i < choices.size(); ++i) {
        for (const ParamValue& value : choices[i]) {
          std::vector<ParamValue> values = first;
          values[i] = value;
          compare(*info, values, name, scene, refusals);
        }
      }
    }
  }
  // What the walk must have met, so that it does not pass for want of refusals.
  for (const char* type : {"source.trajectory", "source.recording", "device.simulated", "dynamics.translation",
                           "dynamics.quasistatic", "prediction.refit", "sink.metrics", "coupling.adaptive"}) {
    BOOST_TEST(checked.contains(type), type << " is not among the types");
    BOOST_TEST(refusals.contains(type), type << " refused nothing that was tried");
  }
  for (const char* type : {"collision.primitive", "collision.sdf", "forcefield.rbf", "forcefield.proxy",
                           "effect.texture", "modbus.actuator", "usb.device"}) {
    BOOST_TEST(refusals.contains(type) == checked.contains(type), type << " refused nothing that was tried");
  }
}

BOOST_FIXTURE_TEST_CASE(every_type_has_a_role, Fixture) {
  std::map<Role, std::size_t> count;
  for (const NodeInfo* info : registry.types()) {
    BOOST_TEST((info->role == Role::other) == is_beside_the_pipeline(*info), info->type);
    BOOST_TEST((info->role == Role::sink) == info->sink, info->type);
    BOOST_TEST((info->role == Role::device) == info->actuator, info->type);
    ++count[info->role];
  }
  BOOST_TEST(count.size() == role_count);
}

BOOST_FIXTURE_TEST_CASE(types_that_report_the_same_metric_declare_it_alike, Fixture) {
  std::map<std::string, const MetricInfo*> known;
  for (const NodeInfo* info : registry.types()) {
    for (const MetricInfo& metric : info->metrics) {
      BOOST_TEST_CONTEXT(info->type << ": " << metric.name) {
        BOOST_TEST(!metric.doc.empty());
        BOOST_TEST(!metric.unit.empty());
        const MetricInfo& first = *known.try_emplace(metric.name, &metric).first->second;
        BOOST_TEST(metric.unit == first.unit);
        BOOST_TEST((metric.better == first.better));
        BOOST_TEST(metric.summed == first.summed);
      }
    }
  }
  BOOST_TEST(known.size() > 100U);
  // Dotted names become nested objects in the summary, so a value cannot have others below it.
  for (const auto& [name, metric] : known) {
    const auto next = known.upper_bound(name + ".");
    BOOST_TEST((next == known.end() || !next->first.starts_with(name + ".")), name);
  }
}

BOOST_FIXTURE_TEST_CASE(the_unit_in_a_metrics_name_is_the_one_declared, Fixture) {
  const std::map<std::string, std::string> units{{"_N", "N"},
                                                 {"_Nm", "N m"},
                                                 {"_m", "m"},
                                                 {"_J", "J"},
                                                 {"_Hz", "Hz"},
                                                 {"_ms", "ms"},
                                                 {"_N_per_ms", "N/ms"},
                                                 {"_N_per_ms2", "N/ms^2"},
                                                 {"_m_per_s", "m/s"},
                                                 {"_Nm_per_ms", "N m/ms"},
                                                 {"_Nm_per_ms2", "N m/ms^2"}};
  std::size_t found = 0;
  for (const NodeInfo* info : registry.types()) {
    for (const MetricInfo& metric : info->metrics) {
      // The longest one counts.
      std::string suffix;
      for (const auto& [end, unit] : units) {
        if (metric.name.ends_with(end) && end.size() > suffix.size()) suffix = end;
      }
      if (suffix.empty()) continue;
      ++found;
      BOOST_TEST(metric.unit == units.at(suffix), info->type << ": " << metric.name);
    }
  }
  BOOST_TEST(found > 30U);
}

BOOST_AUTO_TEST_SUITE_END()
