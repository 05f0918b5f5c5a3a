#include "nodes/experiment/protocol.hpp"

#include <algorithm>
#include <limits>
#include <set>

#include "framework/core/check.hpp"
#include "framework/core/text.hpp"
#include "framework/core/value_error.hpp"
#include "framework/node/declare.hpp"
#include "nodes/experiment/number_text.hpp"

namespace tactor {

namespace {

/// A letter and up to three digits: what a table may show.
bool is_code(const std::string& text) {
  return !text.empty() && text.size() <= 4 && text[0] >= 'A' && text[0] <= 'Z' &&
         std::all_of(text.begin() + 1, text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

/// Each condition sets the same parameters, so that nothing of one is left over in another, and none that the protocol
/// itself sets.
void check_parameters_of(const Protocol::Params& params) {
  std::set<std::string> first;
  const ProtocolSettings settings = Protocol::settings(params);
  for (std::size_t i = 0; i < params.conditions.size(); ++i) {
    const std::string& code = params.conditions[i].first;
    const std::string path = "conditions." + code;
    std::set<std::string> set;
    for (const Setting& setting : settings.of_condition(i)) set.insert(setting.parameter);
    for (const std::string& name : set) {
      if (name != params.mute && !(Protocol::has_level(params) && name == params.level)) continue;
      throw ValueError(path, path + ": " + name + " is set by the protocol itself, as its mute or level");
    }
    if (code == params.conditions.front().first) first = set;
    if (set == first) continue;
    throw ValueError(path, path + ": expected the same parameters as in " + params.conditions.front().first +
                               ", so that nothing of one condition is left over in another; give the missing ones the "
                               "value that the graph has");
  }
}

void check_conditions(const Protocol::Params& params) {
  for (const auto& [code, text] : params.conditions) {
    if (is_code(code)) continue;
    throw ValueError("conditions." + code,
                     "conditions: expected a code such as A or B2, a letter and up to three digits that tell nothing, "
                     "found \"" +
                         code + "\"");
  }
  check_parameters_of(params);
  if (params.procedure == Procedure::pairs && params.conditions.size() < 2) {
    throw ValueError("conditions", "conditions: expected two or more, which are compared with one another, found " +
                                       std::to_string(params.conditions.size()));
  }
}

void check_staircase(const Protocol::Params& params) {
  if (params.steps.empty()) throw ValueError("steps", "steps: expected a list of steps, found none");
  const double floor = params.scale == StepScale::factor ? 1.0 : 0.0;
  for (const double step : params.steps) {
    if (step > floor) continue;
    throw ValueError("steps", "steps: expected more than " + shortest(floor) + ", found " + shortest(step));
  }
  if (!(params.least < params.most) || params.start < params.least || params.start > params.most) {
    throw ValueError("start", "start: expected least <= start <= most and least < most, found least " +
                                  shortest(params.least) + ", start " + shortest(params.start) + ", most " +
                                  shortest(params.most));
  }
  if (!(params.least > 0)) {
    throw ValueError("least",
                     "least: expected more than 0, because at 0 no answer is right, found " + shortest(params.least));
  }
  if (params.averaged > params.reversals) {
    throw ValueError("averaged", "averaged: expected at most reversals, " + std::to_string(params.reversals) +
                                     ", found " + std::to_string(params.averaged));
  }
}

void check_levels(const Protocol::Params& params) {
  if (params.levels.empty()) throw ValueError("levels", "levels: expected a list of levels, found none");
  for (std::size_t i = 0; i < params.levels.size(); ++i) {
    if (!(params.levels[i] > 0)) {
      throw ValueError("levels", "levels: expected more than 0, because at 0 no answer is right, found " +
                                     shortest(params.levels[i]));
    }
    if (std::count(params.levels.begin(), params.levels.end(), params.levels[i]) > 1) {
      throw ValueError("levels", "levels: " + shortest(params.levels[i]) + " is there twice; see repeats");
    }
  }
}

}  // namespace

Design Protocol::design(const Params& params) {
  Design design;
  design.procedure = params.procedure;
  design.conditions = std::max<std::size_t>(1, params.conditions.size());
  design.order = params.order;
  design.staircase = {params.start, params.steps, params.scale,     params.down,     params.down_to_up,
                      params.least, params.most,  params.reversals, params.averaged, params.most_trials};
  design.levels = params.levels;
  design.repeats = params.repeats;
  return design;
}

StudyDesign Protocol::study_design(const Params& params) {
  StudyDesign design;
  const auto number = [&design](const char* name, double value) { design.add(name, shortest(value)); };
  const auto numbers = [&design](const char* name, const std::vector<double>& values) {
    std::string text;
    for (const double value : values) text += shortest(value) + " ";
    design.add(name, text);
  };
  std::string conditions;
  const ProtocolSettings made = settings(params);
  for (std::size_t i = 0; i < params.conditions.size(); ++i) {
    conditions += params.conditions[i].first + ": ";
    for (const Setting& setting : made.of_condition(i)) conditions += setting.text() + "; ";
  }
  design.add("conditions", conditions);
  number("order", static_cast<double>(params.order));
  number("procedure", static_cast<double>(params.procedure));
  design.add("mute", params.mute);
  number("interval", params.interval.seconds());
  number("change", params.change.seconds());
  number("free_below", params.free_below);
  if (has_level(params)) {
    design.add("level", params.level);
    design.add("unit", params.unit);
    number("standard", params.standard);
  }
  if (params.procedure != Procedure::staircase) {
    numbers("levels", has_level(params) ? params.levels : std::vector<double>());
    number("repeats", params.repeats);
    return design;
  }
  number("start", params.start);
  numbers("steps", params.steps);
  number("scale", static_cast<double>(params.scale));
  number("down", params.down);
  number("down_to_up", params.down_to_up);
  number("least", params.least);
  number("most", params.most);
  number("reversals", params.reversals);
  number("averaged", params.averaged);
  number("most_trials", params.most_trials);
  return design;
}

void Protocol::check(const Params& params) {
  static_cast<void>(participant_code(params.participant));
  check_conditions(params);
  if (has_level(params) && params.level.empty()) {
    throw ValueError("level", "level: expected the parameter that the level changes, such as gain.factor, found none");
  }
  if (params.procedure == Procedure::staircase) check_staircase(params);
  if (params.procedure == Procedure::constant) check_levels(params);
  if (params.button_first > 0 && params.button_first == params.button_second) {
    throw ValueError("button_second", "button_second: expected another button than button_first, " +
                                          std::to_string(params.button_first));
  }
}

namespace {

void declare_procedures(Declare<Protocol>& node) {
  using P = Protocol::Params;
  node.choice("procedure", &P::procedure,
              {{"staircase", Procedure::staircase}, {"constant", Procedure::constant}, {"pairs", Procedure::pairs}},
              std::optional(Procedure::staircase),
              "how the next trial is chosen: from the answers, from a list of levels, or from pairs of conditions")
      .real("start", &P::start, {.doc = "staircase: the first level", .default_value = 0})
      .reals("steps", &P::steps, 0, std::vector<double>{},
             {.doc = "staircase: the step up until the first reversal, the second, ...; the last one stays"})
      .choice("scale", &P::scale, {{"linear", StepScale::linear}, {"factor", StepScale::factor}},
              std::optional(StepScale::linear), "staircase: a step adds, or multiplies")
      .integer(
          "down", &P::down,
          {.doc = "staircase: right answers in a row that make the level fall", .default_value = 2, .min = 1, .max = 8})
      .real("down_to_up", &P::down_to_up,
            {.doc = "staircase: a step down as a share of a step up; if steps multiply, a share of its logarithm",
             .default_value = 1,
             .min = 0.05,
             .max = 20})
      .real("least", &P::least, {.doc = "staircase: smallest level", .default_value = 0})
      .real("most", &P::most, {.doc = "staircase: nor above", .default_value = 0})
      .integer(
          "reversals", &P::reversals,
          {.doc = "staircase: number of reversals after which it ends", .default_value = 10, .min = 1, .max = 1000})
      .integer("averaged", &P::averaged,
               {.doc = "staircase: number of last reversals whose mean level is the threshold",
                .default_value = 6,
                .min = 1,
                .max = 1000})
      .integer("most_trials", &P::most_trials,
               {.doc = "staircase: most trials before it ends; 0: no limit", .default_value = 200, .max = 100000})
      .reals("levels", &P::levels, 0, std::vector<double>{}, {.doc = "constant: the levels, each above 0"})
      .integer("repeats", &P::repeats,
               {.doc = "constant and pairs: number of times that each level or pair is shown; an even number shows "
                       "both orders equally often",
                .default_value = 10,
                .min = 1,
                .max = 10000});
}

void declare_study(Declare<Protocol>& node) {
  using P = Protocol::Params;
  node.text("participant", &P::participant, std::nullopt,
            "a code, never a name: one capital letter and one to three digits, such as P07. Number 0 is for practice, "
            "and nothing is written")
      .text("folder", &P::folder, std::nullopt,
            "folder of the tables, relative to the folder in which the run is started")
      .boolean("resume", &P::resume, false, "continue the participant's table instead of beginning one")
      .mapping("conditions", &P::conditions, false,
               "the settings of each code: `A: select.use=first; coupling.k_0=800 N/m`; empty: one condition, the "
               "graph as it is")
      .choice("order", &P::order,
              {{"balanced", ConditionOrder::balanced},
               {"random", ConditionOrder::random},
               {"as_listed", ConditionOrder::as_listed}},
              std::optional(ConditionOrder::balanced), "the order of the conditions of a participant")
      .text("mute", &P::mute, std::nullopt,
            "the parameter that is 0 between intervals and 1 in them, such as gain.factor")
      .text("level", &P::level, "", "the parameter that the level changes; it may be the parameter of `mute`")
      .text("unit", &P::unit, "", "the unit of the level and the standard, such as N/m")
      .real("standard", &P::standard,
            {.doc = "value of the parameter `level` in the standard interval. In the comparison it is this value plus "
                    "the level",
             .default_value = 1})
      .real("interval", &P::interval,
            {.doc = "duration of an interval", .unit = "s", .default_value = 3, .min = 0.05, .max = 600})
      .real("change", &P::change,
            {.doc = "time before each interval for the force to fade, and for a new condition to settle",
             .unit = "s",
             .default_value = 0.5,
             .min = 0.15,
             .max = 60})
      .real("free_below", &P::free_below,
            {.doc = "an interval begins only while the force at `force` is not above this",
             .unit = "N",
             .default_value = 0.1,
             .min = 0,
             .max = 100})
      .integer("button_first", &P::button_first,
               {.doc = "the device's button for the first interval, 1 for its first one; 0: none",
                .default_value = 0,
                .max = 31})
      .integer("button_second", &P::button_second,
               {.doc = "the device's button for the second interval; 0: none", .default_value = 0, .max = 31})
      .choice(
          "answer", &P::answer,
          {{"none", Protocol::Answer::none}, {"first", Protocol::Answer::first}, {"second", Protocol::Answer::second}},
          std::optional(Protocol::Answer::none), "the answer of a key or a page, set during the run")
      .boolean("end_run", &P::end_run, true, "end the run when all trials are done");
}

}  // namespace

NodeInfo Protocol::declare() {
  Declare<Protocol> node("experiment.protocol", "Leads a person through an experiment and records the answers.");
  node.details(
      "Each trial has two intervals and a question: which was more? In one interval, chosen by chance, the parameter "
      "`level` has the standard value; in the other it has the standard plus the level. `staircase` follows the "
      "answers, once for each condition (Levitt 1971: 1 up, `down` down; steps of `down_to_up` by Garcia-Perez 1998). "
      "`constant` takes fixed levels in random order, for a fit of the psychometric function. `pairs` compares the "
      "conditions with one another. The settings of a condition choose a method by `select.use`, or set any tunable "
      "parameter of any node. Before anything that is felt changes, `mute` takes the force away. The force comes back "
      "when the change has settled and, if `force` is connected, nothing is touched. An interval begins when the run "
      "has confirmed that all its settings are in force. If a setting cannot be made, or is not made within 5 s, the "
      "run ends. The participant's number chooses a row of a Williams square for the order of the conditions. All "
      "other random draws follow from the graph's seed and the participant's code.");
  node.input("device", &Protocol::device,
             {.doc = "for its buttons", .required = false, .queue = {QueuePolicy::drop_oldest, 64}})
      .input("force", &Protocol::force, {.doc = "the force of the scene, before it is muted", .required = false})
      .input("felt", &Protocol::felt,
             {.doc = "what the device displays; its largest value in each interval is kept",
              .required = false,
              .queue = {QueuePolicy::drop_oldest, 64}})
      .input("wanted", &Protocol::wanted,
             {.doc = "what the device would display without its limits, such as device.interpolated; compared with "
                     "`felt`",
              .required = false,
              .queue = {QueuePolicy::drop_oldest, 64}})
      .input("answers", &Protocol::answers,
             {.doc = "the answers of a simulated observer", .required = false, .queue = {QueuePolicy::drop_oldest, 4}})
      .output("requests", &Protocol::requests, "what is set")
      .output("screen", &Protocol::screen, "what a participant may see")
      .output("question", &Protocol::question, "the questions for a simulated observer")
      .output("row", &Protocol::row, "the rows of the table")
      .metric("experiment.trials", "1", "trials that were answered", Better::neither, &Protocol::trials_)
      .metric("experiment.limited_trials", "1",
              "trials in which the device displayed less than was wanted, so that levels may have felt alike",
              Better::lower,
              [](const Protocol& self) {
                return self.wanted.connected() ? std::optional<double>(self.limited_trials_) : std::nullopt;
              })
      .missing_where("nothing feeds `wanted`")
      .metric("experiment.threshold", "1", "the threshold of the staircase, in the unit of the level", Better::neither,
              [](const Protocol& self) { return self.schedule_.threshold(); })
      .left_out_when([](const Params& params, const MetricUse&) {
        if (params.procedure != Procedure::staircase) return std::string("the procedure is no staircase");
        return std::string(params.conditions.size() > 1 ? "there are several conditions, and the run is blind" : "");
      })
      .missing_where("the staircase has fewer reversals than are averaged");
  declare_study(node);
  declare_procedures(node);
  return node
      .rate("rate", &Params::rate, {.doc = "how often it looks at inputs and time, per second", .default_value = 200})
      .means("change", ParamMeaning::settling_time)
      .means("button_first", ParamMeaning::answer_button)
      .means("button_second", ParamMeaning::answer_button)
      .tunable({"answer"})
      .in_replay("folder", std::string())
      .sets([](const Params& params) { return settings(params).list; })
      .on_thread("experiment")
      .role(Role::other)
      .info();
}

}  // namespace tactor
