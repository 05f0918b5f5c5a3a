// What a ModbusLink is made of, as bytes for another process. Places in files, and how the device is emulated, stay
// here.
#pragma once

#include "devices/modbus/client.hpp"
#include "devices/modbus/profile.hpp"
#include "framework/core/bytes.hpp"

namespace tactor::modbus {

void fields(auto& bytes, SameAs<LineSettings> auto& l) {
  bytes(l.baud, l.parity, l.stop_bits, l.unit, l.response_timeout, l.turnaround, l.silence, l.rate_max);
}
void fields(auto& bytes, SameAs<RegisterInfo> auto& r) {
  bytes(r.name, r.address, r.type, r.words, r.bytes, r.scale, r.unit, r.readable, r.writable, r.read_function,
        r.write_function, r.low_bit, r.bits);
}
void fields(auto& bytes, SameAs<Expectation> auto& e) {
  bytes(e.index, e.min, e.max);
}
void fields(auto& bytes, SameAs<Step> auto& s) {
  bytes(s.kind, s.index, s.value, s.time);
}
void fields(auto& bytes, SameAs<Axis> auto& a) {
  bytes(a.position, a.effort, a.direction.x, a.direction.y, a.direction.z, a.effort_max, a.speed_max, a.jump_tolerance,
        a.effort_continuous, a.thermal_time, a.magnitude, a.sign, a.positive, a.negative, a.zero);
}
void fields(auto& bytes, SameAs<StatusBit> auto& b) {
  bytes(b.bit, b.means, b.fault);
}
void fields(auto& bytes, SameAs<Status> auto& s) {
  bytes(s.index, s.bits, s.others_are_faults, s.holds, s.every);
}
void fields(auto& bytes, SameAs<Button> auto& b) {
  bytes(b.index, b.bit);
}
void fields(auto& bytes, SameAs<Watchdog> auto& w) {
  bytes(w.index, w.time);
}
void fields(auto& bytes, SameAs<Fence> auto& f) {
  bytes(f.function, f.address, f.count);
}
void fields(auto& bytes, SameAs<Endpoint> auto& e) {
  bytes(e.serial, e.host, e.port, e.path);
}
void fields(auto& bytes, SameAs<Profile> auto& p) {
  bytes(p.name, p.title, p.line, p.registers, p.identify, p.start_up, p.shut_down, p.calibrate, p.each_cycle, p.at_zero,
        p.combined, p.read_gap, p.status, p.buttons, p.watchdog, p.fence, p.axes);
}

}  // namespace tactor::modbus
