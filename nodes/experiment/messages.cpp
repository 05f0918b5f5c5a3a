#include "nodes/experiment/messages.hpp"

#include "framework/core/describe.hpp"

namespace tactor {

template <>
const MessageType& message_type<ExperimentScreen>() {
  static const MessageType type = Describe<ExperimentScreen>("experiment.Screen")
                                      .choice("phase", &ExperimentScreen::phase,
                                              {{"waiting", TrialPhase::waiting},
                                               {"lift", TrialPhase::lift},
                                               {"changing", TrialPhase::changing},
                                               {"first", TrialPhase::first},
                                               {"second", TrialPhase::second},
                                               {"answering", TrialPhase::answering},
                                               {"done", TrialPhase::done}})
                                      .field("trial", "1", &ExperimentScreen::trial)
                                      .field("block", "1", &ExperimentScreen::block)
                                      .field("blocks", "1", &ExperimentScreen::blocks)
                                      .field("progress", "1", &ExperimentScreen::progress)
                                      .type();
  return type;
}

template <>
const MessageType& message_type<ExperimentQuestion>() {
  static const MessageType type = Describe<ExperimentQuestion>("experiment.Question")
                                      .field("number", "1", &ExperimentQuestion::number)
                                      .field("begins", "1", &ExperimentQuestion::begins)
                                      .field("comparison", "1", &ExperimentQuestion::comparison)
                                      .field("condition", "1", &ExperimentQuestion::condition)
                                      .field("other", "1", &ExperimentQuestion::other)
                                      .field("level", "1", &ExperimentQuestion::level)
                                      .type();
  return type;
}

template <>
const MessageType& message_type<ExperimentAnswer>() {
  static const MessageType type = Describe<ExperimentAnswer>("experiment.Answer")
                                      .field("number", "1", &ExperimentAnswer::number)
                                      .field("interval", "1", &ExperimentAnswer::interval)
                                      .type();
  return type;
}

template <>
const MessageType& message_type<ExperimentRow>() {
  static const MessageType type = Describe<ExperimentRow>("experiment.Row")
                                      .field("trial", "1", &ExperimentRow::trial)
                                      .field("run", "1", &ExperimentRow::run)
                                      .field("block", "1", &ExperimentRow::block)
                                      .field("condition", "1", &ExperimentRow::condition)
                                      .field("other", "1", &ExperimentRow::other)
                                      .field("comparison", "1", &ExperimentRow::comparison)
                                      .field("response", "1", &ExperimentRow::response)
                                      .field("correct", "1", &ExperimentRow::correct)
                                      .field("level", "1", &ExperimentRow::level)
                                      .field("response_time", "s", &ExperimentRow::response_time)
                                      .field("peak_first", "N", &ExperimentRow::peak_first)
                                      .field("peak_second", "N", &ExperimentRow::peak_second)
                                      .field("limited_first", "1", &ExperimentRow::limited_first)
                                      .field("limited_second", "1", &ExperimentRow::limited_second)
                                      .type();
  return type;
}

}  // namespace tactor
