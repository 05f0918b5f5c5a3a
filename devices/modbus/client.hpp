// A Modbus client over TCP or a serial line in which every call ends in bounded time and no answer but the right one is
// believed. libmodbus opens the line; frames are ours, because it compares too little of an answer.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "devices/hardware/claim.hpp"
#include "devices/hardware/link.hpp"
#include "devices/modbus/cycle_plan.hpp"
#include "devices/modbus/profile.hpp"
#include "framework/realtime/monotonic_clock.hpp"

namespace tactor::modbus {

/// Where a device is: `tcp:HOST:PORT` or `rtu:PATH`.
struct Endpoint {
  bool serial = false;
  std::string host;
  int port = 502;
  std::string path;  ///< of the serial port
  [[nodiscard]] std::string text() const;
};
/// Throws InputError, beginning with `connect`, for another text.
Endpoint parse_endpoint(const std::string& text);

/// Talks to one slave.
///
/// Bounds: an answer that is not complete by the response timeout has failed, however its bytes drip in, and so has a
/// request that the line does not take within another one: writes never block. What comes without end is thrown away
/// for a bounded time, and closing a serial port does not wait for what nobody takes. libmodbus' own recovery is off.
///
/// Answers: everything that an answer repeats of its request is compared (see judge_answer), so that the answer of
/// another unit, or one with a wrong length in its header, is refused over TCP as on a serial line. Bytes that wait on
/// the line before anything was asked are refused too: another master is on it, or it is disturbed.
///
/// Late answers: a serial answer carries nothing that tells which request it belongs to, so that the answer to a
/// request given up for lost would be taken for that to the next one, and show where the device was. After every
/// failure that leaves an answer possible (time-out, check sum, wrong slave, wrong length) the next call therefore
/// waits for a response timeout and the longest answer, throws away what has come until the line is silent, and then
/// sends the fence: a read whose answer differs in length from all answers of the cycle. Answers come in the order of
/// their requests; so after the fence has been answered no older one is under way, and before that an older answer is
/// refused by its length. On a serial line an exception proves nothing, because it has no length of its own to tell it
/// from an older one: the fence must be answered with words. The same is done after a serial port was opened, for what
/// an earlier session may have left under way. Over TCP the transaction number does that
/// too, and a new connection starts clean.
class Client {
 public:
  /// `longest_answer` in characters, of all that will be asked.
  Client(Endpoint endpoint, LineSettings line, Fence fence, int longest_answer);
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// Connects. A serial port is locked before anything is done to it, and refused where another program has it. Over
  /// TCP within the response timeout for each address that the host's name has, after the time that the system takes to
  /// look the name up.
  bool connect(LinkFailure& failure);
  /// Takes over a connection that was made elsewhere, for tests; the file is closed with the client.
  void attach(int file);
  void disconnect();
  [[nodiscard]] bool connected() const { return context_ != nullptr; }

  /// One request and its answer: writes `written` (write_count words), fills `read` (read_count words).
  bool transfer(const Transaction& transaction, const std::uint16_t* written, std::uint16_t* read,
                LinkFailure& failure);

  /// How often the line had to be cleared by a fence.
  [[nodiscard]] std::uint64_t fences() const { return fences_; }
  [[nodiscard]] const Endpoint& endpoint() const { return endpoint_; }

 private:
  struct Free {
    void operator()(void* context) const;
  };

  /// `where`: the path of a serial port, or the address of a host.
  bool make_context(const std::string& where);
  bool open_line(const std::string& where, LinkFailure& failure);
  bool clear_line(LinkFailure& failure);
  bool drain();
  bool throw_away();
  bool refuse_unasked(LinkFailure& failure);
  bool send_request(std::span<const std::uint8_t> frame, LinkFailure& failure);
  [[nodiscard]] int wait_for(short events, Instant give_up) const;
  bool request(const Transaction& transaction, const std::uint16_t* written, std::uint16_t* read, LinkFailure& failure);
  bool exchange(const Transaction& transaction, const std::uint16_t* written, std::uint16_t* read,
                LinkFailure& failure);
  bool fail_with(int error, LinkFailure& failure);
  [[nodiscard]] int file_of_line() const;
  void keep_silence();

  Endpoint endpoint_;
  LineSettings line_;
  Fence fence_;
  Duration longest_answer_;              // on the line
  PortLock lock_;                        // of a serial port; longer than it is open
  std::unique_ptr<void, Free> context_;  // modbus_t
  int transaction_ = 0;                  // over TCP, of the newest request
  std::vector<std::uint8_t> sent_;       // the newest request
  bool unclear_ = false;                 // an answer may still come
  std::int64_t silent_from_ns_ = 0;      // monotonic, the end of the last frame
  std::uint64_t fences_ = 0;
};

}  // namespace tactor::modbus
