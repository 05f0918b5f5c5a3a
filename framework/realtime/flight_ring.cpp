#include "framework/realtime/flight_ring.hpp"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <new>

#include "framework/core/check.hpp"
#include "framework/core/clock.hpp"

namespace tactor {

namespace {

constexpr std::size_t flight_page = 4096;

static_assert(std::atomic_ref<std::uint64_t>::is_always_lock_free);

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

std::uint64_t FlightRing::take_place() noexcept {
  return std::atomic_ref(header_->next).fetch_add(1, std::memory_order_relaxed);
}

void FlightRing::put(FlightRecord& record) noexcept {
  record.checksum = checksum_of(record);
  std::memcpy(static_cast<void*>(records_ + record.sequence % capacity_), &record, sizeof record);
}

void FlightRing::tell(FlightEvent event, std::size_t node, Instant time, std::string_view words) noexcept {
  words = words.substr(0, most_words);
  FlightText text;
  text.event = event;
  const std::size_t parts = std::max<std::size_t>(1, (words.size() + text.text.size() - 1) / text.text.size());
  text.parts = static_cast<std::uint8_t>(parts);
  for (std::size_t part = 0; part < parts; ++part) {
    const std::string_view some = words.substr(part * text.text.size(), text.text.size());
    FlightRecord record;
    record.kind = FlightKind::event;
    record.node = static_cast<std::uint16_t>(node);
    record.time_ns = time.ns;
    record.sequence = take_place();
    if (part == 0) text.first = record.sequence;
    text.part = static_cast<std::uint8_t>(part);
    text.length = static_cast<std::uint8_t>(some.size());
    text.text.fill(0);
    std::memcpy(text.text.data(), some.data(), some.size());
    std::memcpy(record.body.data(), &text, sizeof text);
    put(record);
  }
}

void FlightRing::set_origin(Instant origin) noexcept {
  std::atomic_ref(header_->origin_ns).store(origin.ns, std::memory_order_relaxed);
}

Instant FlightRing::origin() const noexcept {
  return {std::atomic_ref(header_->origin_ns).load(std::memory_order_relaxed)};
}

void FlightRing::note_fault() noexcept {
  std::atomic_ref(header_->faults).store(1, std::memory_order_relaxed);
}

bool FlightRing::has_fault() const noexcept {
  return std::atomic_ref(header_->faults).load(std::memory_order_relaxed) != 0;
}

void FlightRing::set_end(FlightEnd end) noexcept {
  std::atomic_ref(header_->end).store(end, std::memory_order_relaxed);
}

FlightEnd FlightRing::end() const noexcept {
  return std::atomic_ref(header_->end).load(std::memory_order_relaxed);
}

std::uint32_t checksum_of(const FlightRecord& record) noexcept {
  constexpr std::size_t words = sizeof(FlightRecord) / sizeof(std::uint64_t);
  std::array<std::uint64_t, words> word{};
  std::memcpy(word.data(), &record, sizeof record);
  // The checksum itself, which comes first, counts as zero.
  std::memset(word.data(), 0, sizeof record.checksum);
  // Two sums beside each other, because each step waits for the one before.
  std::uint64_t a = 0x9e3779b97f4a7c15, b = 0xc2b2ae3d27d4eb4f;
  for (std::size_t i = 0; i < words; i += 2) {
    a = (a ^ word[i]) * 0xff51afd7ed558ccd;
    b = (b ^ word[i + 1]) * 0xc4ceb9fe1a85ec53;
    a ^= a >> 32U;
    b ^= b >> 32U;
  }
  const std::uint64_t sum = (a ^ (b >> 7U)) * 0x9fb21c651e98df25;
  return static_cast<std::uint32_t>(sum >> 32U);
}

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
