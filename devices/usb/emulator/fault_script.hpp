// What is to go wrong with an emulated device, and when.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace tactor {

/// What can go wrong with an emulated USB device.
enum class UsbFault : std::uint8_t {
  unplug,  ///< the cable is pulled; the device loses its power, and what it knew with it
  replug,  ///< it is put back
  silent,  ///< no more reports
  short_report,
  long_report,
  empty_report,
  jump,     ///< all encoders are off by a quarter of their range from now on
  stuck,    ///< all encoders stand still
  status,   ///< the device reports a fault of its own
  garbage,  ///< reports of random bytes
  stall,    ///< the endpoint to the host stalls until it is told to go on
  unhomed,  ///< a Falcon says that its encoders have no zero
  well,     ///< an end to all of them
};

/// When a fault happens.
struct FaultOrder {
  enum class When : std::uint8_t {
    time,    ///< so long after the device was opened first
    driven,  ///< so long after it has been driven with an effort, for the first time since the fault before
    after,   ///< so long after the fault before
  };
  UsbFault fault = UsbFault::well;
  When when = When::time;
  double seconds = 0;
};

/// The fault of that name; false where there is none.
bool parse_fault(std::string_view name, UsbFault& fault);
/// Reads `KIND@SECONDS`, `KIND@driven+SECONDS` or `KIND@+SECONDS`. Empty, or what is wrong with it.
std::string parse_fault_order(std::string_view text, FaultOrder& order);
/// The same; throws InputError, with `where` in front, where it is wrong.
FaultOrder read_fault_order(const std::string& where, const std::string& text);
/// The same order as a text.
std::string to_text(const FaultOrder& order);
/// All names, with commas between.
std::string fault_names();

/// Goes through a list of faults, one after another.
class FaultScript {
 public:
  FaultScript() = default;
  explicit FaultScript(std::vector<FaultOrder> orders) : orders_(std::move(orders)) {}
  /// `dt` has passed, with the device driven or not. True where the next fault is due, which `fault` then is.
  bool advance(double dt, bool opened, bool driven, UsbFault& fault);

 private:
  std::vector<FaultOrder> orders_;
  std::size_t next_ = 0;
  double time_ = 0;           // since the device was opened first
  double since_fault_ = 0;    // since the one before
  double since_driven_ = -1;  // since it was driven first after the one before; below zero: not yet
  bool began_ = false;
};

}  // namespace tactor
