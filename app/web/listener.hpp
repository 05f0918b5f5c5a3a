// Takes connections on a port, for the servers of the command.
#pragma once

// Asio of Boost 1.74 lacks it under C++20.
#include <utility>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>

namespace tactor {

class Listener {
 public:
  using Socket = boost::asio::ip::tcp::socket;
  /// After a connection that the system refused. Whoever waits goes on waiting, which must not keep the thread busy.
  static constexpr std::chrono::milliseconds accept_again{100};

  /// Listens at `at`; `io` outlives the listener. Throws InputError, which begins with `server` and names `option`,
  /// where the port is taken or refused.
  Listener(boost::asio::io_context& io, const boost::asio::ip::tcp::endpoint& at, const std::string& server,
           const std::string& option);
  /// The same on this machine alone, at 127.0.0.1.
  Listener(boost::asio::io_context& io, std::uint16_t port, const std::string& server, const std::string& option)
      : Listener(io, {boost::asio::ip::address_v4::loopback(), port}, server, option) {}

  [[nodiscard]] std::uint16_t port() const { return acceptor_.local_endpoint().port(); }
  /// Begins to take connections, each by `taken`, on the thread of `io`. The first that the system refuses, for want of
  /// descriptors for one, is told by `note`.
  void start(std::function<void(Socket)> taken, std::function<void(const std::string&)> note);
  /// Takes no more. On the thread of `io`.
  void close();
  /// How often the system has refused a connection.
  [[nodiscard]] std::uint64_t refused() const { return refused_; }

 private:
  void accept();

  boost::asio::io_context& io_;
  boost::asio::ip::tcp::acceptor acceptor_;
  boost::asio::steady_timer timer_;
  std::string server_;
  std::function<void(Socket)> taken_;
  std::function<void(const std::string&)> note_;
  std::uint64_t refused_ = 0;
};

}  // namespace tactor
