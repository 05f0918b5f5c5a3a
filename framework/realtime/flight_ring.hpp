// The flight recorder: the last moments of a live run in a ring of memory that may outlive the process.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "framework/realtime/flight_record.hpp"
#include "framework/realtime/monotonic_clock.hpp"

namespace tactor {

/// How a run came to its end, as the run itself says it.
enum class FlightEnd : std::uint32_t {
  none,    ///< it goes on, or its process has ended without a word
  well,    ///< as planned, or because somebody asked for it
  failed,  ///< because of a failure
};

/// The begin of the memory of a ring. Two texts follow it, then the records, on a page of their own.
struct FlightHeader {
  static constexpr std::array<char, 8> right_magic{'T', 'A', 'C', 'T', 'O', 'R', 'F', 'R'};
  static constexpr std::uint32_t right_format = 1;

  std::array<char, 8> magic = right_magic;
  std::uint32_t format = right_format;
  std::uint32_t record_bytes = sizeof(FlightRecord);
  std::uint64_t records_at = 0;    ///< bytes from the begin
  std::uint64_t capacity = 0;      ///< records
  std::uint32_t layout_bytes = 0;  ///< of the text flight_layout(), behind the header
  std::uint32_t names_bytes = 0;   ///< of the text with the names of the run, behind that
  std::int64_t unix_ns = 0;        ///< since 1970, when the ring was made
  std::int64_t made_ns = 0;        ///< the same moment by CLOCK_MONOTONIC
  std::int64_t process = 0;        ///< the number of the process
  std::array<char, 32> version{};  ///< of the program, ended by a zero

  // Written while it runs.
  std::int64_t origin_ns = 0;          ///< time zero of the run, by CLOCK_MONOTONIC; 0: it has not begun
  FlightEnd end = FlightEnd::none;     ///< of the run
  std::uint32_t faults = 0;            ///< 1: something went wrong that is worth a look
  alignas(64) std::uint64_t next = 0;  ///< the sequence of the next record
};
static_assert(std::is_trivially_copyable_v<FlightHeader>);

/// Where the records of a ring lie in its memory.
struct FlightPlace {
  std::uint64_t records_at = 0;  ///< bytes from the begin
  std::uint64_t capacity = 0;    ///< records; 0: there is no ring
};

/// A ring of FlightRecords over memory that somebody else owns and that may be shared between processes.
///
/// Any number of threads write, each without waiting: a record takes the next place, and overwrites the oldest. In it
/// nothing allocates, locks, logs or calls the system, and a handler of signals may do it too. A process that ends in
/// the middle of a record leaves one whose checksum is wrong; a reader leaves that out.
class FlightRing {
 public:
  /// What the header of a ring tells.
  struct Description {
    std::string version;  ///< of the program
    std::string names;    ///< of the run, its nodes and edges (see flight_names)
    std::uint64_t capacity = 0;
  };
  /// The bytes that such a ring takes.
  static std::size_t bytes(const Description& description);
  /// Makes an empty ring and writes to every page of it. `memory` has at least `bytes(description)` bytes, is aligned
  /// to 64 bytes and outlives the ring.
  FlightRing(std::span<std::byte> memory, const Description& description);
  /// Goes on with the ring that `memory` holds, such as one of another process. Throws InputError, without a name of
  /// the file, where there is none of this version's layout.
  explicit FlightRing(std::span<std::byte> memory);
  /// Goes on with a ring that another process of the same build has made, and said where. Throws InputError where the
  /// memory is too small for it or holds none.
  FlightRing(std::span<std::byte> memory, const FlightPlace& place);

  [[nodiscard]] FlightPlace place() const noexcept {
    return {static_cast<std::uint64_t>(reinterpret_cast<std::byte*>(records_) - reinterpret_cast<std::byte*>(header_)),
            capacity_};
  }
  /// The file whose whole content is the memory, for processes that write too; -1: there is none. Not owned.
  void set_file(int file) noexcept { file_ = file; }
  [[nodiscard]] int file() const noexcept { return file_; }

  /// Adds a record; `body` is one of those of flight_record.hpp.
  template <class Body>
  void add(FlightKind kind, std::size_t node, Instant time, const Body& body) noexcept {
    static_assert(std::is_trivially_copyable_v<Body> && sizeof(Body) <= flight_body_bytes);
    FlightRecord record;
    record.kind = kind;
    record.node = static_cast<std::uint16_t>(node);
    record.time_ns = time.ns;
    record.sequence = take_place();
    std::memcpy(record.body.data(), &body, sizeof body);
    put(record);
  }
  /// Adds words, cut to `most_words` bytes.
  void tell(FlightEvent event, std::size_t node, Instant time, std::string_view words) noexcept;
  static constexpr std::size_t most_words = 4 * FlightText::most_bytes;

  /// Time zero of the run.
  void set_origin(Instant origin) noexcept;
  [[nodiscard]] Instant origin() const noexcept;
  /// Something went wrong that is worth a look at the records.
  void note_fault() noexcept;
  [[nodiscard]] bool has_fault() const noexcept;
  void set_end(FlightEnd end) noexcept;
  [[nodiscard]] FlightEnd end() const noexcept;

 private:
  [[nodiscard]] std::uint64_t take_place() noexcept;
  void put(FlightRecord& record) noexcept;

  FlightHeader* const header_;
  FlightRecord* const records_;
  const std::uint64_t capacity_;
  int file_ = -1;
};

/// Who writes into a ring: a node of the run, by its index into the plan. Without a ring nothing is written.
struct FlightWriter {
  FlightRing* ring = nullptr;
  std::size_t node = 0;

  explicit operator bool() const noexcept { return ring != nullptr; }
};

/// The checksum of a record, over all of it but the checksum itself.
std::uint32_t checksum_of(const FlightRecord& record) noexcept;

/// The text for what is wrong with the begin of a ring of `size` bytes; empty: nothing. `layout` is the text that
/// follows the header, as far as it is there.
std::string fault_of(const FlightHeader& header, std::string_view layout, std::uint64_t size);

}  // namespace tactor
