#include "devices/usb/emulator/fault_script.hpp"

#include <array>
#include <charconv>
#include <utility>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

constexpr std::array<std::pair<std::string_view, UsbFault>, 13> names{{{"unplug", UsbFault::unplug},
                                                                       {"replug", UsbFault::replug},
                                                                       {"silent", UsbFault::silent},
                                                                       {"short", UsbFault::short_report},
                                                                       {"long", UsbFault::long_report},
                                                                       {"empty", UsbFault::empty_report},
                                                                       {"jump", UsbFault::jump},
                                                                       {"stuck", UsbFault::stuck},
                                                                       {"status", UsbFault::status},
                                                                       {"garbage", UsbFault::garbage},
                                                                       {"stall", UsbFault::stall},
                                                                       {"unhomed", UsbFault::unhomed},
                                                                       {"well", UsbFault::well}}};

bool parse_seconds(std::string_view text, double& seconds) {
  if (text.ends_with(" s")) text.remove_suffix(2);
  if (text.ends_with("s")) text.remove_suffix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seconds);
  return error == std::errc{} && end == text.data() + text.size() && seconds >= 0 && seconds <= 1e6;
}

}  // namespace

bool parse_fault(std::string_view name, UsbFault& fault) {
  for (const auto& [known, value] : names) {
    if (known != name) continue;
    fault = value;
    return true;
  }
  return false;
}

std::string fault_names() {
  std::string all;
  for (const auto& [name, value] : names) all += (all.empty() ? "" : ", ") + std::string(name);
  return all;
}

std::string parse_fault_order(std::string_view text, FaultOrder& order) {
  const std::size_t at = text.find('@');
  if (at == std::string_view::npos) return "expected KIND@SECONDS, KIND@driven+SECONDS or KIND@+SECONDS";
  if (!parse_fault(text.substr(0, at), order.fault)) return "expected one of " + fault_names() + " before the @";
  std::string_view when = text.substr(at + 1);
  constexpr std::string_view driven = "driven";
  order.when = FaultOrder::When::time;
  if (when.starts_with(driven)) {
    order.when = FaultOrder::When::driven;
    when.remove_prefix(driven.size());
    if (when.empty()) when = "+0";
    if (!when.starts_with("+")) return "expected driven or driven+SECONDS after the @";
  } else if (when.starts_with("+")) {
    order.when = FaultOrder::When::after;
  }
  if (when.starts_with("+")) when.remove_prefix(1);
  if (!parse_seconds(when, order.seconds)) return "expected seconds from 0 to 1e6 after the @";
  return {};
}

FaultOrder read_fault_order(const std::string& where, const std::string& text) {
  FaultOrder order;
  if (const std::string wrong = parse_fault_order(text, order); !wrong.empty()) {
    throw InputError(where + ": " + wrong + ", found \"" + text + "\"");
  }
  return order;
}

std::string to_text(const FaultOrder& order) {
  std::string text;
  for (const auto& [name, value] : names) {
    if (value == order.fault) text = name;
  }
  text += order.when == FaultOrder::When::time ? "@" : order.when == FaultOrder::When::driven ? "@driven+" : "@+";
  return text + std::to_string(order.seconds);
}

bool FaultScript::advance(double dt, bool opened, bool driven, UsbFault& fault) {
  began_ = began_ || opened;
  if (!began_) return false;
  time_ += dt;
  since_fault_ += dt;
  if (since_driven_ >= 0) since_driven_ += dt;
  if (driven && since_driven_ < 0) since_driven_ = 0;
  if (next_ >= orders_.size()) return false;
  const FaultOrder& order = orders_[next_];
  const double gone = order.when == FaultOrder::When::time     ? time_
                      : order.when == FaultOrder::When::driven ? since_driven_
                                                               : since_fault_;
  if (gone < order.seconds) return false;
  fault = order.fault;
  ++next_;
  since_fault_ = 0;
  since_driven_ = -1;
  return true;
}

}  // namespace tactor
