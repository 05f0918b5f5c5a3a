#include "devices/falcon/falcon_link.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "devices/falcon/protocol.hpp"
#include "framework/core/check.hpp"
#include "framework/core/input_file.hpp"
#include "framework/realtime/monotonic_clock.hpp"

namespace tactor {

namespace {

constexpr Duration state_timeout{20'000'000};
constexpr Duration first_state_timeout{200'000'000};
constexpr Duration request_timeout{500'000'000};
constexpr Duration answer_timeout{200'000'000};
constexpr Duration homing_time{2'000'000'000};
constexpr Duration longest_goodbye{100'000'000};
constexpr int hello_tries = 10;

std::int16_t word(double torque_Nm) {
  const double value = falcon::words_per_Nm * torque_Nm;
  if (!std::isfinite(value)) return 0;
  return static_cast<std::int16_t>(std::lround(std::clamp(value, -falcon::word_max, falcon::word_max)));
}

}  // namespace

std::vector<std::uint8_t> read_falcon_firmware(const std::filesystem::path& file) {
  const InputFile input = open_input(file);
  if (!input.file) throw InputError("firmware " + file.string() + ": " + input.error);
  // One byte more than the most tells an image that is too large.
  std::vector<std::uint8_t> bytes(std::min<std::uint64_t>(input.size, falcon::most_firmware + 1));
  if (!input.file.read_all(bytes.data(), bytes.size())) {
    throw InputError("firmware " + file.string() + ": cannot be read: " + std::strerror(errno));
  }
  if (bytes.size() < falcon::least_firmware || bytes.size() > falcon::most_firmware) {
    throw InputError("firmware " + file.string() + ": expected a firmware image of " +
                     std::to_string(falcon::least_firmware) + " to " + std::to_string(falcon::most_firmware) +
                     " bytes, found " + (bytes.size() > falcon::most_firmware ? "more" : std::to_string(bytes.size())) +
                     "; take the image that came with the device's driver");
  }
  return bytes;
}

FalconLink::FalconLink(std::vector<std::uint8_t> firmware, const UsbChoice& choice)
    : firmware_(std::move(firmware)), selector_(selector_of(falcon::vendor, falcon::product, choice)) {}

void FalconLink::received(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < falcon::status_bytes) return;
  for (const std::uint8_t byte : bytes.subspan(falcon::status_bytes)) {
    if (!running_) {
      bytes_.push_back(byte);
      continue;
    }
    if (!stream_.take(byte)) continue;
    const auto state = decode_state(stream_.packet());
    if (!state) {
      ++spoilt_;
      continue;
    }
    state_ = *state;
    fresh_ = true;
  }
}

bool FalconLink::request(std::uint8_t request, std::uint16_t value, LinkFailure& failure) {
  const UsbResult result = port_->control(falcon::to_chip, request, value, 0, {}, request_timeout);
  if (result == UsbResult::ok) return true;
  failure = result == UsbResult::disconnected
                ? failure_of(result)
                : LinkFailure{LinkError::identity, "its serial chip does not accept request " + std::to_string(request),
                              true};
  return false;
}

/// Lets transfers end; false, with why, where one has failed.
bool FalconLink::wait(Duration most, LinkFailure& failure) {
  const UsbResult result = port_->wait(most);
  if (result == UsbResult::ok) return true;
  failure = failure_of(result);
  return false;
}

bool FalconLink::write(std::span<const std::uint8_t> bytes, LinkFailure& failure) {
  const Instant end = MonotonicClock::now() + answer_timeout;
  while (!port_->send(bytes)) {
    if (!wait(Duration{1'000'000}, failure)) return false;
    if (MonotonicClock::now() > end) {
      failure = {LinkError::timeout, "it accepts no bytes", true};
      return false;
    }
  }
  return true;
}

/// Waits until as many bytes have come, and takes them away; false where they are others.
bool FalconLink::expect(std::span<const std::uint8_t> bytes, Duration most, LinkFailure& failure) {
  const Instant end = MonotonicClock::now() + most;
  while (bytes_.size() < bytes.size() && MonotonicClock::now() < end) {
    if (!wait(end - MonotonicClock::now(), failure)) return false;
  }
  const bool same = bytes_.size() >= bytes.size() && std::equal(bytes.begin(), bytes.end(), bytes_.begin());
  if (!same) {
    failure = {LinkError::protocol,
               bytes_.size() < bytes.size() ? "its loader does not answer"
                                            : "its loader answers with other bytes than expected",
               true};
    bytes_.clear();
    return false;
  }
  bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(bytes.size()));
  return true;
}

bool FalconLink::run_mode(LinkFailure& failure) {
  if (!request(falcon::latency, 1, failure) || !request(falcon::baud, falcon::baud_run, failure) ||
      !request(falcon::reset, falcon::purge_in, failure) || !request(falcon::reset, falcon::purge_out, failure)) {
    return false;
  }
  running_ = true;
  fresh_ = false;
  stream_.clear();
  return true;
}

bool FalconLink::order(const FalconOrder& order, LinkFailure& failure) {
  return write(encode(order), failure);
}

bool FalconLink::wait_for_state(Duration most, LinkFailure& failure) {
  const Instant end = MonotonicClock::now() + most;
  const std::uint64_t spoilt_before = spoilt_;
  Duration left;
  do {
    if (!wait(fresh_ ? Duration{} : std::max(left, Duration{}), failure)) return false;
    if (fresh_) return true;
    left = end - MonotonicClock::now();
  } while (left.ns > 0);
  failure = spoilt_ > spoilt_before ? LinkFailure{LinkError::protocol, "a damaged packet"}
                                    : LinkFailure{LinkError::timeout, "no packet in time"};
  return false;
}

/// Whether firmware runs in it: a packet is answered by a packet. Twice, since the first may end half a packet.
bool FalconLink::answers(LinkFailure& failure) {
  for (int i = 0; i < 2; ++i) {
    failure = {};
    if (!order({.lights = FalconOrder::red, .home = true}, failure)) return false;
    if (wait_for_state(first_state_timeout, failure)) return true;
    if (failure.error == LinkError::reset) return false;
  }
  return false;
}

bool FalconLink::load_firmware(LinkFailure& failure) {
  if (firmware_.empty()) {
    failure = {LinkError::identity, "it has no firmware: give the path of the image by `firmware` (none is shipped)",
               true, true};
    return false;
  }
  running_ = false;
  const std::pair<std::uint8_t, std::uint16_t> set_up[] = {
      {falcon::reset, falcon::purge_in}, {falcon::reset, falcon::purge_out},      {falcon::latency, 16},
      {falcon::baud, falcon::baud_ask},  {falcon::data_bits, falcon::eight_bits}, {falcon::flow, 0},
      {falcon::modem, falcon::rts_low},  {falcon::modem, falcon::dtr_low},        {falcon::modem, falcon::dtr_high}};
  for (const auto& [what, value] : set_up) {
    if (!request(what, value, failure)) return false;
  }
  bool greeted = false;
  for (int i = 0; i < hello_tries && !greeted; ++i) {
    bytes_.clear();
    if (!write(falcon::hello, failure)) return false;
    greeted = expect(falcon::answer, answer_timeout, failure);
    if (!greeted && failure.error == LinkError::reset) return false;
  }
  if (!greeted) {
    failure.error = LinkError::identity;
    failure.text += ", so it is not a Falcon or is not powered";
    return false;
  }
  const std::uint8_t load[] = {falcon::load};
  if (!request(falcon::modem, falcon::dtr_low, failure) || !request(falcon::baud, falcon::baud_load, failure) ||
      !write(load, failure) || !expect(load, answer_timeout, failure)) {
    return false;
  }
  for (std::size_t at = 0; at < firmware_.size(); at += falcon::block) {
    const std::span<const std::uint8_t> block(firmware_.data() + at, std::min(falcon::block, firmware_.size() - at));
    if (!write(block, failure)) return false;
    if (!expect(block, answer_timeout, failure)) {
      failure.text += " after " + std::to_string(at) + " bytes of firmware";
      return false;
    }
  }
  return run_mode(failure) && answers(failure);
}

bool FalconLink::home(LinkFailure& failure) {
  const Instant end = MonotonicClock::now() + homing_time;
  while (!state_.all_homed()) {
    if (MonotonicClock::now() > end) {
      failure = {LinkError::identity, "it is not homed: pull the handle out to its stop and push it in again", true};
      return false;
    }
    fresh_ = false;
    if (!order({.lights = FalconOrder::red, .home = true}, failure)) return false;
    if (!wait_for_state(state_timeout, failure) && failure.error == LinkError::reset) return false;
  }
  return true;
}

bool FalconLink::open_port(LinkFailure& failure) {
  std::string why;
  port_ = bus_.open(selector_, why);
  if (port_ == nullptr) {
    failure = {LinkError::disconnected, why, true};
    return false;
  }
  bytes_.clear();
  running_ = fresh_ = false;
  state_ = {};
  const UsbTransfers transfers{UsbTransfers::Kind::bulk, 0, falcon::in_endpoint, falcon::out_endpoint, 64, 64};
  if (const std::string refusal = port_->start(transfers, *this); !refusal.empty()) {
    failure = {LinkError::identity, refusal, true};
    return false;
  }
  return run_mode(failure);
}

bool FalconLink::open(LinkFailure& failure) {
  failure = {};
  if (open_port(failure) && (answers(failure) || (failure.error != LinkError::reset && load_firmware(failure))) &&
      home(failure)) {
    return true;
  }
  port_.reset();
  return false;
}

bool FalconLink::exchange(const LinkCommand& command, LinkSample& sample, LinkFailure& failure) {
  TACTOR_DEMAND(port_ != nullptr);
  failure = {};
  // An answer that came too late for its own cycle is no answer to this one.
  if (!wait(Duration{}, failure)) return false;
  FalconOrder next{.lights = FalconOrder::green, .home = true};
  // What the last packet said decides: an encoder that has lost its zero must not be pushed by.
  if (state_.all_homed()) {
    for (std::size_t i = 0; i < 3; ++i) next.motors[i] = word(command.effort[i]);
  }
  fresh_ = false;
  if (!order(next, failure) || !wait_for_state(state_timeout, failure)) return false;
  if (!state_.all_homed()) {
    failure = {LinkError::protocol, "its encoders have lost their zero", true};
    return false;
  }
  sample = {};
  for (std::size_t i = 0; i < 3; ++i) sample.q[i] = falcon::theta_zero + falcon::theta_step * state_.counts[i];
  sample.buttons = state_.grip;
  return true;
}

void FalconLink::close() {
  if (port_ == nullptr) return;
  LinkFailure ignored;
  const Instant end = MonotonicClock::now() + longest_goodbye;
  if (order({.lights = FalconOrder::red}, ignored)) {
    while (port_->sending() && MonotonicClock::now() < end) {
      if (port_->wait(Duration{1'000'000}) == UsbResult::disconnected) break;
    }
  }
  port_.reset();
}

}  // namespace tactor
