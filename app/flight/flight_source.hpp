// Which flight file is meant, and its content.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "framework/realtime/flight_log.hpp"

namespace tactor {

struct FlightSource {
  std::filesystem::path path;
  std::string bytes;
  FlightLog log;
  bool is_running = false;  ///< the process still writes it
};

/// The flight file at `path`, or in the folder of results there. Without a path that of the process with the number
/// `process`; without either the newest that an ended process left, else that of a run that goes on. Throws InputError
/// with the file's name where it cannot be read, and where there is none.
FlightSource find_flight(const std::optional<std::filesystem::path>& path, std::optional<long> process);

}  // namespace tactor
