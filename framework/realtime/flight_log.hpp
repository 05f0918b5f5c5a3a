// What a flight file holds, read and checked.
#pragma once

#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "framework/core/time.hpp"
#include "framework/realtime/flight_ring.hpp"

namespace tactor {

/// A node of the run, as its header names it.
struct FlightNode {
  struct In {
    std::string from;       ///< the node at whose output the edge begins
    std::string port;       ///< at which it ends
    bool is_outer = false;  ///< the writer steps in no loop, or in another one
  };
  std::string name, type;
  double rate_hz = 0;      ///< of a node in a loop; 0: it steps in none
  std::vector<In> inputs;  ///< its edges, in the order of the plan
};

/// The names of a run as the text that a header holds: `graph NAME`, then for each node `node NAME TYPE RATE`, and
/// behind it for each edge into it `in FROM PORT INNER|OUTER`, one a line with tabs between.
std::string flight_names(const std::string& graph, const std::vector<FlightNode>& nodes);

/// An event with its words.
struct FlightWords {
  Time time;
  std::uint16_t node = FlightRecord::no_node;
  FlightEvent event = FlightEvent::setting;
  std::string words;
};

/// The content of a flight file. Times are since the start of the run; before it they are negative.
struct FlightLog {
  std::string version;  ///< of the program that wrote it
  std::string graph;
  long process = 0;
  std::int64_t unix_ns = 0;  ///< of time zero, since 1970
  FlightEnd end = FlightEnd::none;
  std::vector<FlightNode> nodes;
  std::vector<FlightRecord> records;  ///< those that are whole, by their sequence
  std::int64_t origin_ns = 0;         ///< of CLOCK_MONOTONIC, at time zero
  bool has_begun = false;             ///< false: there is no time zero yet, and that of the file stands for it
  std::size_t torn = 0;               ///< records whose checksum is wrong

  [[nodiscard]] Time time_of(const FlightRecord& record) const { return {record.time_ns - origin_ns}; }
  /// The newest time of a record; zero where there is none.
  [[nodiscard]] Time last() const;
  [[nodiscard]] Time first() const;
  /// Of a record's node; empty where it has none.
  [[nodiscard]] std::string name_of(std::uint16_t node) const;
  /// The events, by their time.
  [[nodiscard]] std::vector<FlightWords> events() const;
};

/// What a record holds; of the kind that stands in it.
template <class Body>
Body body_of(const FlightRecord& record) {
  Body body;
  std::memcpy(static_cast<void*>(&body), record.body.data(), sizeof body);
  return body;
}

/// Reads the bytes of a file. Throws InputError, without the file's name, where it is no flight file, or that of a
/// version with another layout.
FlightLog read_flight(std::string_view bytes);

}  // namespace tactor
