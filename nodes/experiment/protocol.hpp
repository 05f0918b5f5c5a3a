// An experiment with a person: what is felt, the questions, the answers and their table.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "framework/core/messages.hpp"
#include "framework/node/info.hpp"
#include "framework/node/set_request.hpp"
#include "nodes/experiment/design.hpp"
#include "nodes/experiment/felt_force.hpp"
#include "nodes/experiment/messages.hpp"
#include "nodes/experiment/procedure.hpp"
#include "nodes/experiment/settings.hpp"
#include "nodes/experiment/table.hpp"

namespace tactor {

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
  [[nodiscard]] static ProtocolSettings settings(const Params& params);
  /// True where the procedure changes a level.
  [[nodiscard]] static bool has_level(const Params& params);
  /// The value of the parameter at that level in its SI unit. Throws ValueError where the unit does not exist.
  [[nodiscard]] static double level_si(const Params& params, double level);
  /// The same as a graph file has it: `1.1`, `800 N/m`.
  [[nodiscard]] static std::string level_text(const Params& params, double level);
  [[nodiscard]] static Design design(const Params& params);
  /// All that a table depends on but the seed.
  [[nodiscard]] static StudyDesign study_design(const Params& params);
  static NodeInfo declare();
  /// Mutes the force and opens the table. Throws InputError where the table may not be written or continued.
  void start(StepContext& context) override;
  void step(StepContext& context) override;
  void report(Report& report) const override;
  /// Each call is an answer.
  void tune(const Params& params);
  void request_done() override;

  Input<DeviceState> device;
  Input<Wrench> force, felt, wanted;
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
  /// While changing: what is done before an interval begins.
  enum class Change { fading, settling, opening };
  /// Settings that were asked for and do not hold yet.
  struct Unconfirmed {
    std::deque<std::string> texts;
    bool changed = false;  // the newest one was confirmed since the last step
    Time since;            // when the newest was confirmed, or the first of those that wait was asked for
  };
  /// The first answer since the last step, by whatever it came.
  [[nodiscard]] std::optional<Given> given(Time now);
  /// Where the run is, for messages: `trial 7, interval 1`.
  [[nodiscard]] std::string place() const;
  /// Sends a request for a setting, which `text` tells; it is unconfirmed until it holds.
  void ask(const SetRequest& request, std::string text, Time now);
  void ask(std::size_t setting, Time now);
  void ask_level(double level, Time now);
  /// Throws RunError where a setting has not been made in time.
  void check_settings(StepContext& context);
  void mute(Time now);
  /// Sets the condition and the level of the interval that comes next.
  void prepare(Time now);
  /// Gives the force back.
  void unmute(Time now);
  void begin_interval(Time now);
  /// While changing: what comes next.
  void change(Time now);
  /// Reads what the device displayed.
  void feel();
  [[nodiscard]] bool is_free() const;
  void change_over(Time now, int interval);
  void put_question(Time now, bool begins);
  void take(const Given& answer, Time now);
  void show(Time now);
  void resume_table();

  std::string name_;
  Params params_;
  std::vector<std::string> codes_;
  ProtocolSettings settings_;
  ParticipantCode participant_;
  std::uint64_t seed_;
  Schedule schedule_;
  std::optional<TrialTable> table_;
  TrialPhase phase_ = TrialPhase::waiting;
  Change change_ = Change::fading;
  bool ended_ = false;
  int interval_ = 0;  // 0 the first, 1 the second
  Time until_, asked_, shown_;
  std::optional<Answer> tuned_;
  Unconfirmed unconfirmed_;
  std::int32_t buttons_ = 0, questions_ = 0, trials_ = 0, run_ = 1, limited_trials_ = 0;
  FeltForce felt_;
  TrialPhase last_shown_ = TrialPhase::done;
};

}  // namespace tactor
