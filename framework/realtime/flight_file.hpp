// The file behind a flight recorder, in memory that is a file system, and where such files are found again.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "framework/core/file_descriptor.hpp"
#include "framework/realtime/flight_ring.hpp"

namespace tactor {

/// The name of a flight file in a folder of results.
inline constexpr const char* flight_name = "flight.ring";

/// A FlightRing in a file that is mapped and shared, so that its content stays when the process is killed. It is in
/// memory (tmpfs), because a disk would now and then hold up whoever writes to a page that is being written back; it is
/// lost when the machine stops.
///
/// The file goes with the object where the run ended well and without a fault, else it stays in its folder, for
/// `tactor flight`. The three newest that ended processes left are kept; older ones are removed when a new one is made.
class FlightFile {
 public:
  /// Makes the file. `name` is that of the graph. Throws RunError where there is no such file system or no room in it.
  FlightFile(const std::string& name, const FlightRing::Description& description);
  ~FlightFile();
  FlightFile(const FlightFile&) = delete;
  FlightFile& operator=(const FlightFile&) = delete;

  [[nodiscard]] FlightRing& ring() { return *ring_; }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// It stays, however the run ends.
  void ask_to_keep() { asked_ = true; }
  /// True where it is to stay: because that was asked, something went wrong, or the run has not ended well.
  [[nodiscard]] bool is_to_stay() const;
  /// Copies the content to `target`, which is its path from then on. Throws RunError where the disk refuses; then it
  /// stays.
  void move_to(const std::filesystem::path& target);

 private:
  std::filesystem::path path_;
  FileDescriptor file_;  // whose lock tells that the process lives
  std::span<std::byte> memory_;
  std::optional<FlightRing> ring_;
  bool asked_ = false;
  bool moved_ = false;
};

/// A flight file that somebody left or still writes.
struct FoundFlight {
  std::filesystem::path path;
  std::filesystem::file_time_type begun;
  long process = 0;
  bool is_running = false;  ///< its process lives
};
/// Those of this user in the folder of FlightFile, the newest first.
std::vector<FoundFlight> find_flights();

}  // namespace tactor
