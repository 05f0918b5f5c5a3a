// What every predictor of the library promises, alone or with every refitter: registering one is what has it tested.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "framework/node/registry.hpp"
#include "framework/realtime/allocation_watch.hpp"
#include "tests/support/force_stream.hpp"
#include "tests/support/heap_is_counted.hpp"
#include "tests/support/hostile_wrench.hpp"

BOOST_AUTO_TEST_SUITE(predictor_properties_test)

using namespace tactor;
using namespace tactor::test;

extern "C" void tactor_register_nodes(Registry& registry);

namespace {

using Choices = std::map<std::string, ParamValue>;

// A predictor with its parameters, and the refitter that feeds it, if any.
struct Recipe {
  const NodeInfo* predictor = nullptr;
  Choices predictor_choices;
  const NodeInfo* refitter = nullptr;
  Choices refitter_choices;

  std::string name() const {
    std::string text = predictor->type;
    const auto add = [&text](const Choices& choices) {
      for (const auto& [key, value] : choices) {
        if (const auto* word = std::get_if<std::string>(&value)) text += " " + key + "=" + *word;
      }
    };
    add(predictor_choices);
    if (refitter != nullptr) add(refitter_choices);
    return text;
  }
  bool is(const std::string& key, const std::string& word) const {
    for (const Choices* choices : {&predictor_choices, &refitter_choices}) {
      const auto found = choices->find(key);
      if (found != choices->end() && found->second == ParamValue(word)) return true;
    }
    return false;
  }
};

std::unique_ptr<Node> make(const NodeInfo& info, const Choices& choices, double limit) {
  // What makes memories short, so that runs can be, and the limits of the device.
  const Choices common{{"window", std::int64_t{60}}, {"mean_window", std::int64_t{60}},
                       {"forgetting", 0.95},         {"force_max", limit},
                       {"torque_max", limit},        {"steps", std::int64_t{Forecast::capacity}}};
  std::vector<ParamValue> values;
  for (const ParamInfo& p : info.params) {
    ParamValue value = p.default_value.value();
    if (common.contains(p.name)) value = common.at(p.name);
    if (choices.contains(p.name)) value = choices.at(p.name);
    values.push_back(value);
  }
  return info.create(values, context());
}

const Registry& registry() {
  static const Registry filled = [] {
    Registry r({});
    tactor_register_nodes(r);
    return r;
  }();
  return filled;
}

// Every predictor by its defaults and with every word of every choice; prediction.ar also behind a refitter of every
// combination of words that it takes.
const std::vector<Recipe>& recipes() {
  static const std::vector<Recipe> all = [] {
    std::vector<Recipe> list;
    for (const NodeInfo* info : registry().types()) {
      if (info->output("forecast") == nullptr) continue;
      list.push_back({info, {}, nullptr, {}});
      for (const ParamInfo& p : info->params) {
        for (std::size_t i = 0; i < p.choices.size(); ++i) {
          if (p.default_value != ParamValue(p.choices[i]))
            list.push_back({info, {{p.name, p.choices[i]}}, nullptr, {}});
        }
      }
    }
    for (const NodeInfo* info : registry().types()) {
      if (info->output("coefficients") == nullptr) continue;
      std::vector<Choices> combinations{{}};
      for (const ParamInfo& p : info->params) {
        std::vector<Choices> longer;
        for (const Choices& c : combinations) {
          if (p.kind == ParamKind::boolean) {
            for (const bool value : {false, true}) {
              longer.push_back(c);
              longer.back()[p.name] = value;
            }
          }
          for (const std::string& word : p.choices) {
            longer.push_back(c);
            longer.back()[p.name] = word;
          }
        }
        if (!longer.empty()) combinations = longer;
      }
      for (const NodeInfo* predictor : registry().types()) {
        if (predictor->input("coefficients") == nullptr) continue;
        for (const Choices& c : combinations) {
          try {
            make(*info, c, 1);
          } catch (const InputError&) {
            continue;
          }
          list.push_back({predictor, {}, info, c});
        }
      }
    }
    return list;
  }();
  return all;
}

// A recipe at work, fed with physics samples and, each millisecond, the device's state.
class Subject {
 public:
  explicit Subject(const Recipe& recipe, double limit = 8, Quat frame = {})
      : recipe_(&recipe), predictor_(make(*recipe.predictor, recipe.predictor_choices, limit)), frame_(frame) {
    force_ = connect(*recipe.predictor, *predictor_, "force", {QueuePolicy::drop_oldest, 64});
    device_ = connect(*recipe.predictor, *predictor_, "device", {QueuePolicy::drop_oldest, 256});
    forecast_ = &recipe.predictor->output("forecast")->access(*predictor_);
    if (recipe.refitter == nullptr) return;
    refitter_ = make(*recipe.refitter, recipe.refitter_choices, limit);
    refit_force_ = connect(*recipe.refitter, *refitter_, "force", {QueuePolicy::drop_oldest, 512});
    coefficients_in_ = connect(*recipe.predictor, *predictor_, "coefficients", {QueuePolicy::latest, 1});
    coefficients_out_ = &recipe.refitter->output("coefficients")->access(*refitter_);
  }

  // Where the device is t seconds after the start.
  static Pose path(double t) {
    return {{0.02 * std::sin(3 * t), 0.01 * std::cos(5 * t), 0.005 * t},
            from_rotation_vector({0.3 * std::sin(2 * t), 0.1 * t, 0})};
  }

  // A sample at `ms`, which the predictor sees one `latency_ms` later.
  Forecast feed(double ms, const Wrench& wrench, double latency_ms = 10) {
    const Wrench turned{rotate(frame_, wrench.force), rotate(frame_, wrench.torque)};
    for (; device_ != nullptr && device_ms_ <= ms + latency_ms; ++device_ms_) {
      const Pose X = path(device_ms_ * 1e-3);
      const DeviceState state{{rotate(frame_, X.p), frame_ * X.R}, {}, 0};
      device_->push(stamp_ms(device_ms_), &state);
    }
    const Stamp stamp = stamp_ms(ms, sequence_++);
    StepContext c(stamp.produced);
    if (refitter_) {
      refit_force_->push(stamp, &turned);
      refitter_->step(c);
      for (std::size_t i = 0; i < coefficients_out_->pending(); ++i) {
        coefficients_in_->push(stamp, coefficients_out_->pending_value(i));
      }
      coefficients_out_->clear_pending();
    }
    force_->push(stamp, &turned);
    predictor_->step(c);
    TACTOR_DEMAND(forecast_->pending() == 1);
    const Forecast result = *static_cast<const Forecast*>(forecast_->pending_value(0));
    sent_ = forecast_->pending_valid(0);
    forecast_->clear_pending();
    return result;
  }

  /// The stamp of what feed() gave last.
  Time sent() const { return sent_; }

  double metric(const std::string& name) const {
    Report report;
    report.ask(*predictor_, "predictor", recipe_->predictor->metrics);
    if (refitter_) {
      report.ask(*refitter_, "refitter", recipe_->refitter->metrics);
    }
    return metrics_of(report).at(name);
  }

 private:
  static InputBase* connect(const NodeInfo& info, Node& node, const std::string& name, Queue queue) {
    const InputInfo* input = info.input(name);
    if (input == nullptr) return nullptr;
    InputBase& port = input->access(node);
    port.configure(queue);
    return &port;
  }

  const Recipe* recipe_;
  std::unique_ptr<Node> predictor_, refitter_;
  Quat frame_;
  InputBase *force_ = nullptr, *device_ = nullptr, *refit_force_ = nullptr, *coefficients_in_ = nullptr;
  OutputBase *forecast_ = nullptr, *coefficients_out_ = nullptr;
  Time sent_;
  double device_ms_ = 0;
  std::uint64_t sequence_ = 0;
};

// Physics of an uneven rate: 7 to 13 ms.
struct Clock {
  double next() { return now += draw(7, 13); }
  double now = 0;
  Dice draw{99};
};

// A texture with noise, different in force and torque.
class Texture {
 public:
  explicit Texture(std::uint64_t seed) : draw_(seed) {}
  Wrench next() {
    const Wrench x{1.6 * x1_.force - 0.8 * x2_.force + draw_.normal_vector(0.01),
                   1.2 * x1_.torque - 0.5 * x2_.torque + draw_.normal_vector(0.001)};
    x2_ = x1_;
    x1_ = x;
    return x + Wrench{{0.5, -1, 2}, {0.01, 0, -0.02}};
  }

 private:
  Dice draw_;
  Wrench x1_, x2_;
};

double size(const Wrench& w) {
  return norm(w.force) + norm(w.torque);
}

// Whether all that is forecast is finite, and no part of it longer than `limit`.
bool within(const Forecast& f, double limit) {
  std::vector<Wrench> all(f.predicted_D_W.begin(), f.predicted_D_W.begin() + f.count);
  all.push_back(f.current_D_W);
  return std::all_of(all.begin(), all.end(), [&](const Wrench& w) {
    return is_finite(w) && norm(w.force) <= limit * (1 + 1e-12) && norm(w.torque) <= limit * (1 + 1e-12);
  });
}

}  // namespace

BOOST_AUTO_TEST_CASE(every_method_and_predictor_is_under_test) {
  std::map<std::string, int> methods;
  for (const Recipe& r : recipes()) {
    if (r.refitter != nullptr) ++methods[std::get<std::string>(r.refitter_choices.at("method"))];
  }
  BOOST_TEST(methods.size() == 4U);
  for (const auto& [method, count] : methods) BOOST_TEST(count > 0, method);
  std::map<std::string, int> predictors;
  for (const Recipe& r : recipes()) ++predictors[r.predictor->type];
  BOOST_TEST(predictors.size() == 6U);
  // A refitter makes coefficients. The types below, which have tests of their own, make the state that a rollout
  // continues.
  for (const NodeInfo* info : registry().types()) {
    BOOST_TEST(
        (predictors.contains(info->type) || info->output("coefficients") != nullptr ||
         info->type == "prediction.local" || info->type == "prediction.mujoco" || info->type == "prediction.external"),
        info->type);
  }
}

BOOST_AUTO_TEST_CASE(what_is_sent_is_finite_and_within_the_device_whatever_comes) {
  for (const Recipe& recipe : recipes()) {
    for (int kind = 0; kind < hostile_kinds; ++kind) {
      for (const double unit : {1e-6, 1.0, 1e6}) {
        Dice draw(static_cast<std::uint64_t>(kind) + 1);
        Clock clock;
        Subject subject(recipe);
        for (int t = 0; t < 200; ++t) {
          const Forecast f = subject.feed(clock.next(), unit * hostile(kind, t, draw));
          const bool good = within(f, 8);
          BOOST_REQUIRE_MESSAGE(good, recipe.name() << ", kind " << kind << ", unit " << unit << ", step " << t);
        }
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(times_that_stand_still_jump_or_run_back_do_no_harm) {
  for (const Recipe& recipe : recipes()) {
    Dice draw(4);
    Texture texture(5);
    Subject subject(recipe);
    double ms = 0;
    for (int t = 0; t < 300; ++t) {
      const double dice = draw(0, 1);
      ms += dice < 0.1 ? 0 : dice < 0.2 ? -5 : dice < 0.25 ? 1e-6 : dice < 0.27 ? 5e4 : 10;
      ms = std::max(ms, 0.0);
      const Forecast f = subject.feed(ms, texture.next(), 1);
      const bool good = within(f, 8) && f.horizon > 0;
      BOOST_REQUIRE_MESSAGE(good, recipe.name() << ", step " << t);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_sample_that_is_not_finite_is_held_and_counted_once) {
  for (const Recipe& recipe : recipes()) {
    Clock clock;
    Texture texture(3);
    Subject subject(recipe, 1e3);
    Wrench last;
    for (int t = 0; t < 200; ++t) subject.feed(clock.next(), last = texture.next());
    const Forecast bad = subject.feed(clock.next(), {{0, std::nan(""), 0}, {}});
    BOOST_TEST(size(bad.current_D_W - last) == 0.0, recipe.name());
    for (const Wrench& step : bad.predicted_D_W) BOOST_TEST(size(step - last) == 0.0, recipe.name());
    BOOST_TEST(bad.fallback == 1, recipe.name());
    BOOST_TEST(subject.metric("prediction.rejected_samples") == 1.0, recipe.name());
    if (recipe.refitter != nullptr) BOOST_TEST(subject.metric("refit.rejected_samples") == 1.0, recipe.name());
    BOOST_TEST(is_finite(subject.feed(clock.next(), texture.next()).predicted_D_W[0]), recipe.name());
  }
}

BOOST_AUTO_TEST_CASE(a_constant_force_is_expected_to_stay_where_nothing_of_its_level_is_fitted) {
  const Wrench constant{{3.0, -1.1, 0.7}, {0.1, 0.02, -0.3}};
  for (const Recipe& recipe : recipes()) {
    if (recipe.is("detrend", "none") && recipe.refitter != nullptr) continue;
    Clock clock;
    Texture texture(6);
    Subject subject(recipe);
    // A texture first, so that something has been fitted before the force turns constant.
    for (int t = 0; t < 150; ++t) subject.feed(clock.next(), texture.next());
    for (int t = 0; t < 400; ++t) {
      const Forecast f = subject.feed(clock.next(), constant);
      double error = 0;
      for (const Wrench& step : f.predicted_D_W) error = std::max(error, size(step - constant));
      if (t > 350) BOOST_REQUIRE_MESSAGE(error < 1e-6, recipe.name() << ": " << error << " at " << t);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_ramp_is_met_by_those_that_follow_trends) {
  int tested = 0;
  for (const Recipe& recipe : recipes()) {
    if (recipe.predictor->type != "prediction.linear" && recipe.predictor->type != "prediction.kalman") continue;
    ++tested;
    Clock clock;
    Subject subject(recipe, 1e3);
    const auto ramp = [](double ms) { return Wrench{{1e-3 * ms, 1, -2e-3 * ms}, {0, 1e-4 * ms, 0.1}}; };
    for (int t = 0; t < 100; ++t) {
      const double ms = clock.next();
      const Forecast f = subject.feed(ms, ramp(ms));
      if (t < 5) continue;
      double error = 0;
      for (std::size_t i = 0; i < f.predicted_D_W.size(); ++i) {
        const double ahead = 1e3 * f.horizon * static_cast<double>(i + 1);
        error = std::max(error, size(f.predicted_D_W[i] - ramp(ms + ahead)));
      }
      BOOST_REQUIRE_MESSAGE(error < 1e-6, recipe.name() << ": " << error << " at " << t);
    }
  }
  BOOST_TEST(tested >= 4);
}

BOOST_AUTO_TEST_CASE(a_rotated_world_rotates_the_prediction) {
  const Quat R = from_rotation_vector({0.7, -1.1, 0.4});
  for (const Recipe& recipe : recipes()) {
    // An axis with a model of its own is an axis of the world.
    if (recipe.is("model_structure", "per_axis") ||
        (recipe.predictor->type == "prediction.multirate" && !recipe.is("model_structure", "axes"))) {
      continue;
    }
    Clock clock;
    Texture texture(7);
    Subject plain(recipe, 1e3);
    Subject turned(recipe, 1e3, R);
    for (int t = 0; t < 200; ++t) {
      const Wrench w = texture.next();
      const double ms = clock.next();
      const auto a = plain.feed(ms, w).predicted_D_W;
      const auto b = turned.feed(ms, w).predicted_D_W;
      double error = 0;
      for (std::size_t i = 0; i < a.size(); ++i) {
        error = std::max(error, size(Wrench{rotate(R, a[i].force), rotate(R, a[i].torque)} - b[i]));
      }
      BOOST_REQUIRE_MESSAGE(error < 1e-6, recipe.name() << ": " << error << " at " << t);
    }
  }
}

BOOST_AUTO_TEST_CASE(another_unit_of_force_scales_the_prediction) {
  constexpr double unit = 1048576;
  for (const Recipe& recipe : recipes()) {
    // Its parameters are forces.
    if (recipe.predictor->type == "prediction.kalman") continue;
    for (const double scale : {unit, 1 / unit}) {
      Clock clock;
      Texture texture(8);
      Subject plain(recipe, 1e3);
      Subject scaled(recipe, 1e3 * scale);
      for (int t = 0; t < 150; ++t) {
        const Wrench w = texture.next();
        const double ms = clock.next();
        const Wrench a = plain.feed(ms, w).predicted_D_W[0];
        const Wrench b = scaled.feed(ms, scale * w).predicted_D_W[0];
        BOOST_REQUIRE_MESSAGE(size(a - (1 / scale) * b) < 1e-9, recipe.name() << " at " << t);
      }
    }
  }
}

namespace {

/// The error of the last 100 of 400 predictions, in N; 100 samples before them were of a hostile kind, or good without
/// one.
double error_after(const Recipe& recipe, std::optional<int> kind) {
  Dice draw(7);
  Clock clock;
  Texture texture(9);
  Subject subject(recipe);
  for (int t = 0; t < 100; ++t) {
    const double ms = clock.next();
    const Wrench good = texture.next();
    subject.feed(ms, kind ? hostile(*kind, t, draw) : good);
  }
  double sum = 0;
  Wrench now = texture.next();
  for (int t = 0; t < 400; ++t) {
    const double ms = clock.next();
    const Wrench next = texture.next();
    const Vec3 error = subject.feed(ms, now).predicted_D_W[0].force - next.force;
    now = next;
    if (t >= 300) sum += dot(error, error);
  }
  return std::sqrt(sum);
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_while_after_trouble_predictions_are_as_good_as_without_it) {
  for (const Recipe& recipe : recipes()) {
    const double calm = error_after(recipe, {});
    for (int kind = 1; kind < hostile_kinds; ++kind) {
      const double troubled = error_after(recipe, kind);
      BOOST_REQUIRE_MESSAGE(troubled < 1.1 * calm, recipe.name()
                                                       << ", kind " << kind << ": " << troubled << " for " << calm);
    }
  }
}

BOOST_AUTO_TEST_CASE(no_step_calls_the_heap, *boost::unit_test::precondition(tactor::test::heap_is_counted)) {
  for (const Recipe& recipe : recipes()) {
    BOOST_TEST(recipe.predictor->realtime_safe, recipe.name());
    Clock clock;
    Texture texture(10);
    Subject subject(recipe);
    for (int t = 0; t < 3; ++t) subject.feed(clock.next(), texture.next());
    const std::int64_t before = thread_heap_calls();
    for (int t = 0; t < 300; ++t) subject.feed(clock.next(), texture.next());
    const std::int64_t calls = thread_heap_calls() - before;
    BOOST_TEST(calls == 0, recipe.name());
  }
}

BOOST_AUTO_TEST_CASE(what_is_held_while_bad_samples_come_keeps_the_stamp_of_the_last_good_one) {
  const Wrench bad{{std::numeric_limits<double>::quiet_NaN(), 0, 0}, {}};
  for (const Recipe& recipe : recipes()) {
    Subject subject(recipe);
    Texture texture(11);
    // Nothing good yet: the zero that is forecast is that of now.
    subject.feed(5, bad);
    BOOST_TEST(subject.sent().ns == stamp_ms(5).valid.ns, recipe.name());
    for (int k = 1; k <= 100; ++k) {
      subject.feed(10.0 * k, texture.next());
      BOOST_REQUIRE_MESSAGE(subject.sent().ns == stamp_ms(10.0 * k).valid.ns, recipe.name() << ", sample " << k);
    }
    for (int k = 101; k <= 120; ++k) {
      const Forecast f = subject.feed(10.0 * k, bad);
      BOOST_REQUIRE_MESSAGE(subject.sent().ns == stamp_ms(1000).valid.ns, recipe.name() << ", bad sample " << k);
      BOOST_TEST(f.fallback == 1, recipe.name());
    }
    subject.feed(1210, texture.next());
    BOOST_TEST(subject.sent().ns == stamp_ms(1210).valid.ns, recipe.name());
  }
}

BOOST_AUTO_TEST_SUITE_END()
