// tactor-attach-usb PROFILE [OPTIONS]: attaches an emulated device to this machine's kernel, through its vhci-hcd.
#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <random>
#include <sstream>

#include "devices/hardware/profile_files.hpp"
#include "devices/usb/emulator/emulated_device.hpp"
#include "devices/usb/emulator/known_devices.hpp"
#include "devices/usb/emulator/usbip.hpp"
#include "framework/core/check.hpp"
#include "framework/core/shown_text.hpp"
#include "framework/realtime/monotonic_clock.hpp"
#include "framework/yaml/file_finder.hpp"

namespace tactor {

namespace {

constexpr const char* vhci = "/sys/devices/platform/vhci_hcd.0/";
constexpr int full_speed = 2;        // enum usb_device_speed of the kernel
constexpr int on_bus = 1 << 16 | 2;  // bus 1, device 2 where it comes from, which means nothing here
constexpr Duration frame{1'000'000};
constexpr const char* usage =
    "tactor-attach-usb PROFILE [OPTIONS]\n"
    "Attaches an emulated USB device to this machine's kernel, until it is detached or this program ends. As root, "
    "with\n"
    "the module vhci-hcd. PROFILE is `falcon`, the name of a profile (polhem), or the path of one.\n"
    "  --fault KIND@WHEN   something goes wrong, as for tactor-emulate-usb; `unplug` ends the program\n"
    "  --trace FILE        what the device does, as CSV\n";

struct Options {
  std::string profile, trace;
  std::vector<FaultOrder> faults;
  bool help = false;
};

FaultOrder fault_of(const std::string& text) {
  const FaultOrder order = read_fault_order("--fault", text);
  if (order.fault == UsbFault::replug) throw InputError("--fault: start the program again instead of \"" + text + "\"");
  return order;
}

Options parse(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const auto value = [&] {
      if (i + 1 >= argc) throw InputError(word + ": expected a value");
      return std::string(argv[++i]);
    };
    if (word == "--help" || word == "-h")
      options.help = true;
    else if (word == "--fault")
      options.faults.push_back(fault_of(value()));
    else if (word == "--trace")
      options.trace = value();
    else if (word.starts_with("-") || !options.profile.empty())
      throw InputError("unknown argument " + word + "\n" + usage);
    else
      options.profile = word;
  }
  if (!options.help && options.profile.empty()) {
    throw InputError(std::string("expected the name of a profile\n") + usage);
  }
  return options;
}

Emulation make_emulation(const Options& options) {
  Emulation emulation = options.profile == "falcon"
                            ? falcon_emulation()
                            : emulation_of(read_usb_profile(named_file(options.profile, profiles_of("usb"))));
  emulation.serial = "attached-" + std::to_string(std::random_device{}());
  emulation.trace = options.trace;
  if (!options.trace.empty() && !std::ofstream(options.trace)) {
    throw InputError("--trace " + options.trace + ": cannot be written");
  }
  return emulation;
}

/// A free port of vhci-hcd.
int find_port() {
  std::ifstream file(std::string(vhci) + "status");
  if (!file) throw InputError(std::string(vhci) + ": not there; load the kernel's module: modprobe vhci-hcd");
  std::ostringstream text;
  text << file.rdbuf();
  const int port = usbip::free_port(text.str());
  if (port < 0) throw InputError(std::string(vhci) + "status: no free port; detach a device");
  return port;
}

/// Gives the kernel one end of a socket as the device; the other end, which is ours.
int attach(int port) {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) {
    throw RunError(std::string("no pair of sockets: ") + std::strerror(errno));
  }
  const std::string file = std::string(vhci) + "attach";
  const std::string line = std::to_string(port) + " " + std::to_string(ends[1]) + " " + std::to_string(on_bus) + " " +
                           std::to_string(full_speed);
  const int fd = ::open(file.c_str(), O_WRONLY | O_CLOEXEC);
  const bool taken = fd >= 0 && ::write(fd, line.data(), line.size()) == static_cast<ssize_t>(line.size());
  const int error = errno;
  if (fd >= 0) ::close(fd);
  ::close(ends[1]);
  if (!taken) {
    ::close(ends[0]);
    throw InputError(file + ": " + std::strerror(error) + "; the device can be attached by root alone");
  }
  return ends[0];
}

constexpr std::size_t most_unsent = std::size_t{1} << 20;  // bytes of answers

/// Carries bytes between a server and its socket.
class Cable {
 public:
  Cable(int socket, UsbFunction& function) : socket_(socket), server_(function) {}
  ~Cable() { ::close(socket_); }
  Cable(const Cable&) = delete;
  Cable& operator=(const Cable&) = delete;

  [[nodiscard]] bool is_open() const { return server_.is_open(); }
  /// False where the other end has hung up. Throws RunError where what comes is not usbip.
  bool frame(double dt) {
    // Whoever takes no answers is not asked for more requests.
    if (outgoing_.size() < most_unsent && !read()) return false;
    server_.frame(dt);
    const std::vector<std::uint8_t> answers = server_.take();
    outgoing_.insert(outgoing_.end(), answers.begin(), answers.end());
    return write();
  }

 private:
  bool read() {
    std::uint8_t bytes[65536];
    for (;;) {
      const ssize_t n = ::recv(socket_, bytes, sizeof bytes, MSG_DONTWAIT);
      if (n == 0) return false;
      if (n < 0) return errno == EAGAIN || errno == EINTR;
      const std::string wrong = server_.receive({bytes, static_cast<std::size_t>(n)});
      if (!wrong.empty()) throw RunError(wrong);
    }
  }
  bool write() {
    if (outgoing_.empty()) return true;
    const ssize_t n = ::send(socket_, outgoing_.data(), outgoing_.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (n < 0) return errno == EAGAIN || errno == EINTR;
    outgoing_.erase(outgoing_.begin(), outgoing_.begin() + n);
    return true;
  }

  int socket_;
  UsbipServer server_;
  std::vector<std::uint8_t> outgoing_;
};

volatile std::sig_atomic_t stopped = 0;

/// Frames of a millisecond until the cable is pulled, by either side, or the program is told to stop.
void serve(Cable& cable, EmulatedDevice& device, FaultScript script) {
  Instant last = MonotonicClock::now();
  while (stopped == 0) {
    MonotonicClock::sleep_until(MonotonicClock::now() + frame);
    const Instant now = MonotonicClock::now();
    const double dt = (now - last).seconds();
    last = now;
    UsbFault fault{};
    if (script.advance(dt, cable.is_open(), cable.is_open() && device.is_driven(), fault)) {
      if (fault == UsbFault::unplug) return;
      device.begin(fault);
    }
    if (!cable.frame(dt)) return;
  }
}

int run(int argc, char** argv) {
  const Options options = parse(argc, argv);
  if (options.help) {
    std::cout << usage;
    return 0;
  }
  const auto device = make_emulated_device(make_emulation(options), map_state(""));
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    signal(number, [](int) { stopped = 1; });
  }
  const int port = find_port();
  Cable cable(attach(port), *device);
  std::cout << "attached to port " << port << std::endl;
  serve(cable, *device, FaultScript(options.faults));
  std::cout << "detached; largest effort " << device->largest_effort() << " N m\n";
  return 0;
}

}  // namespace

}  // namespace tactor

int main(int argc, char** argv) {
  tactor::show_only_text();
  try {
    return tactor::run(argc, argv);
  } catch (const tactor::InputError& error) {
    std::cerr << error.what() << '\n';
    return 2;
  } catch (const std::exception& error) {
    std::cerr << "tactor-attach-usb: " << error.what() << '\n';
    return 1;
  }
}
