#include "devices/usb/emulator/emulator.hpp"

#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <unistd.h>

#include <ctime>

namespace tactor {

namespace {

constexpr long frame_ns = 1'000'000;
constexpr std::uint8_t to_host = 0x81;  // the endpoint of reports
constexpr std::size_t longest_order = 4096;
constexpr int priority = 40;  // below the loops that are tried on the device

double seconds(const timespec& t) {
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace

UsbEmulator::UsbEmulator(const Emulation& emulation)
    : state_(map_state(emulation.state)),
      device_(make_emulated_device(emulation, state_)),
      node_(emulation.path, *device_, state_->plugs % 126 + 1),
      script_(emulation.faults) {
  if (state_->plugged == 0) node_.unplug();
  // Opened for writing too, so that it does not end when a writer goes.
  if (!emulation.control.empty()) control_ = ::open(emulation.control.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
}

UsbEmulator::~UsbEmulator() {
  halt_frames();
  if (control_ >= 0) ::close(control_);
}

void UsbEmulator::halt_frames() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
}

void UsbEmulator::run() {
  stop_ = false;
  thread_ = std::thread([this] { loop(); });
}

void UsbEmulator::loop() {
  const sched_param punctual{.sched_priority = priority}, ordinary{};
  if (pthread_setschedparam(pthread_self(), SCHED_FIFO, &punctual) != 0) {
    pthread_setschedparam(pthread_self(), SCHED_OTHER, &ordinary);
  }
  pthread_setname_np(pthread_self(), "emulated-usb");
  timespec due{};
  clock_gettime(CLOCK_MONOTONIC, &due);
  double last = seconds(due);
  while (!stop_) {
    due.tv_nsec += frame_ns;
    if (due.tv_nsec >= 1'000'000'000) {
      due.tv_nsec -= 1'000'000'000;
      ++due.tv_sec;
    }
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, nullptr);
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    // Frames that were slept over are gone.
    if (seconds(now) - seconds(due) > 2e-9 * static_cast<double>(frame_ns)) due = now;
    frame(seconds(now) - last);
    last = seconds(now);
  }
}

void UsbEmulator::take_orders() {
  if (control_ < 0) return;
  char bytes[256];
  const ssize_t n = ::read(control_, bytes, sizeof bytes);
  if (n > 0) orders_.append(bytes, static_cast<std::size_t>(n));
  // Longer than every order: nobody ends that line, and it must not fill the memory.
  if (orders_.size() > longest_order && orders_.find('\n') == std::string::npos) orders_.clear();
  for (std::size_t end = orders_.find('\n'); end != std::string::npos; end = orders_.find('\n')) {
    UsbFault fault{};
    if (parse_fault(std::string_view(orders_).substr(0, end), fault)) begin(fault);
    orders_.erase(0, end + 1);
  }
}

void UsbEmulator::frame(double dt) {
  take_orders();
  const bool is_open = node_.is_open();
  driven_ = is_open && node_.locked([this] { return device_->is_driven(); });
  UsbFault fault{};
  if (script_.advance(dt, is_open, driven_, fault)) begin(fault);
  node_.frame(dt);
}

void UsbEmulator::begin(UsbFault fault) {
  switch (fault) {
    case UsbFault::unplug:
      if (!node_.plugged()) return;
      node_.unplug();
      node_.locked([this] {
        device_->lose_power();
        state_->plugged = 0;
      });
      return;
    case UsbFault::replug:
      node_.locked([this] { state_->plugged = 1; });
      node_.plug();
      return;
    case UsbFault::stall:
      node_.halt(to_host);
      return;
    default:
      node_.locked([&] { device_->begin(fault); });
  }
}

}  // namespace tactor
