// How a ring is made in memory, and how one that is there is judged.
#include "framework/realtime/flight_ring.hpp"

#include <unistd.h>

#include <algorithm>
#include <new>

#include "framework/core/check.hpp"
#include "framework/core/clock.hpp"

namespace tactor {

namespace {

constexpr std::size_t flight_page = 4096;

std::uint64_t records_offset(std::size_t layout, std::size_t names) {
  const std::size_t texts = sizeof(FlightHeader) + layout + names;
  return (texts + flight_page - 1) / flight_page * flight_page;
}

FlightHeader& header_in(std::span<std::byte> memory) {
  TACTOR_DEMAND(memory.size() >= sizeof(FlightHeader));
  TACTOR_DEMAND(reinterpret_cast<std::uintptr_t>(memory.data()) % alignof(FlightHeader) == 0);
  return *reinterpret_cast<FlightHeader*>(memory.data());
}

FlightHeader& make_header(std::span<std::byte> memory, const FlightRing::Description& description) {
  TACTOR_DEMAND(memory.size() >= FlightRing::bytes(description) && description.capacity > 0);
  // Also so that every page is there before a loop writes to it.
  std::memset(memory.data(), 0, memory.size());
  const std::string layout = flight_layout();
  FlightHeader header;
  header.records_at = records_offset(layout.size(), description.names.size());
  header.capacity = description.capacity;
  header.layout_bytes = static_cast<std::uint32_t>(layout.size());
  header.names_bytes = static_cast<std::uint32_t>(description.names.size());
  header.unix_ns = clock_time(CLOCK_REALTIME).ns;
  header.made_ns = MonotonicClock::now().ns;
  header.process = getpid();
  description.version.copy(header.version.data(), header.version.size() - 1);
  std::memcpy(memory.data() + sizeof header, layout.data(), layout.size());
  std::memcpy(memory.data() + sizeof header + layout.size(), description.names.data(), description.names.size());
  return *new (memory.data()) FlightHeader(header);
}

FlightHeader& checked_header(std::span<std::byte> memory) {
  if (memory.size() < sizeof(FlightHeader)) throw InputError("expected a flight file, found one that is too short");
  FlightHeader& header = header_in(memory);
  const std::size_t there = memory.size() - sizeof header;
  const std::string_view layout(reinterpret_cast<const char*>(memory.data() + sizeof header),
                                std::min<std::size_t>(there, header.layout_bytes));
  const std::string wrong = fault_of(header, layout, memory.size());
  if (!wrong.empty()) throw InputError(wrong);
  return header;
}

}  // namespace

std::size_t FlightRing::bytes(const Description& description) {
  return records_offset(flight_layout().size(), description.names.size()) + description.capacity * sizeof(FlightRecord);
}

FlightRing::FlightRing(std::span<std::byte> memory, const Description& description)
    : header_(&make_header(memory, description)),
      records_(reinterpret_cast<FlightRecord*>(memory.data() + header_->records_at)),
      capacity_(header_->capacity) {}

FlightRing::FlightRing(std::span<std::byte> memory)
    : header_(&checked_header(memory)),
      records_(reinterpret_cast<FlightRecord*>(memory.data() + header_->records_at)),
      capacity_(header_->capacity) {}

std::string fault_of(const FlightHeader& header, std::string_view layout, std::uint64_t size) {
  if (header.magic != FlightHeader::right_magic) return "expected a flight file, found something else";
  const std::string by(header.version.data(), strnlen(header.version.data(), header.version.size()));
  if (header.format != FlightHeader::right_format || header.record_bytes != sizeof(FlightRecord) ||
      layout != flight_layout()) {
    return "tactor " + by + " wrote it, whose records have another layout than those of this version; read it with " +
           "tactor " + by;
  }
  const std::uint64_t texts = sizeof header + std::uint64_t{header.layout_bytes} + header.names_bytes;
  const bool fits = header.records_at >= texts && header.records_at <= size && header.capacity > 0 &&
                    header.capacity <= (size - header.records_at) / sizeof(FlightRecord);
  return fits ? "" : "expected a whole flight file, found a part of one";
}

}  // namespace tactor
