// Faults that an emulated line shows, and when.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tactor::modbus {

enum class FaultKind {
  silent,     ///< no answers, for `value` s (0: for ever)
  slow,       ///< every answer `value` s later (0: 0.2)
  dribble,    ///< every answer a byte each `value` s (0: 0.04)
  late,       ///< one answer `value` s late (0: 0.2), those after it in order
  crc,        ///< wrong check sums, for `value` s (0: for ever); over TCP a wrong transaction number
  slave,      ///< another slave answers, for `value` s (0: for ever)
  length,     ///< over TCP a wrong length in the header, else a wrong count of bytes, for `value` s (0: for ever)
  exception,  ///< exception 4 to every request, for `value` s (0: for ever)
  reset,      ///< the connection is ended once; on a serial line an answer of noise
  another,    ///< what identifies the device reads as that of another, and the connection is ended
  jump,       ///< the encoder shows `value` m more (0: 0.06)
  stuck,      ///< the encoder stands still, for `value` s (0: for ever)
  unplug,     ///< the serial adapter is pulled, for `value` s (0: for ever), and comes back as another terminal
  status,     ///< bit `value` (0: 5) of the error register is set
};

/// A fault and when it begins.
struct Fault {
  FaultKind kind = FaultKind::silent;
  bool when_driven = false;  ///< `time` counts while the device is driven with a force without a break
  double time = 0;           ///< s, else since the first request
  double value = 0;

  /// `value`, or `otherwise` where that is 0.
  [[nodiscard]] double value_or(double otherwise) const { return value == 0 ? otherwise : value; }
};

/// `KIND`, `KIND@TIME` or `KIND@driven+TIME`, with `:VALUE` behind it; times in s. Throws InputError, with the kinds,
/// for another text.
Fault parse_fault(const std::string& text);

std::string_view name_of(FaultKind kind);

}  // namespace tactor::modbus
