// Serves an emulated device on TCP or a pseudo-terminal, with the time that its line would take and faults.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <fstream>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "devices/modbus/emulator/device.hpp"
#include "devices/modbus/emulator/fault_schedule.hpp"
#include "devices/modbus/emulator/request.hpp"
#include "framework/realtime/monotonic_clock.hpp"

namespace tactor::modbus {

struct EmulatorOptions {
  bool serial = false;     ///< a pseudo-terminal, else TCP
  int port = 0;            ///< of TCP on 127.0.0.1; 0: any that is free
  bool line_delay = true;  ///< on a pseudo-terminal, which ignores the baud rate: the time that the characters take
  std::vector<Fault> faults;
  std::string link;  ///< a symbolic link that shows where the pseudo-terminal is; empty: none
  /// A file for `time position force commanded expired commands`, a line every 2 ms; empty: none. The time (ns,
  /// CLOCK_MONOTONIC) is that of the device's state, however late the line was written.
  std::string log;
};

/// An emulated device on its line. The device moves on a thread of its own; another answers, one request at a time and
/// those of one client after the other, as a device does: what waited while it was slow is answered afterwards. No
/// client holds it up: half a request waits until it is whole, and a client that does not read its answers is dropped.
class Emulator {
 public:
  /// Opens the line. Throws RunError where that fails, InputError where `link` is something else than a link.
  Emulator(Profile profile, EmulatorOptions options);
  ~Emulator();
  Emulator(const Emulator&) = delete;
  Emulator& operator=(const Emulator&) = delete;

  /// What `connect` of a graph is to be: `tcp:127.0.0.1:PORT` or `rtu:/dev/pts/N`.
  [[nodiscard]] const std::string& address() const { return address_; }
  void start();
  void stop();
  /// A fault from now on, or when its time comes.
  void inject(const Fault& fault);
  /// Ends what faults still do to answers and to the encoder.
  void end_all_faults();

  [[nodiscard]] EmulatedState state() const;
  [[nodiscard]] std::uint64_t answers() const { return answers_; }
  [[nodiscard]] std::uint64_t fault_answers() const { return fault_answers_; }  ///< answers changed or left out
  [[nodiscard]] std::uint64_t writes() const { return writes_; }                ///< requests that wrote
  [[nodiscard]] std::uint64_t connections() const { return connections_; }

 private:
  struct Client {
    int file = -1;
    std::vector<std::uint8_t> pending;  // of a request that is not whole
    Instant heard;                      // when the newest of them came
  };

  void open_tcp();
  void open_pty();
  void close_pty();
  void pull_or_plug();
  void move();
  void serve();
  void accept_client();
  [[nodiscard]] Client* client_of(int file);
  void hear(int file);
  void answer(int file, const Request& request);
  void send(int file, std::vector<std::uint8_t> frame);
  void drop(int file);
  void pause(double seconds) const;

  const EmulatorOptions options_;
  mutable std::mutex mutex_;  // of the device and the faults
  EmulatedDevice device_;
  FaultSchedule faults_;
  std::string address_;
  int listen_ = -1, terminal_ = -1, kept_open_ = -1;
  std::string linked_;   // what the link shows, where there is one
  Instant accept_from_;  // no client is accepted before
  std::vector<Client> clients_;
  Instant origin_;
  std::ofstream log_;
  std::atomic<bool> stop_{false};
  std::atomic<std::uint64_t> answers_{0}, fault_answers_{0}, writes_{0}, connections_{0};
  std::thread mover_, server_;
};

}  // namespace tactor::modbus
