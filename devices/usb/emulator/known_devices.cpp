#include "devices/usb/emulator/known_devices.hpp"

#include "devices/falcon/protocol.hpp"

namespace tactor {

Emulation falcon_emulation() {
  Emulation e;
  e.kind = "falcon";
  e.vendor = falcon::vendor;
  e.product = falcon::product;
  e.name = "Falcon";
  e.bulk = true;
  e.geometry = "delta";
  e.watchdog = 0.1;
  e.start = {0, 0, 0.120};
  // Out and in, so that every arm passes its mark, and then down and up again.
  e.hand.times = {0, 0.5, 1, 3, 4, 6};
  e.hand.points = {{0, 0, 0.150}, {0.01, 0, 0.155}, {0, 0, 0.140}, {0, 0, 0.100}, {0.01, 0.005, 0.100}, {0, 0, 0.150}};
  return e;
}

Emulation emulation_of(const UsbProfile& profile) {
  Emulation e;
  e.vendor = profile.vendor;
  e.product = profile.product;
  e.name = profile.product_text.empty() ? profile.title : profile.product_text;
  e.bulk = profile.transfers.kind == UsbTransfers::Kind::bulk;
  e.asks_first = profile.asks_first;
  e.input = profile.input;
  e.output = profile.output;
  e.geometry = profile.kinematics;
  e.numbers = profile.numbers;
  const UsbEmulation& from = profile.emulation;
  e.watchdog = from.watchdog;
  e.start = {from.start[0], from.start[1], from.start[2]};
  e.hand = {from.mass, from.damping, from.stiffness, from.friction, from.hold, from.approach, from.times, from.points};
  return e;
}

}  // namespace tactor
