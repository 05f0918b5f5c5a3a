// What an engine tells of a run beside its messages: which node stepped when, as messages of its own.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "framework/core/message.hpp"
#include "framework/node/node.hpp"

namespace tactor {

/// A step that has passed. Its message is stamped valid for the time at which it began, produced when it had passed.
/// Under the virtual clock the difference is the modelled cost; live it is the time until the results were visible.
struct StepEvent {
  std::int32_t node = 0;  ///< index into the plan
};

/// A tick of a node in the real-time lane. Its message is stamped valid for the deadline, produced when the engine took
/// it out of the lane, with the count of the node's ticks so far as its sequence. A tick without one was missed.
struct TickEvent {
  static constexpr std::size_t most_inputs = 8;
  std::int32_t node = 0;          ///< index into the plan
  std::int32_t inputs = 0;        ///< entries of `seen` in use
  std::int64_t tick = 0;          ///< its number, from 0
  Phase phase = Phase::starting;  ///< as the tick saw it
  std::uint64_t sets = 0;         ///< changes of parameters that the node had been given by then
  /// By edge into the node, in the order of the plan: the sequence of the newest message that the tick saw, plus one;
  /// 0: none.
  std::array<std::uint64_t, most_inputs> seen{};
};

/// A new parameter of a node; without text, one of the node's requests is done. Its message is stamped with the time
/// from which it holds.
struct SetEvent {
  static constexpr std::size_t most_text = 256;
  std::int32_t node = 0;                       ///< index into the plan
  std::int32_t length = 0;                     ///< bytes of `text` in use
  std::array<std::uint8_t, most_text> text{};  ///< `parameter=value`, as in a graph file, UTF-8
};

/// The run stops: devices ramp down from now on, sinks get nothing more. Its message is stamped with that time.
struct StopEvent {
  std::int32_t failed = 0;  ///< 1: because something failed
};

template <>
const MessageType& message_type<StepEvent>();
template <>
const MessageType& message_type<StopEvent>();
template <>
const MessageType& message_type<TickEvent>();
template <>
const MessageType& message_type<SetEvent>();

}  // namespace tactor
