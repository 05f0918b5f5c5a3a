// What the nodes of an experiment tell one another, the screen and the recording.
#pragma once

#include <cstdint>

#include "framework/core/message.hpp"

namespace tactor {

/// The phase of a trial.
enum class TrialPhase : std::int32_t { waiting, lift, changing, first, second, answering, done };

/// The message for the screen of the participant.
struct ExperimentScreen {
  TrialPhase phase = TrialPhase::waiting;
  std::int32_t trial = 0;
  std::int32_t block = 0;
  std::int32_t blocks = 0;
  double progress = 0;
};

/// A question to a simulated observer.
struct ExperimentQuestion {
  std::int32_t number = 0;
  std::int32_t begins = 0;
  std::int32_t comparison = 0;
  std::int32_t condition = 0;
  std::int32_t other = 0;
  double level = 0;  ///< in the unit of the protocol
};

/// An answer to a question.
struct ExperimentAnswer {
  std::int32_t number = 0;
  std::int32_t interval = 0;
};

/// A row of the table.
struct ExperimentRow {
  std::int32_t trial = 0;
  std::int32_t run = 0;
  std::int32_t block = 0;
  std::int32_t condition = 0;
  std::int32_t other = 0;
  std::int32_t comparison = 0;
  std::int32_t response = 0;
  std::int32_t correct = 0;
  double level = 0;           ///< in the unit of the protocol
  double response_time = 0;   ///< s
  double peak_first = 0;      ///< N
  double peak_second = 0;     ///< N
  double limited_first = 0;   ///< 0 to 1
  double limited_second = 0;  ///< 0 to 1
};

template <>
const MessageType& message_type<ExperimentScreen>();
template <>
const MessageType& message_type<ExperimentQuestion>();
template <>
const MessageType& message_type<ExperimentAnswer>();
template <>
const MessageType& message_type<ExperimentRow>();

}  // namespace tactor
