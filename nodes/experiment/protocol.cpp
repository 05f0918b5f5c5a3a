#include "nodes/experiment/protocol.hpp"

#include <algorithm>
#include <utility>

#include "framework/core/check.hpp"
#include "framework/core/random.hpp"
#include "framework/core/value_error.hpp"

namespace tactor {

namespace {

constexpr Duration screen_period{100'000'000};
/// A setting that is not made within this, or a force that has not faded, has failed.
constexpr Duration most_wait{5'000'000'000};

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
      settings_(settings(params)),
      participant_(participant_code(params.participant)),
      seed_(derive_seed(context.seed, participant_.text)),
      schedule_(design(params), derive_seed(context.seed, "conditions"), participant_.number, seed_) {
  for (const auto& [code, text] : params.conditions) codes_.push_back(code);
  if (codes_.empty()) codes_.emplace_back("A");
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

void Protocol::ask(const SetRequest& request, std::string text, Time now) {
  if (unconfirmed_.texts.empty()) unconfirmed_.since = now;
  unconfirmed_.texts.push_back(std::move(text));
  requests.send(now, request);
}

void Protocol::ask(std::size_t setting, Time now) {
  ask(set_request(setting, place()), settings_.list[setting].text(), now);
}

void Protocol::ask_level(double level, Time now) {
  ask(number_request(*settings_.level, level_si(params_, level), place()),
      params_.level + "=" + level_text(params_, level), now);
}

void Protocol::tune(const Params& params) {
  tuned_ = params.answer;
}

void Protocol::request_done() {
  if (unconfirmed_.texts.empty()) throw RunError(name_ + ": a setting is in force that was not asked for");
  unconfirmed_.texts.pop_front();
  unconfirmed_.changed = true;
}

void Protocol::check_settings(StepContext& context) {
  if (std::exchange(unconfirmed_.changed, false)) unconfirmed_.since = context.now();
  // A run that stops does nothing any more that is asked for.
  if (unconfirmed_.texts.empty() || context.phase() == Phase::stopping) return;
  if (context.now() < unconfirmed_.since + most_wait) return;
  throw RunError(place() + ": " + unconfirmed_.texts.front() + " was not made within " +
                 std::to_string(static_cast<int>(most_wait.seconds())) +
                 " s; the table keeps the trials that were answered");
}

void Protocol::mute(Time now) {
  ask(settings_.muted, now);
}

void Protocol::prepare(Time now) {
  const Trial& trial = *schedule_.trial();
  const bool comparison = interval_ == trial.comparison;
  const ProtocolSettings::Range condition = settings_.conditions[comparison ? trial.condition : trial.other];
  for (std::size_t i = condition.begin; i < condition.end; ++i) ask(i, now);
  if (settings_.level && params_.level != params_.mute) ask_level(comparison ? trial.level : 0, now);
}

void Protocol::unmute(Time now) {
  const Trial& trial = *schedule_.trial();
  if (settings_.level && params_.level == params_.mute) {
    ask_level(interval_ == trial.comparison ? trial.level : 0, now);
  } else {
    ask(settings_.unmuted, now);
  }
}

void Protocol::begin_interval(Time now) {
  phase_ = interval_ == 0 ? TrialPhase::first : TrialPhase::second;
  until_ = now + params_.interval;
  felt_.begin(static_cast<std::size_t>(interval_), felt.connected());
}

void Protocol::change(Time now) {
  // Nothing goes on before the settings that were asked for hold, and have had their time.
  if (!unconfirmed_.texts.empty()) {
    until_ = now + params_.change;
    return;
  }
  if (change_ == Change::opening) return begin_interval(now);
  if (now < until_) return;
  if (change_ == Change::fading) {
    // Where somebody tells what is felt, nothing changes before it has faded.
    if (felt_.newest() > faded_force) {
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

void Protocol::feel() {
  const bool goes_on = phase_ == TrialPhase::first || phase_ == TrialPhase::second;
  felt_.read(felt, wanted, goes_on ? std::optional(static_cast<std::size_t>(interval_)) : std::nullopt);
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
  done.peak_first = felt_.peak(0);
  done.peak_second = felt_.peak(1);
  done.limited_first = felt_.limited_share(0);
  done.limited_second = felt_.limited_share(1);
  if (felt_.is_limited()) ++limited_trials_;
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
      requests.send(now, end_request());
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
