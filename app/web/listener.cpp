#include "app/web/listener.hpp"

#include "framework/core/check.hpp"

namespace tactor {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

Listener::Listener(asio::io_context& io, const tcp::endpoint& at, const std::string& server, const std::string& option)
    : io_(io), acceptor_(io), timer_(io), server_(server) {
  error_code error;
  acceptor_.open(at.protocol(), error);
  if (!error) acceptor_.set_option(asio::socket_base::reuse_address(true), error);
  if (!error) acceptor_.bind(at, error);
  if (!error) acceptor_.listen(asio::socket_base::max_listen_connections, error);
  if (error) {
    throw InputError(server + " cannot listen on port " + std::to_string(at.port()) + " of " +
                     at.address().to_string() + ": " + error.message() + "; choose another with " + option);
  }
}

void Listener::start(std::function<void(Socket)> taken, std::function<void(const std::string&)> note) {
  taken_ = std::move(taken);
  note_ = std::move(note);
  accept();
}

void Listener::close() {
  error_code ignored;
  acceptor_.close(ignored);
  timer_.cancel();
}

void Listener::accept() {
  acceptor_.async_accept(io_, [this](error_code error, tcp::socket socket) {
    if (!acceptor_.is_open()) return;
    // A client that has gone again is no reason to wait.
    if (!error || error == asio::error::connection_aborted) {
      if (!error) taken_(std::move(socket));
      return accept();
    }
    if (refused_++ == 0) {
      note_(server_ + " cannot take a connection: " + error.message() + "; it tries again until it can");
    }
    timer_.expires_after(accept_again);
    timer_.async_wait([this](error_code cancelled) {
      if (!cancelled && acceptor_.is_open()) accept();
    });
  });
}

}  // namespace tactor
