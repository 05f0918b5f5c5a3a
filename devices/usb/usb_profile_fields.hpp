// What a UsbLink is made of, as bytes for another process. How the device is emulated stays here.
#pragma once

#include "devices/usb/profile.hpp"
#include "framework/core/bytes.hpp"

namespace tactor {

void fields(auto& bytes, SameAs<UsbChoice> auto& c) {
  bytes(c.serial, c.file);
}
void fields(auto& bytes, SameAs<UsbTransfers> auto& t) {
  bytes(t.kind, t.interface, t.in, t.out, t.in_size, t.out_size);
}
void fields(auto& bytes, SameAs<ReportField> auto& f) {
  bytes(f.name, f.at, f.type, f.order);
}
void fields(auto& bytes, SameAs<AxisInput> auto& a) {
  bytes(a.field, a.scale, a.offset);
}
void fields(auto& bytes, SameAs<AxisOutput> auto& a) {
  bytes(a.field, a.scale, a.limit);
}
void fields(auto& bytes, SameAs<Flag> auto& f) {
  bytes(f.field, f.bit, f.above, f.meaning);
}
void fields(auto& bytes, SameAs<FixedOutput> auto& f) {
  bytes(f.field, f.value);
}
void fields(auto& bytes, SameAs<InputLayout> auto& l) {
  bytes(l.size, l.fields, l.axes, l.buttons, l.faults);
}
void fields(auto& bytes, SameAs<OutputLayout> auto& l) {
  bytes(l.size, l.fields, l.axes, l.fixed);
}
void fields(auto& bytes, SameAs<UsbAxis> auto& a) {
  bytes(a.name, a.speed_max, a.jump_tolerance, a.effort_max);
}
void fields(auto& bytes, SameAs<UsbProfile> auto& p) {
  bytes(p.name, p.title, p.vendor, p.product, p.product_text, p.transfers, p.rate, p.report_timeout, p.asks_first,
        p.input, p.output, p.axes, p.resolution, p.calibration);
}

}  // namespace tactor
