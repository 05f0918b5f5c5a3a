#include "devices/modbus/emulator/fault_schedule.hpp"

#include <span>

#include "devices/modbus/frame.hpp"

namespace tactor::modbus {

FaultSchedule::FaultSchedule(const std::vector<Fault>& faults, bool serial) : serial_(serial) {
  for (const Fault& fault : faults) add(fault);
}

void FaultSchedule::begin_due(EmulatedDevice& device) {
  const Instant now = MonotonicClock::now();
  for (Entry& e : faults_) {
    if (e.begun) continue;
    const bool due = e.fault.when_driven ? device.driven_for() > e.fault.time
                                         : first_request_ && (now - *first_request_).seconds() >= e.fault.time;
    if (due) begin(e, device);
  }
}

void FaultSchedule::begin(Entry& e, EmulatedDevice& device) {
  e.begun = true;
  e.began = MonotonicClock::now();
  switch (e.fault.kind) {
    case FaultKind::jump:
      device.jump(e.fault.value_or(0.06));
      e.over = true;
      break;
    case FaultKind::stuck:
      device.stick(true);
      break;
    case FaultKind::status:
      device.set_error(static_cast<int>(e.fault.value_or(5)));
      e.over = true;
      break;
    case FaultKind::another:
      device.become_another();
      drop_clients_ = true;
      e.over = true;
      break;
    case FaultKind::reset:
      drop_clients_ = !serial_;
      e.over = drop_clients_;
      break;
    default:
      break;
  }
}

void FaultSchedule::end_due(EmulatedDevice& device) {
  const auto lasts = [](FaultKind kind) {
    return kind == FaultKind::silent || kind == FaultKind::crc || kind == FaultKind::slave ||
           kind == FaultKind::length || kind == FaultKind::exception || kind == FaultKind::stuck ||
           kind == FaultKind::unplug;
  };
  for (Entry& e : faults_) {
    if (!e.begun || e.over || e.fault.value <= 0 || !lasts(e.fault.kind)) continue;
    if ((MonotonicClock::now() - e.began).seconds() < e.fault.value) continue;
    e.over = true;
    if (e.fault.kind == FaultKind::stuck) device.stick(false);
  }
}

void FaultSchedule::end_all(EmulatedDevice& device) {
  for (Entry& e : faults_) {
    if (!e.begun || e.over) continue;
    e.over = true;
    if (e.fault.kind == FaultKind::stuck) device.stick(false);
  }
}

const Fault* FaultSchedule::active(FaultKind kind) const {
  for (const Entry& e : faults_) {
    if (e.begun && !e.over && e.fault.kind == kind) return &e.fault;
  }
  return nullptr;
}

const Fault* FaultSchedule::take(FaultKind kind) {
  for (Entry& e : faults_) {
    if (!e.begun || e.over || e.fault.kind != kind) continue;
    e.over = true;
    return &e.fault;
  }
  return nullptr;
}

void FaultSchedule::put_check_sum(std::vector<std::uint8_t>& frame) const {
  if (!serial_) return;
  const std::uint16_t sum = check_sum(std::span<const std::uint8_t>(frame).first(frame.size() - 2));
  frame[frame.size() - 2] = static_cast<std::uint8_t>(sum & 0xffU);
  frame[frame.size() - 1] = static_cast<std::uint8_t>(sum >> 8);
}

unsigned FaultSchedule::disturb(std::vector<std::uint8_t>& frame) {
  if (frame.size() < 4) return 0;
  unsigned changes = 0;
  if (active(FaultKind::crc) != nullptr) {
    // Over TCP the transaction number stands where a check sum would tell.
    frame[serial_ ? frame.size() - 1 : 1] ^= 0x55U;
    ++changes;
  }
  if (active(FaultKind::slave) != nullptr) {
    // A whole answer of the slave beside it.
    std::uint8_t& unit = frame[serial_ ? 0 : 6];
    unit = static_cast<std::uint8_t>(unit + 1);
    put_check_sum(frame);
    ++changes;
  }
  if (active(FaultKind::length) != nullptr) {
    // Of the header over TCP, else the byte behind the function, which counts those of a read.
    ++frame[serial_ ? 2 : 5];
    put_check_sum(frame);
    ++changes;
  }
  if (take(FaultKind::reset) != nullptr) {
    for (std::uint8_t& byte : frame) byte ^= 0xa5U;
    ++changes;
  }
  return changes;
}

}  // namespace tactor::modbus
