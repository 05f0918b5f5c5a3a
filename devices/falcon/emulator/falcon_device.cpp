#include "devices/falcon/emulator/falcon_device.hpp"

#include <algorithm>
#include <cmath>

#include "devices/falcon/protocol.hpp"

namespace tactor {

namespace {

constexpr std::uint8_t all_axes = 7;
constexpr std::uint8_t held_button = 1;
constexpr double homing_travel = 0.1;  // rad, after which an arm has passed its mark

}  // namespace

std::vector<std::uint8_t> FalconDevice::descriptors() {
  const EndpointDescription endpoints[] = {{falcon::in_endpoint, 2}, {falcon::out_endpoint, 2}};
  return make_descriptors(emulation().vendor, emulation().product, 0xff, endpoints);
}

void FalconDevice::opened() {
  EmulatedDevice::opened();
  where_opened_ = arm().q();
  waiting_.clear();
  asked_.clear();
  stream_.clear();
  loading_ = false;
}

std::optional<std::size_t> FalconDevice::control(const UsbSetup& setup, std::span<std::uint8_t> data) {
  if (setup.type != falcon::to_chip) return EmulatedDevice::control(setup, data);
  switch (setup.request) {
    case falcon::reset:
      if (setup.value != falcon::purge_out) waiting_.clear();
      return 0;
    case falcon::baud:
      baud_ = setup.value;
      // The loader's end: what it has got runs.
      if (baud_ == falcon::baud_run && loaded_ > 0) state().firmware = 1;
      if (baud_ != falcon::baud_load) loading_ = false;
      return 0;
    case falcon::modem:
    case falcon::flow:
    case falcon::data_bits:
    case falcon::latency:
      return 0;
    default:
      return std::nullopt;
  }
}

void FalconDevice::answer_state() {
  FalconState shown_state{.counts = {}, .grip = held_button, .homed = 0};
  const std::array<double, 6> q = shown();
  const std::uint32_t homed = has(UsbFault::unhomed) ? 0 : state().homed;
  for (std::size_t i = 0; i < 3; ++i) {
    double count = std::round((q[i] - falcon::theta_zero) / falcon::theta_step);
    if ((homed & (1U << i)) == 0) count += 1000 + state().lost_zero;
    shown_state.counts[i] = static_cast<std::int16_t>(std::clamp(count, -32768.0, 32767.0));
  }
  shown_state.homed = static_cast<std::uint8_t>(homed);
  const FalconPacket packet = encode(shown_state);
  const auto bytes = spoilt({packet.begin(), packet.end()});
  if (bytes) waiting_.insert(waiting_.end(), bytes->begin(), bytes->end());
}

void FalconDevice::run(std::uint8_t byte) {
  if (!stream_.take(byte)) return;
  const auto order = decode_order(stream_.packet());
  if (!order) return;
  homing_ = order->home;
  std::array<double, 6> torque{};
  for (std::size_t i = 0; i < 3; ++i) torque[i] = order->motors[i] / falcon::words_per_Nm;
  drive(torque);
  answer_state();
}

void FalconDevice::out(std::uint8_t, std::span<const std::uint8_t> data) {
  for (const std::uint8_t byte : data) {
    if (baud_ == falcon::baud_ask) {
      asked_.push_back(byte);
      if (asked_.size() > falcon::hello.size()) asked_.pop_front();
      if (std::equal(asked_.begin(), asked_.end(), falcon::hello.begin(), falcon::hello.end())) {
        waiting_.insert(waiting_.end(), falcon::answer.begin(), falcon::answer.end());
        // It waits for firmware now; what ran before is gone.
        state().firmware = 0;
        state().homed = 0;
        loaded_ = 0;
      }
    } else if (baud_ == falcon::baud_load) {
      waiting_.push_back(byte);
      if (loading_) ++loaded_;
      if (byte == falcon::load) loading_ = true;
    } else if (state().firmware != 0) {
      run(byte);
    }
  }
}

std::optional<std::vector<std::uint8_t>> FalconDevice::in(std::uint8_t) {
  std::vector<std::uint8_t> bytes{0x01, 0x60};
  const std::size_t n = std::min(waiting_.size(), falcon::block);
  bytes.insert(bytes.end(), waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(n));
  waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(n));
  return bytes;
}

void FalconDevice::tick(double dt) {
  EmulatedDevice::tick(dt);
  if (!homing_ || state().firmware == 0) return;
  for (std::size_t i = 0; i < 3; ++i) {
    if (std::abs(arm().q()[i] - where_opened_[i]) > homing_travel) state().homed |= 1U << i;
  }
  state().homed &= all_axes;
}

}  // namespace tactor
