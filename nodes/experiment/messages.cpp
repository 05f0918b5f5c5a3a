#include "nodes/experiment/messages.hpp"

#include "framework/core/describe.hpp"

namespace tactor {

template <>
const MessageType& message_type<ExperimentScreen>() {
  using S = ExperimentScreen;
  static const MessageType type =
      Describe<S>(
          "experiment.Screen", "",
          "The state of an experiment for the screen: nothing in it tells condition or level. Stamped valid for "
          "the step that made it.")
          .choice("phase", &S::phase,
                  {{"waiting", TrialPhase::waiting, "The participant begins the block with any answer."},
                   {"lift", TrialPhase::lift, "The next interval begins once nothing is touched."},
                   {"changing", TrialPhase::changing, "The setting changes, and nothing is felt."},
                   {"first", TrialPhase::first, "The first interval."},
                   {"second", TrialPhase::second, "The second interval."},
                   {"answering", TrialPhase::answering, "The participant is asked which of the two it was."},
                   {"done", TrialPhase::done, "All trials are done."}},
                  "Phase of the trial.")
          .field("trial", "1", &S::trial, "Number of the trial, from 1; 0 before the first.")
          .field("block", "1", &S::block, "Number of the block, from 1.")
          .field("blocks", "1", &S::blocks, "Number of blocks of the experiment.")
          .field("progress", "1", &S::progress, "Part of the experiment that is done, from 0 to 1.")
          .type();
  return type;
}

template <>
const MessageType& message_type<ExperimentQuestion>() {
  using Q = ExperimentQuestion;
  static const MessageType type =
      Describe<Q>("experiment.Question", "",
                  "A question to a simulated observer, with what a person would have felt. Stamped valid for the time "
                  "at which it was asked.")
          .field("number", "1", &Q::number, "Count of the questions, from 1.")
          .field("begins", "1", &Q::begins,
                 "1: any answer begins a block, and nothing was felt. 0: a trial is asked about.")
          .field("comparison", "1", &Q::comparison, "Interval that held the comparison: 0 or 1.")
          .field("condition", "1", &Q::condition,
                 "Condition of the comparison, counted from 0 in the order of the graph file.")
          .field("other", "1", &Q::other, "Condition of the other interval, counted from 0.")
          .field("level", "1", &Q::level, "Level of the comparison, in the unit of the protocol.")
          .type();
  return type;
}

template <>
const MessageType& message_type<ExperimentAnswer>() {
  static const MessageType type =
      Describe<ExperimentAnswer>("experiment.Answer", "",
                                 "An answer to a question. Stamped valid for the time at which it was given.")
          .field("number", "1", &ExperimentAnswer::number, "Number of the question.")
          .field("interval", "1", &ExperimentAnswer::interval, "Interval that was chosen: 0 or 1.")
          .type();
  return type;
}

template <>
const MessageType& message_type<ExperimentRow>() {
  using R = ExperimentRow;
  static const MessageType type =
      Describe<R>("experiment.Row", "",
                  "A row of the table of an experiment: one trial. Stamped valid for the step that took the answer.")
          .field("trial", "1", &R::trial, "Number of the trial, from 1.")
          .field("run", "1", &R::run, "Number of the run, from 1: a run that continues the table has the next one.")
          .field("block", "1", &R::block, "Number of the block, from 1.")
          .field("condition", "1", &R::condition,
                 "Condition of the comparison, counted from 0 in the order of the graph file.")
          .field("other", "1", &R::other, "Condition of the other interval, counted from 0.")
          .field("comparison", "1", &R::comparison, "Interval that held the comparison: 1 or 2.")
          .field("response", "1", &R::response, "Interval that was chosen: 1 or 2.")
          .field("correct", "1", &R::correct,
                 "1: the comparison was chosen. 0: it was not. -1: there is no right answer.")
          .field("level", "1", &R::level, "Level of the comparison, in the unit of the protocol.")
          .field("response_time", "s", &R::response_time, "Time from the question to the answer.")
          .field("peak_first", "N", &R::peak_first,
                 "Largest force felt in the first interval, by norm; NaN where nothing measures it.")
          .field("peak_second", "N", &R::peak_second, "Largest force felt in the second interval; NaN likewise.")
          .field(
              "limited_first", "1", &R::limited_first,
              "Part of the ticks of the first interval at which the device displayed less than was wanted; NaN where "
              "nothing measures it.")
          .field("limited_second", "1", &R::limited_second, "The same part of the ticks of the second interval.")
          .type();
  return type;
}

}  // namespace tactor
