#include "nodes/experiment/protocol.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "framework/core/check.hpp"
#include "framework/core/random.hpp"
#include "framework/core/value_error.hpp"

namespace tactor {

namespace {

constexpr Duration screen_period{100'000'000};
/// A setting that is not made within this, or a force that has not faded, has failed.
constexpr Duration most_wait{5'000'000'000};

/// A force, or a torque at 50 mm, that counts as faded away, N.
constexpr double faded = 0.1;
constexpr double lever = 0.05;  // m

/// A device that displays less than this part of a force that is wanted, and by more than `faded` less, limits it; a
/// torque likewise, where `faded` at the lever is 5 mN m.
constexpr double limited_below = 0.99;

bool is_less(double shown, double asked, double least) {
  return shown < limited_below * asked && shown < asked - least;
}

/// The force, or what makes the torque at the lever, whichever is larger, N.
double size_of(const Wrench& wrench) {
  return std::max(norm(wrench.force), norm(wrench.torque) / lever);
}

/// Refuses what the schedule could not be made from.
const Protocol::Params& checked_params(const Protocol::Params& params) {
  Protocol::check(params);
  return params;
}

bool is_same_trial(const Trial& trial, const ExperimentRow& row) {
  return static_cast<std::int32_t>(trial.block) + 1 == row.block &&
         static_cast<std::int32_t>(trial.condition) == row.condition &&
         static_cast<std::int32_t>(trial.other) == row.other && trial.comparison + 1 == row.comparison &&
         trial.level == row.level && (row.response == 1 || row.response == 2);
}

}  // namespace

Protocol::Protocol(const Params& params, const NodeContext& context)
    : name_(context.name),
      params_(checked_params(params)),
      participant_(participant_code(params.participant)),
      seed_(derive_seed(context.seed, participant_.text)),
      schedule_(design(params), derive_seed(context.seed, "conditions"), participant_.number, seed_) {
  for (const auto& [code, text] : params.conditions) {
    codes_.push_back(code);
    settings_.push_back(split_settings(text));
  }
  if (params.procedure == Procedure::pairs) params_.level.clear();  // pairs have none
  if (codes_.empty()) {
    codes_.emplace_back("A");
    settings_.emplace_back();
  }
  const bool practice = participant_.number == 0;
  if (params.resume && (practice || params.folder.empty())) {
    throw ValueError("resume", practice ? "resume: a participant of number 0 is for practice and has no table"
                                        : "resume: only `tactor run` and `tactor view` continue a table; such a run "
                                          "cannot be replayed, because the recording does not hold the earlier table");
  }
  if (practice && context.notes != nullptr) {
    context.notes->push_back("node " + context.name + ": participant " + participant_.text +
                             " is for practice, no table is written; to write one, set " + context.name +
                             ".participant=P01");
  }
}

void Protocol::resume_table() {
  for (const ExperimentRow& done : table_->rows()) {
    const Trial* trial = schedule_.trial();
    if (trial == nullptr || !is_same_trial(*trial, done)) {
      throw InputError("the table of " + participant_.text + " cannot be continued: trial " +
                       std::to_string(done.trial) +
                       " does not come from this graph; use the graph as it was when the table was begun");
    }
    schedule_.answer(done.response - 1);
    trials_ = done.trial;
    run_ = std::max(run_, done.run + 1);
  }
  if (schedule_.trial() == nullptr) throw InputError("the table of " + participant_.text + " is complete");
}

void Protocol::start(StepContext& context) {
  if (!params_.folder.empty() && participant_.number > 0) {
    const std::filesystem::path file = std::filesystem::path(params_.folder) / (participant_.text + ".csv");
    const TableOwner owner{codes_, seed_, study_design(params_)};
    table_ = params_.resume ? TrialTable::resume(file, owner) : TrialTable::begin(file, owner);
    resume_table();
  }
  mute(context.now());
  put_question(context.now(), true);
}

std::string Protocol::place() const {
  if (phase_ == TrialPhase::waiting || schedule_.trial() == nullptr)
    return "before trial " + std::to_string(trials_ + 1);
  return "trial " + std::to_string(trials_ + 1) + ", interval " + std::to_string(interval_ + 1);
}

void Protocol::ask(const std::string& text, Time now) {
  if (unconfirmed_.empty()) confirmed_at_ = now;
  unconfirmed_.push_back(text);
  requests.send(now, set_request(text, place()));
}

void Protocol::tune(const Params& params) {
  tuned_ = params.answer;
}

void Protocol::request_done() {
  if (unconfirmed_.empty()) throw RunError(name_ + ": a setting is in force that was not asked for");
  unconfirmed_.pop_front();
  is_confirmed_anew_ = true;
}

void Protocol::check_settings(StepContext& context) {
  if (std::exchange(is_confirmed_anew_, false)) confirmed_at_ = context.now();
  // A run that stops does nothing any more that is asked for.
  if (unconfirmed_.empty() || context.phase() == Phase::stopping || context.now() < confirmed_at_ + most_wait) return;
  throw RunError(place() + ": " + unconfirmed_.front() + " was not made within " +
                 std::to_string(static_cast<int>(most_wait.seconds())) +
                 " s; the table keeps the trials that were answered");
}

void Protocol::mute(Time now) {
  ask(params_.mute + "=0", now);
}

void Protocol::prepare(Time now) {
  const Trial& trial = *schedule_.trial();
  const bool comparison = interval_ == trial.comparison;
  for (const std::string& setting : settings_[comparison ? trial.condition : trial.other]) ask(setting, now);
  if (!params_.level.empty() && params_.level != params_.mute) {
    ask(level_setting(params_, comparison ? trial.level : 0), now);
  }
}

void Protocol::unmute(Time now) {
  const Trial& trial = *schedule_.trial();
  if (!params_.level.empty() && params_.level == params_.mute) {
    ask(level_setting(params_, interval_ == trial.comparison ? trial.level : 0), now);
  } else {
    ask(params_.mute + "=1", now);
  }
}

void Protocol::begin_interval(Time now) {
  phase_ = interval_ == 0 ? TrialPhase::first : TrialPhase::second;
  until_ = now + params_.interval;
  felt_[static_cast<std::size_t>(interval_)] = {.connected = felt.connected()};
}

void Protocol::change(Time now) {
  // Nothing goes on before the settings that were asked for hold, and have had their time.
  if (!unconfirmed_.empty()) {
    until_ = now + params_.change;
    return;
  }
  if (change_ == Change::opening) return begin_interval(now);
  if (now < until_) return;
  if (change_ == Change::fading) {
    // Where somebody tells what is felt, nothing changes before it has faded.
    if (felt_newest_ > faded) {
      if (now <= until_ + most_wait) return;
      throw RunError(place() + ": " + params_.mute + "=0 does not take the force away");
    }
    prepare(now);
    change_ = Change::settling;
    until_ = now + params_.change;
  } else if (is_free()) {
    unmute(now);
    change_ = Change::opening;
  } else {
    phase_ = TrialPhase::lift;
  }
}

bool Protocol::is_limited(const Stamped<Wrench>& shown) {
  // What the device would display without its limits, at the same tick.
  while (!wanted_newest_ || wanted_newest_->stamp.valid < shown.stamp.valid) {
    Stamped<Wrench> next;
    if (!wanted.pop(next)) break;
    wanted_newest_ = next;
  }
  is_compared_ = wanted_newest_ && wanted_newest_->stamp.valid == shown.stamp.valid;
  if (!is_compared_) return false;
  const Wrench& asked = wanted_newest_->value;
  return is_less(norm(shown.value.force), norm(asked.force), faded) ||
         is_less(norm(shown.value.torque), norm(asked.torque), faded * lever);
}

void Protocol::feel() {
  Felt& interval = felt_[static_cast<std::size_t>(interval_)];
  Stamped<Wrench> shown;
  while (felt.pop(shown)) {
    felt_newest_ = size_of(shown.value);
    const bool limited = is_limited(shown);
    if (phase_ != TrialPhase::first && phase_ != TrialPhase::second) continue;
    interval.peak = std::max(interval.peak, norm(shown.value.force));
    interval.ticks += is_compared_ ? 1 : 0;
    interval.limited += limited ? 1 : 0;
  }
}

bool Protocol::is_free() const {
  if (!force.connected()) return true;
  // Before the first result nobody knows.
  const auto* newest = force.latest();
  return newest != nullptr && size_of(newest->value) <= params_.free_below;
}

void Protocol::change_over(Time now, int interval) {
  phase_ = TrialPhase::changing;
  change_ = Change::fading;
  interval_ = interval;
  until_ = now + params_.change;
}

void Protocol::put_question(Time now, bool begins) {
  phase_ = begins ? TrialPhase::waiting : TrialPhase::answering;
  asked_ = now;
  tuned_.reset();
  const Trial& trial = *schedule_.trial();
  ExperimentQuestion message;
  message.number = ++questions_;
  message.begins = begins ? 1 : 0;
  message.comparison = trial.comparison;
  message.condition = static_cast<std::int32_t>(trial.condition);
  message.other = static_cast<std::int32_t>(trial.other);
  message.level = trial.level;
  question.send(now, message);
}

std::optional<Protocol::Given> Protocol::given(Time now) {
  std::optional<Given> first;
  const auto consider = [&](int interval, Time at) {
    if (at >= asked_ && (!first || at < first->at)) first = Given{interval, at};
  };
  Stamped<DeviceState> state;
  while (device.pop(state)) {
    const std::int32_t pressed = state.value.buttons & ~buttons_;
    buttons_ = state.value.buttons;
    const auto is_pressed = [&](int button) { return button > 0 && (pressed >> (button - 1) & 1) != 0; };
    if (is_pressed(params_.button_first)) consider(0, state.stamp.valid);
    if (is_pressed(params_.button_second)) consider(1, state.stamp.valid);
  }
  Stamped<ExperimentAnswer> answer;
  while (answers.pop(answer)) {
    if (answer.value.number == questions_) consider(answer.value.interval, answer.stamp.valid);
  }
  if (tuned_ && *tuned_ != Answer::none) consider(*tuned_ == Answer::first ? 0 : 1, now);
  tuned_.reset();
  return first;
}

void Protocol::take(const Given& answer, Time now) {
  const Trial trial = *schedule_.trial();
  ExperimentRow done;
  done.trial = ++trials_;
  done.run = run_;
  done.block = static_cast<std::int32_t>(trial.block) + 1;
  done.condition = static_cast<std::int32_t>(trial.condition);
  done.other = static_cast<std::int32_t>(trial.other);
  done.comparison = trial.comparison + 1;
  done.response = answer.interval + 1;
  done.correct = params_.procedure == Procedure::pairs ? -1 : done.response == done.comparison ? 1 : 0;
  done.level = trial.level;
  done.response_time = (answer.at - asked_).seconds();
  const auto peak = [](const Felt& f) { return f.connected ? f.peak : std::numeric_limits<double>::quiet_NaN(); };
  const auto limited = [](const Felt& f) {
    return f.ticks > 0 ? static_cast<double>(f.limited) / f.ticks : std::numeric_limits<double>::quiet_NaN();
  };
  done.peak_first = peak(felt_[0]);
  done.peak_second = peak(felt_[1]);
  done.limited_first = limited(felt_[0]);
  done.limited_second = limited(felt_[1]);
  if (felt_[0].limited + felt_[1].limited > 0) ++limited_trials_;
  if (table_) table_->add(done);
  row.send(now, done);
  schedule_.answer(answer.interval);
  const Trial* next = schedule_.trial();
  if (next == nullptr) {
    phase_ = TrialPhase::done;
    until_ = now + params_.change;
  } else if (next->block != trial.block) {
    put_question(now, true);
  } else {
    change_over(now, 0);
  }
}

void Protocol::step(StepContext& context) {
  const Time now = context.now();
  const std::optional<Given> answer = given(now);
  check_settings(context);
  feel();
  switch (phase_) {
    case TrialPhase::waiting:
      if (answer) change_over(now, 0);
      break;
    case TrialPhase::changing:
    case TrialPhase::lift:
      change(now);
      break;
    case TrialPhase::first:
    case TrialPhase::second:
      if (now < until_) break;
      mute(now);
      if (interval_ == 0) {
        change_over(now, 1);
      } else {
        put_question(now, false);
      }
      break;
    case TrialPhase::answering:
      if (answer) take(*answer, now);
      break;
    case TrialPhase::done:
      if (now < until_ || ended_) break;
      ended_ = true;
      if (!params_.end_run) break;
      SetRequest end;
      end.kind = RequestKind::end_run;
      requests.send(now, end);
      break;
  }
  show(now);
}

void Protocol::show(Time now) {
  const Trial* trial = schedule_.trial();
  const auto blocks = static_cast<std::int32_t>(schedule_.blocks());
  ExperimentScreen shown;
  shown.phase = phase_;
  shown.trial = trial != nullptr && phase_ != TrialPhase::waiting ? trials_ + 1 : trials_;
  shown.block = trial != nullptr ? static_cast<std::int32_t>(trial->block) + 1 : blocks;
  shown.blocks = blocks;
  shown.progress = schedule_.progress();
  if (now < shown_ + screen_period && shown.phase == last_shown_) return;
  shown_ = now;
  last_shown_ = shown.phase;
  screen.send(now, shown);
}

void Protocol::report(Report& report) const {
  if (limited_trials_ == 0) return;
  report.remark(name_ + ": in " + std::to_string(limited_trials_) +
                " trials the device displayed less force than was wanted, so levels may have felt alike; see "
                "limited_1 and limited_2 in the table");
}

}  // namespace tactor
