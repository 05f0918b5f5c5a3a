// The line to a Modbus actuator: identifies it, starts it up, and gives it a command and reads it each cycle.
#pragma once

#include <string>
#include <vector>

#include "devices/hardware/claim.hpp"
#include "devices/hardware/link.hpp"
#include "devices/modbus/client.hpp"
#include "devices/modbus/cycle_plan.hpp"
#include "devices/modbus/profile.hpp"

namespace tactor::modbus {

/// A profile at an endpoint, which this link has alone among the programs of this machine from its first opening to its
/// end: a serial port, or a host's address and port whatever name it goes by. Over TCP other links of this process may
/// have other units of the same address.
///
/// Nothing is written before every expectation of `identify` has been read and found true. Starting up sets the
/// watchdog, commands zero, goes through the start_up steps and reads every status register anew; closing commands zero
/// and goes through shut_down, each once more where it failed and the connection still stands, and shut_down also where
/// zero was refused.
///
/// A cycle takes as long as its transactions, at most two response timeouts each (until the line takes the request, and
/// until it is answered) plus, after a failure, those of the client's fence and the wait before it (see Client).
class ModbusLink final : public Link {
 public:
  /// Throws InputError as plan_cycle does.
  ModbusLink(Profile profile, Endpoint endpoint);
  ~ModbusLink() override;

  [[nodiscard]] std::string name() const override { return name_; }
  bool open(LinkFailure& failure) override;
  bool exchange(const LinkCommand& command, LinkSample& sample, LinkFailure& failure) override;
  void close() override;

  /// Goes through the calibrate steps; the line must be open.
  bool calibrate(LinkFailure& failure) { return walk(profile_.calibrate, failure); }
  [[nodiscard]] const Client& client() const { return client_; }
  [[nodiscard]] const CyclePlan& plan() const { return plan_; }

 private:
  bool claim(LinkFailure& failure);
  bool identify(LinkFailure& failure);
  bool walk(const std::vector<Step>& steps, LinkFailure& failure);
  bool write(std::size_t index, double value, LinkFailure& failure);
  bool read(std::size_t index, double& value, LinkFailure& failure);
  bool command_zero(LinkFailure& failure);
  bool read_status(LinkFailure& failure);
  void let_go();
  void put(std::size_t index, double value);
  void put_command(const LinkCommand& command);
  [[nodiscard]] double get(std::size_t index) const;
  bool run(const Transaction& transaction, LinkFailure& failure);
  std::uint32_t faults(std::string& text) const;

  Profile profile_;
  std::string name_;
  CyclePlan plan_;
  std::vector<std::string> claimed_;  // names
  std::vector<Claim> claims_;
  Client client_;
  std::vector<std::uint16_t> written_, read3_, read4_;  // the registers as they go over the line, by address
  std::uint64_t cycles_ = 0;
  bool started_ = false;
};

}  // namespace tactor::modbus
