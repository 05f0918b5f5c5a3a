#include "app/flight/flight_source.hpp"

#include <algorithm>
#include <vector>

#include "framework/core/check.hpp"
#include "framework/core/input_file.hpp"
#include "framework/realtime/flight_file.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t most_flight_bytes = std::uint64_t{256} << 20U;

FlightSource read_source(const fs::path& path, bool is_running) {
  FlightSource source{path, read_input_file(path, most_flight_bytes), {}, is_running};
  try {
    source.log = read_flight(source.bytes);
  } catch (const InputError& error) {
    throw InputError(path.string() + ": " + error.what());
  }
  return source;
}

}  // namespace

FlightSource find_flight(const std::optional<fs::path>& path, std::optional<long> process) {
  const std::vector<FoundFlight> flights = find_flights();
  if (path) {
    const fs::path file = fs::is_directory(*path) ? *path / flight_name : *path;
    std::error_code ignored;
    const bool is_running = std::any_of(flights.begin(), flights.end(), [&](const FoundFlight& one) {
      return one.is_running && fs::equivalent(one.path, file, ignored);
    });
    return read_source(file, is_running);
  }
  const auto of_process = [&](const FoundFlight& one) { return one.process == process; };
  const auto has_ended = [](const FoundFlight& one) { return !one.is_running; };
  auto found = process ? std::find_if(flights.begin(), flights.end(), of_process)
                       : std::find_if(flights.begin(), flights.end(), has_ended);
  if (found == flights.end() && !process) found = flights.begin();
  if (found == flights.end()) {
    throw InputError(process ? "--of " + std::to_string(*process) +
                                   ": expected a process with a flight recorder, found none"
                             : "expected a flight file, found none: no run that records one goes on, and none has left "
                               "one; name the file or the folder of its results");
  }
  return read_source(found->path, found->is_running);
}

}  // namespace tactor
