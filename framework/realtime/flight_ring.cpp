// What is written into a ring. It needs no more than its header, because a guard writes too and links little.
#include "framework/realtime/flight_ring.hpp"

#include <algorithm>
#include <atomic>

#include "framework/core/check.hpp"

namespace tactor {

static_assert(std::atomic_ref<std::uint64_t>::is_always_lock_free);

FlightRing::FlightRing(std::span<std::byte> memory, const FlightPlace& place)
    : header_(reinterpret_cast<FlightHeader*>(memory.data())),
      records_(reinterpret_cast<FlightRecord*>(memory.data() + place.records_at)),
      capacity_(place.capacity) {
  const bool fits = place.records_at >= sizeof(FlightHeader) && place.records_at <= memory.size() &&
                    place.capacity > 0 && place.capacity <= (memory.size() - place.records_at) / sizeof(FlightRecord);
  if (!fits || header_->magic != FlightHeader::right_magic) throw InputError("expected a flight file, found another");
}

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

}  // namespace tactor
