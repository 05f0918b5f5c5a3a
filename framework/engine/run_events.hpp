// The events of a run beside its messages, such as which node stepped when, as messages of their own.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "framework/core/message.hpp"
#include "framework/node/node.hpp"

namespace tactor {

/// A step that has passed.
struct StepEvent {
  std::int32_t node = 0;  ///< index into the plan
};

/// A tick of a node in the real-time lane.
struct TickEvent {
  static constexpr std::size_t most_inputs = 8;
  std::int32_t node = 0;  ///< index into the plan
  std::int32_t inputs = 0;
  std::int64_t tick = 0;
  Phase phase = Phase::starting;
  std::uint64_t sets = 0;
  std::array<std::uint64_t, most_inputs> seen{};
};

/// A parameter that was set, or a request that is done.
struct SetEvent {
  static constexpr std::size_t most_text = 256;
  std::int32_t node = 0;  ///< index into the plan
  std::int32_t length = 0;
  std::array<std::uint8_t, most_text> text{};  ///< UTF-8
};

/// The stop of a run.
struct StopEvent {
  std::int32_t failed = 0;
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
