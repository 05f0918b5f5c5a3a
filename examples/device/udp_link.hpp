// The line to the machine: a datagram with forces, and one with positions as the answer.
#pragma once

#include "devices/hardware/link.hpp"
#include "protocol.hpp"

namespace example_nodes {

/// Every call returns within 20 ms, the time that an answer may take.
class UdpLink final : public tactor::Link {
 public:
  explicit UdpLink(int port) : port_(port) {}
  ~UdpLink() override { close(); }

  [[nodiscard]] std::string name() const override;
  bool open(tactor::LinkFailure& failure) override;
  bool exchange(const tactor::LinkCommand& command, tactor::LinkSample& sample, tactor::LinkFailure& failure) override;
  void close() override;

 private:
  int port_;
  int socket_ = -1;
  std::uint32_t number_ = 0;
};

}  // namespace example_nodes
