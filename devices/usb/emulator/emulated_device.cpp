#include "devices/usb/emulator/emulated_device.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "devices/falcon/emulator/falcon_device.hpp"

namespace tactor {

namespace {

constexpr double driven_above = 0.005;  // N or N m
constexpr double longest_tick = 0.02;   // s; what a stopped process has missed is not made up
constexpr std::uint8_t human_interface = 3, of_its_maker = 0xff;

}  // namespace

std::shared_ptr<PoweredState> map_state(const std::string& file) {
  const int fd = file.empty() ? -1 : ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (fd < 0) return std::make_shared<PoweredState>();
  const bool is_new = lseek(fd, 0, SEEK_END) < static_cast<off_t>(sizeof(PoweredState));
  void* memory = MAP_FAILED;
  if (!is_new || ftruncate(fd, sizeof(PoweredState)) == 0) {
    memory = mmap(nullptr, sizeof(PoweredState), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  }
  ::close(fd);
  if (memory == MAP_FAILED) return std::make_shared<PoweredState>();
  auto* state = static_cast<PoweredState*>(memory);
  if (is_new) *state = PoweredState{};
  return {state, [](PoweredState* s) { munmap(s, sizeof(PoweredState)); }};
}

EmulatedDevice::EmulatedDevice(const Emulation& emulation, std::shared_ptr<PoweredState> state)
    : e_(emulation), state_(std::move(state)), arm_(make_arm_geometry(e_.geometry, e_.numbers), e_.hand) {
  arm_.place(e_.start);
  if (e_.trace.empty()) return;
  trace_ = std::fopen(e_.trace.c_str(), "a");
  if (trace_ != nullptr && std::ftell(trace_) == 0)
    std::fprintf(trace_, "t,x,y,z,effort_1,effort_2,effort_3,faults,given\n");
}

EmulatedDevice::~EmulatedDevice() {
  if (trace_ != nullptr) std::fclose(trace_);
}

void EmulatedDevice::opened() {
  arm_.place(e_.start);
  effort_ = {};
  since_command_ = 0;
}

void EmulatedDevice::closed() {
  write_down();
}

void EmulatedDevice::tick(double dt) {
  dt = std::min(dt, longest_tick);
  since_command_ += dt;
  if (since_command_ > e_.watchdog) effort_ = {};
  arm_.advance(dt, effort_);
  time_ += dt;
  write_down();
}

void EmulatedDevice::write_down() {
  if (trace_ == nullptr) return;
  const Vec3& p = arm_.p_BD();
  std::fprintf(trace_, "%.6f,%.7g,%.7g,%.7g,%.6g,%.6g,%.6g,%u,%.9g\n", time_, p.x, p.y, p.z, effort_[0], effort_[1],
               effort_[2], faults_, arm_.given());
  if (time_ - written_ < 0.2) return;
  written_ = time_;
  std::fflush(trace_);
}

std::optional<std::size_t> EmulatedDevice::control(const UsbSetup& setup, std::span<std::uint8_t> data) {
  // Each time it is plugged in it is another one to who remembers its calibration.
  const std::string serial = e_.serial + "-" + std::to_string(state_->plugs);
  const char* texts[] = {"tactor emulator", e_.name.c_str(), serial.c_str()};
  return answer_standard_request(setup, data, descriptors(), texts);
}

void EmulatedDevice::drive(const std::array<double, 6>& effort) {
  effort_ = effort;
  since_command_ = 0;
  for (const double e : effort) largest_effort_ = std::max(largest_effort_, std::abs(e));
}

bool EmulatedDevice::is_driven() const {
  return std::any_of(effort_.begin(), effort_.end(), [](double e) { return std::abs(e) > driven_above; });
}

void EmulatedDevice::begin(UsbFault fault) {
  if (fault == UsbFault::well) {
    faults_ = 0;
    jump_ = {};
    return;
  }
  if (fault == UsbFault::stuck) stuck_at_ = shown();
  if (fault == UsbFault::jump) jump_.fill(0.25);
  faults_ |= 1U << static_cast<unsigned>(fault);
}

void EmulatedDevice::lose_power() {
  effort_ = {};
  state_->firmware = 0;
  state_->homed = 0;
  // Where it stands when it is switched on again is where its counters begin.
  state_->lost_zero += 137;
  ++state_->plugs;
}

std::array<double, 6> EmulatedDevice::shown() const {
  if (has(UsbFault::stuck)) return stuck_at_;
  std::array<double, 6> q = arm_.q();
  for (std::size_t i = 0; i < q.size(); ++i) q[i] += jump_[i];
  return q;
}

std::optional<std::vector<std::uint8_t>> EmulatedDevice::spoilt(std::vector<std::uint8_t> report) {
  if (has(UsbFault::silent)) return std::nullopt;
  if (has(UsbFault::empty_report)) report.clear();
  if (has(UsbFault::short_report)) report.resize(report.size() / 2);
  if (has(UsbFault::long_report)) report.resize(report.size() + 7);
  if (has(UsbFault::garbage)) {
    report.resize(random_() % 64);
    for (std::uint8_t& byte : report) byte = static_cast<std::uint8_t>(random_());
  }
  return report;
}

std::vector<std::uint8_t> ReportDevice::descriptors() {
  const std::uint8_t kind = emulation().bulk ? 2 : 3;
  const EndpointDescription endpoints[] = {{0x81, kind}, {0x01, kind}};
  return make_descriptors(emulation().vendor, emulation().product, emulation().bulk ? of_its_maker : human_interface,
                          endpoints);
}

void ReportDevice::opened() {
  EmulatedDevice::opened();
  if (plugs_ == state().plugs) return;
  plugs_ = state().plugs;
  made_ = report();
  command_.reset();
}

void ReportDevice::out(std::uint8_t, std::span<const std::uint8_t> data) {
  if (emulation().asks_first && made_) {
    command_.emplace(data.begin(), data.end());
  } else {
    obey(data);
  }
}

void ReportDevice::obey(std::span<const std::uint8_t> data) {
  const OutputLayout& layout = emulation().output;
  if (data.size() == layout.size) {
    std::array<double, 6> effort{};
    for (std::size_t i = 0; i < layout.axes.size(); ++i) {
      const AxisOutput& axis = layout.axes[i];
      effort[i] = layout.fields[axis.field].read(data) / axis.scale;
    }
    drive(effort);
  }
  made_ = report();
}

std::optional<std::vector<std::uint8_t>> ReportDevice::in(std::uint8_t) {
  if (!emulation().asks_first) {
    if (has(UsbFault::silent)) return std::nullopt;
    // Firmware has the next one ready before it is asked for.
    const std::vector<std::uint8_t> ready = made_ ? std::move(*made_) : report();
    made_ = report();
    return spoilt(ready);
  }
  if (!made_ || has(UsbFault::silent)) return std::nullopt;
  const std::vector<std::uint8_t> taken = std::move(*made_);
  made_.reset();
  if (command_) obey(*std::exchange(command_, std::nullopt));
  return spoilt(taken);
}

std::vector<std::uint8_t> ReportDevice::report() {
  const InputLayout& layout = emulation().input;
  std::vector<std::uint8_t> report(layout.size);
  const std::array<double, 6> q = shown();
  for (std::size_t i = 0; i < layout.axes.size(); ++i) {
    const AxisInput& axis = layout.axes[i];
    const ReportField& field = layout.fields[axis.field];
    double count = std::round((q[i] - axis.offset) / axis.scale) + state().lost_zero;
    // A counter of so many bits begins anew.
    if (field.span() > 0) count = count_from(0, count, field.span());
    field.write(report, count);
  }
  const auto raise = [&](const Flag& flag) {
    const ReportField& field = layout.fields[flag.field];
    field.write(report, flag.bit < 0 ? flag.above + 1 : field.read(report) + std::ldexp(1.0, flag.bit));
  };
  if (!layout.buttons.empty()) raise(layout.buttons.front());
  if (has(UsbFault::status) && !layout.faults.empty()) raise(layout.faults.front());
  return report;
}

std::unique_ptr<EmulatedDevice> make_emulated_device(const Emulation& emulation, std::shared_ptr<PoweredState> state) {
  if (emulation.kind == "falcon") return std::make_unique<FalconDevice>(emulation, std::move(state));
  return std::make_unique<ReportDevice>(emulation, std::move(state));
}

}  // namespace tactor
