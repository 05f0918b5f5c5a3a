// What the nodes of an experiment tell one another, the screen and the recording.
#pragma once

#include <cstdint>

#include "framework/core/message.hpp"

namespace tactor {

/// Where a trial is.
enum class TrialPhase : std::int32_t {
  waiting,    ///< the participant begins the block with any answer
  lift,       ///< the next interval begins when nothing is touched
  changing,   ///< nothing is felt
  first,      ///< the first interval
  second,     ///< the second interval
  answering,  ///< which of the two?
  done,
};

/// What the screen shows: nothing that tells condition or level.
struct ExperimentScreen {
  TrialPhase phase = TrialPhase::waiting;
  std::int32_t trial = 0;  ///< from 1; 0 before the first
  std::int32_t block = 0;  ///< from 1
  std::int32_t blocks = 0;
  double progress = 0;  ///< 0 to 1
};

/// A question to a simulated observer, and what a person would have felt.
struct ExperimentQuestion {
  std::int32_t number = 0;      ///< counts the questions, from 1
  std::int32_t begins = 0;      ///< 1: any answer begins a block; nothing was felt
  std::int32_t comparison = 0;  ///< the interval with the comparison, 0 or 1
  std::int32_t condition = 0;   ///< of the comparison, in the order of the graph file, from 0
  std::int32_t other = 0;       ///< of the other interval
  double level = 0;             ///< of the comparison, in the unit of the protocol
};

/// An answer: the interval that was chosen.
struct ExperimentAnswer {
  std::int32_t number = 0;    ///< of the question
  std::int32_t interval = 0;  ///< 0 or 1
};

/// A row of the table.
struct ExperimentRow {
  std::int32_t trial = 0;       ///< from 1
  std::int32_t run = 0;         ///< from 1; a run that continues the table has the next number
  std::int32_t block = 0;       ///< from 1
  std::int32_t condition = 0;   ///< of the comparison, in the order of the graph file, from 0
  std::int32_t other = 0;       ///< of the other interval
  std::int32_t comparison = 0;  ///< the interval that held the comparison: 1 or 2
  std::int32_t response = 0;    ///< the interval that was chosen: 1 or 2
  std::int32_t correct = 0;     ///< 1 the comparison was chosen, 0 not, -1 there is no right answer
  double level = 0;             ///< of the comparison, in the unit of the protocol
  double response_time = 0;     ///< s, since the question was asked
  double peak_first = 0;        ///< N, the largest force felt in the first interval; NaN where nobody tells
  double peak_second = 0;       ///< N
  double limited_first = 0;     ///< 0 to 1: the part of the ticks at which the device displayed less than was wanted
  double limited_second = 0;    ///< the same of the second interval; NaN where nobody tells
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
