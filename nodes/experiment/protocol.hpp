// An experiment with a person: what is felt, the questions, the answers and their table.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "framework/core/messages.hpp"
#include "framework/node/info.hpp"
#include "framework/node/set_request.hpp"
#include "nodes/experiment/messages.hpp"
#include "nodes/experiment/procedure.hpp"
#include "nodes/experiment/table.hpp"

namespace tactor {

/// The settings of a condition: `select.use=first; coupling.k_0=800 N/m`.
std::vector<std::string> split_settings(const std::string& text);

/// experiment.protocol: asks for two intervals a trial, and changes what is felt only while the force is muted. See
/// declare().
class Protocol final : public Node {
 public:
  enum class Answer { none, first, second };
  struct Params {
    std::string participant;
    std::string folder;
    bool resume = false;
    Procedure procedure = Procedure::staircase;
    Mapping conditions;  // code -> settings
    ConditionOrder order = ConditionOrder::balanced;
    std::string mute, level, unit;
    double standard = 0;
    double start = 0;
    std::vector<double> steps;
    StepScale scale = StepScale::linear;
    int down = 2;
    double down_to_up = 1;
    double least = 0, most = 0;
    int reversals = 0, averaged = 0, most_trials = 0;
    std::vector<double> levels;
    int repeats = 1;
    Duration interval, change;
    double free_below = 0;  // N
    int button_first = 0, button_second = 0;
    Answer answer = Answer::none;
    bool end_run = true;
    double rate = 0;
  };
  Protocol(const Params& params, const NodeContext& context);
  /// Why an experiment cannot be made so; throws ValueError.
  static void check(const Params& params);
  /// What sets the level: `gain.factor=1.1`.
  static std::string level_setting(const Params& params, double level);
  [[nodiscard]] static Design design(const Params& params);
  static NodeInfo declare();
  /// Mutes the force and opens the table. Throws InputError where the table may not be written or continued.
  void start(StepContext& context) override;
  void step(StepContext& context) override;
  void report(Report& report) const override;
  /// Each call with an answer is an answer.
  void tune(const Params& params) { tuned_ = params.answer; }

  Input<DeviceState> device;
  Input<Wrench> force, felt;
  Input<ExperimentAnswer> answers;
  Output<SetRequest> requests;
  Output<ExperimentScreen> screen;
  Output<ExperimentQuestion> question;
  Output<ExperimentRow> row;

 private:
  struct Given {
    int interval = 0;
    Time at;
  };
  /// The first answer since the last step, by whatever it came.
  [[nodiscard]] std::optional<Given> given(Time now);
  void ask(const std::string& text, Time now);
  void mute(Time now);
  /// Sets the condition and the level of the interval that comes next.
  void prepare(Time now);
  void open(Time now);
  [[nodiscard]] bool is_free() const;
  void change_over(Time now, int interval);
  void put_question(Time now, bool begins);
  void take(const Given& answer, Time now);
  void next_trial(Time now);
  void show(Time now);
  void resume_table();

  Params params_;
  std::vector<std::string> codes_;
  std::vector<std::vector<std::string>> settings_;  // of each condition
  ParticipantCode participant_;
  std::uint64_t seed_;
  Schedule schedule_;
  std::optional<TrialTable> table_;
  TrialPhase phase_ = TrialPhase::waiting;
  bool prepared_ = false;  // while changing: the settings of the next interval are made
  bool ended_ = false;
  int interval_ = 0;  // 0 the first, 1 the second
  Time until_, asked_, shown_;
  std::optional<Answer> tuned_;
  std::int32_t buttons_ = 0, questions_ = 0, trials_ = 0, run_ = 1;
  std::array<double, 2> peak_{};  // N
  double felt_newest_ = 0;        // N
  TrialPhase last_shown_ = TrialPhase::done;
};

}  // namespace tactor
