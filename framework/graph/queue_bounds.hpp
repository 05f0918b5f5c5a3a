// How large the queue of an edge, a feed or a tap may be: its places are made and touched before the run.
#pragma once

#include <cstdint>
#include <string>

#include "framework/core/message.hpp"
#include "framework/node/edge_queue.hpp"

namespace tactor {

inline constexpr std::uint32_t most_queued = 65'536;                        ///< messages
inline constexpr std::uint64_t most_queue_bytes = std::uint64_t{1} << 30U;  ///< of messages, without their arrays

/// Empty if such a queue of messages of that type can be made; else `expected ..., found ...`.
std::string queue_trouble(const Queue& queue, const MessageType& type);

/// The same as an InputError that begins with `where`.
void check_queue(const Queue& queue, const MessageType& type, const std::string& where);

}  // namespace tactor
