// All that Boost.Beast does for the bridge is here: it takes long to compile.
#include "app/bridge/bridge_server.hpp"

// Asio of Boost 1.74 lacks it under C++20.
#include <utility>

#include <algorithm>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <deque>
#include <list>

#include "app/web/listener.hpp"
#include "app/web/request_rules.hpp"
#include "app/web/upgrade.hpp"
#include "framework/core/check.hpp"

namespace tactor {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using boost::system::error_code;

namespace {

constexpr std::string_view bridge_subprotocol = "tactor.bridge";
constexpr std::uint32_t longest_header = 8 * 1024;  // bytes
constexpr std::chrono::seconds patience_with_strangers{5};
constexpr std::size_t most_strangers = 16;
constexpr std::size_t piece = 64 * 1024;  // bytes that are read at once
constexpr Duration farewell_time{200'000'000};

std::chrono::nanoseconds of_chrono(Duration duration) {
  return std::chrono::nanoseconds(duration.ns);
}

bool is_token(const std::string& text) {
  return text.size() >= 16 && text.size() <= 128 && std::all_of(text.begin(), text.end(), [](unsigned char c) {
           return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
         });
}

tcp::endpoint endpoint_of(const BridgeAddress& address) {
  error_code error;
  const auto at = asio::ip::make_address_v4(address.listen, error);
  if (error) throw InputError("--listen: expected an IPv4 address such as 127.0.0.1, found " + address.listen);
  return {at, address.port};
}

}  // namespace

/// A connection, from its handshake on.
class BridgePeer : public std::enable_shared_from_this<BridgePeer> {
 public:
  BridgePeer(BridgeHub& hub, tcp::socket socket) : hub_(hub), stream_(std::move(socket)) {}
  void accept();
  void send(BridgeFrame frame);
  [[nodiscard]] std::optional<BridgeArrival> take();
  void close(const std::string& why);
  void end();
  [[nodiscard]] bool is_open() const { return open_; }

 private:
  void answer();
  void refuse(http::status status, const std::string& why);
  void upgrade();
  void read();
  void write();

  BridgeHub& hub_;
  websocket::stream<beast::tcp_stream> stream_;
  beast::flat_buffer buffer_;
  http::request_parser<http::empty_body> parser_;
  TextResponse refusal_;
  std::deque<BridgeFrame> waiting_;  // the first one is being written
  std::optional<BridgeArrival> arrival_;
  bool too_large_ = false;
  bool reading_ = false;
  bool open_ = false;
  bool ended_ = false;
};

class BridgeHub {
 public:
  BridgeHub(const BridgeAddress& address, std::function<void(const std::string&)> note)
      : at_(endpoint_of(address)),
        token_(address.token.empty() ? make_token() : address.token),
        listener_(io_, at_, "the bridge", "--port") {
    if (!is_token(token_)) throw InputError("--token: expected 16 to 128 letters, digits, - and _");
    listener_.start([this](tcp::socket socket) { take_in(std::move(socket)); }, std::move(note));
  }

  [[nodiscard]] std::string url() const {
    return "ws://" + at_.address().to_string() + ":" + std::to_string(listener_.port()) + "/bridge#" + token_;
  }
  void serve(Duration longest) {
    // With no time at all, run_one_for does nothing.
    if (longest > Duration{}) {
      io_.run_one_for(of_chrono(longest));
    } else {
      io_.poll_one();
    }
  }
  [[nodiscard]] BridgeClient client() const { return client_ && client_->is_open() ? last_client_ : 0; }
  void send(BridgeFrame frame, bool asks) {
    if (client() == 0) return;
    if (asks && !owes_since_) owes_since_ = MonotonicClock::now();
    client_->send(std::move(frame));
  }
  [[nodiscard]] std::optional<BridgeArrival> take() { return client_ ? client_->take() : std::nullopt; }
  void close(const std::string& why) {
    listener_.close();
    if (!client_) return;
    client_->close(why);
    const Instant until = MonotonicClock::now() + farewell_time;
    while (client_ && MonotonicClock::now() < until) serve(until - MonotonicClock::now());
  }

  // For connections.

  [[nodiscard]] bool knows(std::string_view host) const {
    return is_own_host(host) || (!at_.address().is_loopback() && is_numeric_host(host));
  }
  [[nodiscard]] bool lets_in(std::string_view token) const { return same_secret(token, token_); }
  /// Gives the place of the client to this connection, where it is free or its owner has been silent for too long.
  [[nodiscard]] bool give_place(const std::shared_ptr<BridgePeer>& peer) {
    if (client_ && !(owes_since_ && MonotonicClock::now() - *owes_since_ > BridgeServer::longest_silence)) return false;
    if (const auto silent = client_) silent->end();
    client_ = peer;
    ++last_client_;
    owes_since_.reset();
    strangers_.remove(peer);
    return true;
  }
  void heard() {
    if (owes_since_) owes_since_ = MonotonicClock::now();
  }
  void settle() { owes_since_.reset(); }
  void forget(const std::shared_ptr<BridgePeer>& peer) {
    strangers_.remove(peer);
    if (client_ == peer) client_.reset();
  }

 private:
  void take_in(tcp::socket socket) {
    // The oldest silent connection makes room for a new one.
    if (strangers_.size() >= most_strangers) {
      const auto oldest = strangers_.front();
      oldest->end();
    }
    error_code ignored;
    socket.set_option(tcp::no_delay(true), ignored);
    strangers_.push_back(std::make_shared<BridgePeer>(*this, std::move(socket)));
    strangers_.back()->accept();
  }

  tcp::endpoint at_;
  std::string token_;
  asio::io_context io_{1};
  Listener listener_;
  std::list<std::shared_ptr<BridgePeer>> strangers_;  // before they are a client, as they came
  std::shared_ptr<BridgePeer> client_;                // null: the place is free
  BridgeClient last_client_ = 0;
  std::optional<Instant> owes_since_;
};

void BridgePeer::accept() {
  parser_.header_limit(longest_header);
  beast::get_lowest_layer(stream_).expires_after(patience_with_strangers);
  http::async_read(stream_.next_layer(), buffer_, parser_, [self = shared_from_this()](error_code error, std::size_t) {
    if (error) return self->end();
    self->answer();
  });
}

void BridgePeer::answer() {
  const UpgradeRequest& request = parser_.get();
  const std::string_view host = field_of(request, http::field::host);
  if (request.count(http::field::host) != 1 || !hub_.knows(host)) {
    return refuse(http::status::misdirected_request, "this server answers only to its own address");
  }
  // Some programs send their server's address as the origin. No page has that one, because the bridge gives none.
  const std::string_view origin = field_of(request, http::field::origin);
  if (request.count(http::field::origin) > 1 || !(origin.empty() || is_same_origin(origin, host))) {
    return refuse(http::status::forbidden, "the bridge is for programs, not for pages of a browser");
  }
  const std::string_view target(request.target().data(), request.target().size());
  if (target != "/bridge") return refuse(http::status::not_found, "the bridge is at /bridge");
  if (!websocket::is_upgrade(request)) {
    return refuse(http::status::upgrade_required, "the bridge speaks WebSocket alone");
  }
  const auto token = offered_token(field_of(request, http::field::sec_websocket_protocol), bridge_subprotocol);
  if (!token || !hub_.lets_in(*token)) {
    return refuse(http::status::unauthorized,
                  "the token is missing or wrong: offer the subprotocols tactor.bridge and token.TOKEN");
  }
  if (!hub_.give_place(shared_from_this())) {
    return refuse(http::status::service_unavailable, "another client is connected");
  }
  upgrade();
}

void BridgePeer::refuse(http::status status, const std::string& why) {
  refusal_ = refusal_of(status, why);
  http::async_write(stream_.next_layer(), refusal_,
                    [self = shared_from_this()](error_code, std::size_t) { self->end(); });
}

void BridgePeer::upgrade() {
  beast::get_lowest_layer(stream_).expires_never();
  set_up(stream_, bridge_subprotocol, patience_with_strangers);
  // Longer frames are read to their end and left out, so that the client can be told.
  stream_.read_message_max(0);
  stream_.async_accept(parser_.get(), [self = shared_from_this()](error_code error) {
    if (error) return self->end();
    self->buffer_.clear();
    self->open_ = true;
    self->read();
  });
}

void BridgePeer::read() {
  reading_ = true;
  stream_.async_read_some(buffer_, piece, [self = shared_from_this()](error_code error, std::size_t) {
    if (error) return self->end();
    if (self->too_large_ || self->buffer_.size() > BridgeServer::frame_limit) {
      self->too_large_ = true;
      self->buffer_.consume(self->buffer_.size());
    }
    if (!self->stream_.is_message_done()) return self->read();
    self->reading_ = false;
    self->hub_.heard();
    const auto data = self->buffer_.data();
    self->arrival_ = {{{static_cast<const char*>(data.data()), data.size()}, self->stream_.got_binary()},
                      std::exchange(self->too_large_, false),
                      MonotonicClock::now()};
    self->buffer_.consume(self->buffer_.size());
  });
}

std::optional<BridgeArrival> BridgePeer::take() {
  std::optional<BridgeArrival> taken = std::exchange(arrival_, std::nullopt);
  if (taken && waiting_.empty() && open_) read();
  return taken;
}

void BridgePeer::send(BridgeFrame frame) {
  waiting_.push_back(std::move(frame));
  if (waiting_.size() == 1) write();
}

void BridgePeer::write() {
  stream_.binary(waiting_.front().packed);
  stream_.async_write(asio::buffer(waiting_.front().bytes), [self = shared_from_this()](error_code error, std::size_t) {
    if (error || self->ended_) return self->end();
    self->waiting_.pop_front();
    if (!self->waiting_.empty()) return self->write();
    // A client that takes no answer is not read from.
    if (!self->reading_ && !self->arrival_) self->read();
  });
}

void BridgePeer::close(const std::string& why) {
  if (!open_) return end();
  open_ = false;
  // At most 123 bytes, by the standard.
  stream_.async_close({websocket::close_code::going_away, why.substr(0, 120)},
                      [self = shared_from_this()](error_code) { self->end(); });
}

void BridgePeer::end() {
  if (ended_) return;
  ended_ = true;
  open_ = false;
  beast::get_lowest_layer(stream_).close();
  hub_.forget(shared_from_this());
}

BridgeServer::BridgeServer(const BridgeAddress& address, std::function<void(const std::string&)> note)
    : hub_(std::make_unique<BridgeHub>(address, std::move(note))) {}

BridgeServer::~BridgeServer() = default;

std::string BridgeServer::url() const {
  return hub_->url();
}

void BridgeServer::serve(Duration longest) {
  hub_->serve(longest);
}

BridgeClient BridgeServer::client() const {
  return hub_->client();
}

void BridgeServer::send(BridgeFrame frame, bool asks) {
  hub_->send(std::move(frame), asks);
}

void BridgeServer::settle() {
  hub_->settle();
}

std::optional<BridgeArrival> BridgeServer::take() {
  return hub_->take();
}

void BridgeServer::close(const std::string& why) {
  hub_->close(why);
}

}  // namespace tactor
