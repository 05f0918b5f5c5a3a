#include "devices/modbus/modbus_link.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "devices/modbus/claim_names.hpp"
#include "framework/realtime/monotonic_clock.hpp"

namespace tactor::modbus {

namespace {

constexpr std::size_t addresses = 65536;
constexpr Duration ask_again{10'000'000};
constexpr int goodbyes = 2;

std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::uint32_t bits_of(const RegisterInfo& info, const std::uint16_t* words) {
  RegisterInfo plain = info;
  plain.type = info.width() == 1 ? RegisterType::uint16 : RegisterType::uint32;
  plain.scale = 1;
  return static_cast<std::uint32_t>(decode(plain, words));
}

}  // namespace

ModbusLink::ModbusLink(Profile profile, Endpoint endpoint)
    : profile_(std::move(profile)),
      name_(profile_.name + " at " + endpoint.text() + ", unit " + std::to_string(profile_.line.unit)),
      plan_(plan_cycle(profile_)),
      client_(std::move(endpoint), profile_.line, plan_.fence, plan_.longest_answer),
      written_(addresses + 2),
      read3_(addresses + 2),
      read4_(addresses + 2) {}

ModbusLink::~ModbusLink() {
  close();
}

bool ModbusLink::run(const Transaction& t, LinkFailure& failure) {
  std::vector<std::uint16_t>& into = t.function == 4 ? read4_ : read3_;
  return client_.transfer(t, written_.data() + t.write_address, into.data() + t.read_address, failure);
}

void ModbusLink::put(std::size_t index, double value) {
  const RegisterInfo& info = profile_.registers[index];
  encode(info, value, written_.data() + info.address);
}

double ModbusLink::get(std::size_t index) const {
  const RegisterInfo& info = profile_.registers[index];
  return decode(info, (info.read_function == 4 ? read4_ : read3_).data() + info.address);
}

bool ModbusLink::write(std::size_t index, double value, LinkFailure& failure) {
  const RegisterInfo& info = profile_.registers[index];
  put(index, value);
  const int function = info.write_function == 6 ? 6 : 16;
  return run({.function = function, .write_address = info.address, .write_count = info.width()}, failure);
}

bool ModbusLink::read(std::size_t index, double& value, LinkFailure& failure) {
  const RegisterInfo& info = profile_.registers[index];
  if (!run({.function = info.read_function, .read_address = info.address, .read_count = info.width()}, failure)) {
    return false;
  }
  value = get(index);
  return true;
}

bool ModbusLink::identify(LinkFailure& failure) {
  for (const Expectation& e : profile_.identify) {
    double value = 0;
    const RegisterInfo& info = profile_.registers[e.index];
    const std::string expected =
        info.name + " at " + std::to_string(info.address) + " from " + number(e.min) + " to " + number(e.max);
    if (!read(e.index, value, failure)) {
      // A device without that register is not the one.
      if (failure.error != LinkError::exception) return false;
      failure = {LinkError::identity, "another device answers: expected " + expected + ", found " + failure.text, true};
      return false;
    }
    if (value >= e.min && value <= e.max) continue;
    failure = {LinkError::identity, "another device answers: expected " + expected + ", found " + number(value), true};
    return false;
  }
  return true;
}

bool ModbusLink::walk(const std::vector<Step>& steps, LinkFailure& failure) {
  for (const Step& step : steps) {
    if (step.kind == Step::Kind::write) {
      if (!write(step.index, step.value, failure)) return false;
      continue;
    }
    if (step.kind == Step::Kind::wait) {
      MonotonicClock::sleep_until(MonotonicClock::now() + step.time);
      continue;
    }
    const RegisterInfo& info = profile_.registers[step.index];
    const double half = 0.5 * std::abs(info.scale);
    const Instant give_up = MonotonicClock::now() + step.time;
    for (double value = 0;;) {
      if (!read(step.index, value, failure)) return false;
      if (std::abs(value - step.value) <= half) break;
      if (MonotonicClock::now() > give_up) {
        failure = {LinkError::identity,
                   "expected " + info.name + " to become " + number(step.value) + ", found " + number(value), true};
        return false;
      }
      MonotonicClock::sleep_until(MonotonicClock::now() + ask_again);
    }
  }
  return true;
}

void ModbusLink::put_command(const LinkCommand& command) {
  for (const auto& [index, value] : profile_.each_cycle) put(index, value);
  if (command.is_zero()) {
    for (const auto& [index, value] : profile_.at_zero) put(index, value);
  }
  for (std::size_t i = 0; i < profile_.axes.size(); ++i) {
    const Axis& axis = profile_.axes[i];
    const double effort = command.effort[i];
    put(axis.effort, axis.magnitude ? std::abs(effort) : effort);
    if (axis.sign) put(*axis.sign, effort > 0 ? axis.positive : effort < 0 ? axis.negative : axis.zero);
  }
}

bool ModbusLink::command_zero(LinkFailure& failure) {
  put_command({});
  for (const Transaction& t : plan_.each) {
    if (t.write_count > 0 && !run(t, failure)) return false;
  }
  return true;
}

// What an earlier connection has read of them is old.
bool ModbusLink::read_status(LinkFailure& failure) {
  cycles_ = 0;
  return std::all_of(plan_.seldom.begin(), plan_.seldom.end(), [&](const Transaction& t) { return run(t, failure); });
}

bool ModbusLink::claim(LinkFailure& failure) {
  const Endpoint& endpoint = client_.endpoint();
  const std::vector<std::string> names = claim_names(endpoint);
  if (!claims_.empty() && names == claimed_) return true;
  claims_.clear();
  claimed_ = names;
  if (names.empty() && !endpoint.serial) {
    failure = {LinkError::disconnected,
               "the host " + endpoint.host + " cannot be found; check its name and the network", true};
    return false;
  }
  std::string why;
  const auto take = [&](const std::string& name, Claim::Sharing sharing) {
    if (claims_.emplace_back().take(name, why, sharing)) return true;
    claims_.clear();
    failure = {LinkError::disconnected, why, true};
    return false;
  };
  const std::string unit = " unit " + std::to_string(profile_.line.unit);
  for (const std::string& name : names) {
    const auto sharing = endpoint.serial ? Claim::Sharing::alone : Claim::Sharing::process;
    if (!take(name, sharing)) return false;
    if (!endpoint.serial && !take(name + unit, Claim::Sharing::alone)) return false;
  }
  return true;
}

bool ModbusLink::open(LinkFailure& failure) {
  started_ = false;
  if (!claim(failure)) return false;
  const auto opened = [&] {
    if (!client_.connect(failure) || !identify(failure)) return false;
    started_ = true;
    if (profile_.watchdog && !write(profile_.watchdog->index, profile_.watchdog->time.seconds(), failure)) return false;
    return command_zero(failure) && walk(profile_.start_up, failure) && command_zero(failure) && read_status(failure);
  };
  if (opened()) return true;
  close();
  return false;
}

bool ModbusLink::exchange(const LinkCommand& command, LinkSample& sample, LinkFailure& failure) {
  put_command(command);
  for (const Transaction& t : plan_.each) {
    if (!run(t, failure)) return false;
  }
  if (!plan_.seldom.empty()) {
    const std::uint64_t turn = cycles_ / static_cast<std::uint64_t>(plan_.seldom_every);
    if (cycles_ % static_cast<std::uint64_t>(plan_.seldom_every) == 0 &&
        !run(plan_.seldom[turn % plan_.seldom.size()], failure)) {
      return false;
    }
  }
  ++cycles_;
  for (std::size_t i = 0; i < profile_.axes.size(); ++i) sample.q[i] = get(profile_.axes[i].position);
  for (std::size_t i = 0; i < profile_.buttons.size(); ++i) {
    const RegisterInfo& info = profile_.registers[profile_.buttons[i].index];
    const std::uint16_t* words = (info.read_function == 4 ? read4_ : read3_).data() + info.address;
    sample.buttons |= ((bits_of(info, words) >> profile_.buttons[i].bit) & 1U) << i;
  }
  sample.faults = faults(failure.text);
  return true;
}

std::uint32_t ModbusLink::faults(std::string& text) const {
  constexpr std::uint32_t another_master = std::uint32_t{1} << 31;
  std::uint32_t found = 0;
  for (const Status& status : profile_.status) {
    const RegisterInfo& info = profile_.registers[status.index];
    const double value = get(status.index);
    if (status.holds && std::abs(value - *status.holds) > 0.5 * std::abs(info.scale)) {
      found |= another_master;
      text +=
          (text.empty() ? "" : ", ") + info.name + " has become " + number(value) + ", but the start-up left it at " +
          number(*status.holds) +
          ": another master writes to this device, or the device changed the register itself; end the other program";
    }
    std::uint32_t set = bits_of(info, (info.read_function == 4 ? read4_ : read3_).data() + info.address);
    for (const StatusBit& bit : status.bits) {
      if (((set >> bit.bit) & 1U) == 0) continue;
      set &= ~(std::uint32_t{1} << bit.bit);
      if (!bit.fault) continue;
      found |= std::uint32_t{1} << bit.bit;
      text += (text.empty() ? "the device reports: " : ", ") + bit.means;
    }
    if (!status.others_are_faults || set == 0) continue;
    found |= set;
    for (int bit = 0; bit < 32; ++bit) {
      if (((set >> bit) & 1U) == 0) continue;
      text += (text.empty() ? "the device reports: " : ", ") + ("bit " + std::to_string(bit) + " of " + info.name);
    }
  }
  return found;
}

// Nobody comes after this one, so a single lost answer must not be the end of it.
void ModbusLink::let_go() {
  LinkFailure failure;
  bool done = false;
  for (int i = 0; i < goodbyes && !done && !failure.reopen; ++i) done = command_zero(failure);
  // A device that is silent is; one that refuses zero may still take its shut-down.
  if (!done && (failure.reopen || failure.error == LinkError::timeout)) return;
  failure = {};
  done = false;
  for (int i = 0; i < goodbyes && !done && !failure.reopen; ++i) done = walk(profile_.shut_down, failure);
}

void ModbusLink::close() {
  if (client_.connected() && started_) let_go();
  started_ = false;
  client_.disconnect();
}

}  // namespace tactor::modbus
