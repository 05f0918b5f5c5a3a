#include "devices/modbus/emulator/device.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactor::modbus {

namespace {

constexpr double longest_step_s = 5e-4;
constexpr int addresses = 65536;

bool all_of(const std::vector<bool>& known, int address, int count) {
  if (address < 0 || count < 0 || address + count > addresses) return false;
  return std::all_of(known.begin() + address, known.begin() + address + count, [](bool is) { return is; });
}

}  // namespace

EmulatedDevice::EmulatedDevice(Profile profile)
    : profile_(std::move(profile)), words_(addresses + 2), declared_(addresses), readable_(addresses) {
  know_addresses();
  for (const auto& [index, value] : profile_.emulated.initial) put(index, value);
  x_.assign(profile_.axes.size(), profile_.emulated.rest);
  v_.assign(profile_.axes.size(), 0.0);
  force_ = v_;
  shown_ = x_;
  show();
}

void EmulatedDevice::know_addresses() {
  std::vector<std::pair<int, int>> spans;  // from and to behind the last word
  for (const RegisterInfo& info : profile_.registers) spans.emplace_back(info.address, info.address + info.width());
  std::sort(spans.begin(), spans.end());
  const auto fill = [](std::vector<bool>& known, int from, int to) {
    std::fill(known.begin() + from, known.begin() + to, true);
  };
  int end = spans.empty() ? 0 : spans.front().first;
  for (const auto& [from, to] : spans) {
    fill(declared_, from, to);
    fill(readable_, from - end <= profile_.read_gap ? std::min(end, from) : from, to);
    end = std::max(end, to);
  }
  if (profile_.fence) {
    const Fence& fence = *profile_.fence;
    fill(readable_, fence.address, std::min(addresses, fence.address + fence.count));
  }
}

double EmulatedDevice::get(std::size_t index) const {
  const RegisterInfo& info = profile_.registers[index];
  return decode(info, words_.data() + info.address);
}

void EmulatedDevice::put(std::size_t index, double value) {
  const RegisterInfo& info = profile_.registers[index];
  encode(info, value, words_.data() + info.address);
}

double EmulatedDevice::effort_of(const Axis& axis) const {
  const double size = get(axis.effort);
  if (!axis.sign) return size;
  const double sign = get(*axis.sign), half = 0.5 * std::abs(profile_.registers[*axis.sign].scale);
  if (std::abs(sign - axis.negative) <= half) return -size;
  return std::abs(sign - axis.positive) <= half ? size : 0;
}

bool EmulatedDevice::enabled() const {
  if (expired_ || !any_command_) return false;
  const auto& condition = profile_.emulated.enabled;
  if (!condition) return true;
  const double value = get(condition->index);
  return value >= condition->min && value <= condition->max;
}

void EmulatedDevice::step(double dt) {
  const EmulatedDynamics& d = profile_.emulated;
  since_command_s_ += dt;
  if (profile_.watchdog && any_command_ && !expired_) {
    const double limit = get(profile_.watchdog->index);
    if (limit > 0 && since_command_s_ > limit) {
      expired_ = true;
      if (d.error) set_error(d.watchdog_bit);
    }
  }
  since_request_s_ += dt;
  if (d.silence && any_request_ && since_request_s_ > d.silence->after.seconds()) {
    put(d.silence->sets, d.silence->to);
    any_request_ = false;
  }
  const bool on = enabled();
  bool driven = false;
  for (std::size_t i = 0; i < x_.size(); ++i) {
    const double t = now_.seconds();
    const double hand = d.rest + d.swing * std::sin(2 * std::numbers::pi * d.swing_rate * t +
                                                    0.5 * std::numbers::pi * static_cast<double>(i));
    force_[i] = on ? effort_of(profile_.axes[i]) : 0;
    driven = driven || force_[i] != 0;
    const double from = x_[i];
    const double a = (force_[i] - d.damping * v_[i] - d.stiffness * (x_[i] - hand)) / d.mass;
    v_[i] += dt * a;
    x_[i] += dt * v_[i];
    if (x_[i] < 0 || x_[i] > d.travel) v_[i] = 0;
    x_[i] = std::clamp(x_[i], 0.0, d.travel);
    given_ += force_[i] * (x_[i] - from);
  }
  driven_s_ = driven ? driven_s_ + dt : 0;
}

void EmulatedDevice::advance(Time now) {
  if (!begun_) now_ = now;
  begun_ = true;
  while (now_ < now) {
    const double dt = std::min((now - now_).seconds(), longest_step_s);
    step(dt);
    now_ = now_ + Duration::from_seconds(std::max(dt, 1e-9));
  }
  show();
}

void EmulatedDevice::show() {
  for (std::size_t i = 0; i < x_.size(); ++i) {
    if (!stuck_) shown_[i] = x_[i];
    put(profile_.axes[i].position, shown_[i] + shown_offset_);
  }
}

bool EmulatedDevice::read(int address, int count, std::uint16_t* words) {
  if (!all_of(readable_, address, count)) return false;
  std::copy_n(words_.begin() + address, count, words);
  return true;
}

bool EmulatedDevice::write(int address, int count, const std::uint16_t* words) {
  if (!all_of(declared_, address, count)) return false;
  const auto touches = [&](std::size_t index) {
    const RegisterInfo& info = profile_.registers[index];
    return info.address < address + count && address < info.address + info.width();
  };
  for (int i = 0; i < count; ++i) {
    // What can only be read stays as it is.
    const auto is_written = [&](const RegisterInfo& info) {
      return info.writable && address + i >= info.address && address + i < info.address + info.width();
    };
    if (std::any_of(profile_.registers.begin(), profile_.registers.end(), is_written)) {
      words_[static_cast<std::size_t>(address) + static_cast<std::size_t>(i)] = words[i];
    }
  }
  for (const EmulatedDynamics::Reaction& r : profile_.emulated.reacts) {
    const double half = 0.5 * std::abs(profile_.registers[r.when].scale);
    if (touches(r.when) && std::abs(get(r.when) - r.value) <= half) put(r.sets, r.to);
  }
  const bool commands =
      std::any_of(profile_.axes.begin(), profile_.axes.end(), [&](const Axis& a) { return touches(a.effort); });
  const bool no_error = !profile_.emulated.error || get(*profile_.emulated.error) == 0;
  if (commands) {
    since_command_s_ = 0;
    any_command_ = true;
    ++commands_;
    if (no_error) expired_ = false;
  }
  return true;
}

void EmulatedDevice::set_error(int bit) {
  std::size_t index = 0;
  if (profile_.emulated.error) {
    index = *profile_.emulated.error;
  } else if (!profile_.status.empty()) {
    index = profile_.status.front().index;
  } else {
    return;
  }
  const RegisterInfo& info = profile_.registers[index];
  // Its counts are the bits, in whichever order its words are.
  RegisterInfo plain = info;
  plain.scale = 1;
  plain.bits = 0;
  plain.type = info.width() == 1 ? RegisterType::uint16 : RegisterType::uint32;
  std::uint16_t* words = words_.data() + info.address;
  const auto set = static_cast<std::uint32_t>(decode(plain, words)) | (std::uint32_t{1} << bit);
  encode(plain, static_cast<double>(set), words);
}

void EmulatedDevice::become_another() {
  for (const Expectation& e : profile_.identify) {
    const RegisterInfo& info = profile_.registers[e.index];
    for (int i = 0; i < info.width(); ++i)
      words_[static_cast<std::size_t>(info.address) + static_cast<std::size_t>(i)] = e.min > 0 ? 0 : 0x7fff;
  }
}

EmulatedState EmulatedDevice::state() const {
  return {x_.front(), force_.front(), effort_of(profile_.axes.front()), expired_, commands_, given_, now_};
}

}  // namespace tactor::modbus
