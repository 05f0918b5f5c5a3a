// All that Boost.Beast does for Foxglove viewers is here: it takes long to compile.
#include "app/view/server/foxglove_server.hpp"

// Asio of Boost 1.74 lacks it under C++20.
#include <utility>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <cstring>
#include <deque>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "app/view/foxglove/foxglove_messages.hpp"
#include "app/view/samples.hpp"
#include "app/view/server/foxglove_text.hpp"
#include "app/view/server/request_rules.hpp"
#include "framework/core/check.hpp"

namespace tactor {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using boost::system::error_code;
using nlohmann::json;

constexpr std::size_t request_limit = 64 * 1024;  // bytes, from a viewer
constexpr std::uint32_t handshake_limit = 8 * 1024;
constexpr std::chrono::seconds handshake_timeout{10};
constexpr std::size_t most_viewers = 8;
constexpr std::size_t most_handshakes = 32;  // and viewers
constexpr std::size_t most_subscriptions = 256;
/// What waits for a viewer that does not read; then samples are left out.
constexpr std::size_t most_waiting = std::size_t{1} << 20U;
/// With the scene, which is sent whatever waits. Beyond it a viewer has gone wrong.
constexpr std::size_t most_waiting_in_all = std::size_t{1} << 30U;
/// What the system holds for a viewer; left alone it grows to some megabytes.
constexpr int send_buffer = 256 * 1024;
constexpr std::array<std::string_view, 2> protocols{"foxglove.sdk.v1", "foxglove.websocket.v1"};

enum BinaryOperation : char { message_data = 1, time_data = 2 };
enum StatusLevel : int { level_info = 0, level_warning = 1 };

template <class T>
void put_bytes(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string status_text(StatusLevel level, const std::string& message) {
  return json({{"op", "status"}, {"level", static_cast<int>(level)}, {"message", message}})
      .dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string data_of(std::uint32_t subscription, const FoxgloveMessage& message) {
  std::string bytes(1, message_data);
  put_bytes(bytes, subscription);
  put_bytes(bytes, static_cast<std::uint64_t>(std::max<std::int64_t>(message.time_ns, 0)));
  return bytes + message.json;
}

struct Waiting {
  std::string bytes;
  bool binary = false;
};

class FoxgloveHub;

/// A connection, from its handshake on.
class Viewer : public std::enable_shared_from_this<Viewer> {
 public:
  Viewer(FoxgloveHub& hub, tcp::socket socket) : hub_(hub), stream_(std::move(socket)) {}
  void accept();
  void send(std::string text);
  void send(const FoxgloveMessage& message);
  void send_time(std::int64_t time_ns);
  void tell_parameter(const std::string& name, const std::string& value);
  [[nodiscard]] bool wants(std::size_t channel) const;
  [[nodiscard]] bool is_open() const { return open_; }
  [[nodiscard]] bool has_place() const { return has_place_; }
  [[nodiscard]] bool is_sending() const { return open_ && writing_; }
  void end();

 private:
  void upgrade();
  void read();
  void take(std::string_view text);
  void subscribe(const FoxgloveRequest& request);
  void give_parameters(const FoxgloveRequest& request);
  void push(std::string bytes, bool binary);
  void pump();

  FoxgloveHub& hub_;
  websocket::stream<beast::tcp_stream> stream_;
  beast::flat_buffer buffer_;
  http::request_parser<http::empty_body> parser_;
  std::map<std::uint32_t, std::size_t> channels_;  // by subscription
  std::set<std::string> followed_;                 // parameters
  bool follows_all_ = false;
  std::deque<Waiting> waiting_;
  std::size_t waiting_bytes_ = 0;
  Waiting current_;
  std::uint64_t left_out_ = 0;
  bool writing_ = false;
  bool has_place_ = false;  // one of those that may be open at once
  bool open_ = false;
  bool ended_ = false;
};

class FoxgloveHub final : public FoxgloveServer {
 public:
  FoxgloveHub(asio::io_context& io, ViewSource& source, std::uint16_t port)
      : io_(io), acceptor_(io), translator_(source.hello(), source.first_messages()) {
    const tcp::endpoint at(asio::ip::address_v4::loopback(), port);
    error_code error;
    acceptor_.open(at.protocol(), error);
    if (!error) acceptor_.set_option(asio::socket_base::reuse_address(true), error);
    if (!error) acceptor_.bind(at, error);
    if (!error) acceptor_.listen(asio::socket_base::max_listen_connections, error);
    if (error) {
      throw InputError("the server for Foxglove cannot listen on port " + std::to_string(port) +
                       " of 127.0.0.1: " + error.message() + "; choose another with --foxglove=PORT");
    }
    values_ = translator_.parameters();
    url_ = "ws://127.0.0.1:" + std::to_string(acceptor_.local_endpoint().port());
  }

  [[nodiscard]] std::string url() const override { return url_; }

  void start() override {
    acceptor_.async_accept(io_, [this](error_code error, tcp::socket socket) {
      if (!acceptor_.is_open()) return;
      if (!error && connections_.size() < most_handshakes) {
        socket.set_option(tcp::no_delay(true), error);
        socket.set_option(asio::socket_base::send_buffer_size(send_buffer), error);
        const auto viewer = std::make_shared<Viewer>(*this, std::move(socket));
        connections_.insert(viewer);
        viewer->accept();
      }
      start();
    });
  }

  void add(std::string_view chunk) override {
    if (connections_.empty()) return;
    std::vector<bool> wanted(translator_.channels().size());
    for (std::size_t channel = 0; channel < wanted.size(); ++channel) {
      for (const auto& viewer : connections_) wanted[channel] = wanted[channel] || viewer->wants(channel);
    }
    messages_.clear();
    translator_.add(chunk, wanted, messages_);
    std::stable_sort(messages_.begin(), messages_.end(),
                     [](const FoxgloveMessage& a, const FoxgloveMessage& b) { return a.time_ns < b.time_ns; });
    const auto end = static_cast<std::int64_t>(std::max(chunk_end(chunk), 0.0) * 1e9);
    // One may go while it is told.
    const auto viewers = connections_;
    for (const FoxgloveMessage& message : messages_) {
      // Viewers plot a message at the time that they were told last; a prediction is of a time to come.
      tell_time(std::min(message.time_ns, end));
      for (const auto& viewer : viewers) viewer->send(message);
    }
    tell_time(end);
  }

  void tell(const std::string& text) override {
    const json told = json::parse(text, nullptr, false);
    if (!told.is_object()) return;
    const auto viewers = connections_;
    if (told["type"] == "set") {
      const std::string name = told["parameter"], value = told["value"].dump();
      values_[name] = value;
      for (const auto& viewer : viewers) viewer->tell_parameter(name, value);
    } else if (told["type"] == "ended") {
      for (const auto& viewer : viewers) {
        if (viewer->is_open())
          viewer->send(status_text(level_info, "the run has ended: " + told["why"].get<std::string>()));
      }
    }
  }

  void close() override { acceptor_.close(); }

  [[nodiscard]] bool is_sending() const override {
    return std::any_of(connections_.begin(), connections_.end(), [](const auto& v) { return v->is_sending(); });
  }

  void stop() override {
    const auto viewers = connections_;
    for (const auto& viewer : viewers) viewer->end();
  }

  [[nodiscard]] bool has_viewers() const override { return !connections_.empty(); }

  // For viewers.

  [[nodiscard]] bool has_room() const {
    return std::count_if(connections_.begin(), connections_.end(), [](const auto& v) { return v->has_place(); }) <
           static_cast<std::ptrdiff_t>(most_viewers);
  }
  [[nodiscard]] const FoxgloveMessages& translator() const { return translator_; }
  /// Of parameters: JSON, by name.
  [[nodiscard]] const std::map<std::string, std::string>& values() const { return values_; }
  void forget(const std::shared_ptr<Viewer>& viewer) { connections_.erase(viewer); }

 private:
  void tell_time(std::int64_t time_ns) {
    // A step back would be taken for a jump.
    if (time_ns <= told_ns_) return;
    told_ns_ = time_ns;
    const auto viewers = connections_;
    for (const auto& viewer : viewers) viewer->send_time(time_ns);
  }

  std::int64_t told_ns_ = 0;
  asio::io_context& io_;
  tcp::acceptor acceptor_;
  std::string url_;
  std::set<std::shared_ptr<Viewer>> connections_;
  FoxgloveMessages translator_;
  std::map<std::string, std::string> values_;
  std::vector<FoxgloveMessage> messages_;
};

void Viewer::accept() {
  parser_.header_limit(handshake_limit);
  beast::get_lowest_layer(stream_).expires_after(handshake_timeout);
  http::async_read(stream_.next_layer(), buffer_, parser_, [self = shared_from_this()](error_code error, std::size_t) {
    if (error || !websocket::is_upgrade(self->parser_.get()) || !self->hub_.has_room()) return self->end();
    self->has_place_ = true;
    self->upgrade();
  });
}

void Viewer::upgrade() {
  const auto field = parser_.get()[http::field::sec_websocket_protocol];
  const auto offered = offered_protocol({field.data(), field.size()}, protocols);
  if (!offered) return end();
  beast::get_lowest_layer(stream_).expires_never();
  websocket::stream_base::timeout timeout{};
  timeout.handshake_timeout = handshake_timeout;
  timeout.idle_timeout = websocket::stream_base::none();
  stream_.set_option(timeout);
  stream_.set_option(
      websocket::stream_base::decorator([chosen = std::string(*offered)](websocket::response_type& response) {
        response.set(http::field::server, "tactor");
        response.set(http::field::sec_websocket_protocol, chosen);
      }));
  stream_.read_message_max(request_limit);
  stream_.auto_fragment(false);
  stream_.async_accept(parser_.get(), [self = shared_from_this()](error_code error) {
    if (error) return self->end();
    self->buffer_.clear();
    self->open_ = true;
    const FoxgloveMessages& translator = self->hub_.translator();
    self->send(json({{"op", "serverInfo"},
                     {"name", "tactor " + translator.about().at("graph")},
                     {"capabilities", {"time", "parameters", "parametersSubscribe"}},
                     {"supportedEncodings", json::array()},
                     {"metadata", translator.about()}})
                   .dump(-1, ' ', false, json::error_handler_t::replace));
    json channels = json::array();
    for (std::size_t i = 0; i < translator.channels().size(); ++i) {
      const FoxgloveChannel& channel = translator.channels()[i];
      channels.push_back({{"id", i},
                          {"topic", channel.topic},
                          {"encoding", "json"},
                          {"schemaName", channel.schema_name},
                          {"schema", channel.schema},
                          {"schemaEncoding", "jsonschema"}});
    }
    self->send(json({{"op", "advertise"}, {"channels", std::move(channels)}})
                   .dump(-1, ' ', false, json::error_handler_t::replace));
    self->read();
  });
}

bool Viewer::wants(std::size_t channel) const {
  return std::any_of(channels_.begin(), channels_.end(), [channel](const auto& s) { return s.second == channel; });
}

void Viewer::read() {
  stream_.async_read(buffer_, [self = shared_from_this()](error_code error, std::size_t) {
    if (error) return self->end();
    // Bytes are messages and service calls, which nobody offered.
    if (self->stream_.got_text()) {
      const auto data = self->buffer_.data();
      self->take({static_cast<const char*>(data.data()), data.size()});
    }
    self->buffer_.consume(self->buffer_.size());
    if (self->open_) self->read();
  });
}

void Viewer::take(std::string_view text) {
  const std::optional<FoxgloveRequest> request = read_foxglove_text(text);
  if (!request) return send(status_text(level_warning, "this is not a request of the Foxglove WebSocket protocol"));
  switch (request->kind) {
    case FoxgloveRequest::Kind::subscribe:
      return subscribe(*request);
    case FoxgloveRequest::Kind::unsubscribe:
      for (const std::uint32_t id : request->ids) channels_.erase(id);
      return;
    case FoxgloveRequest::Kind::get_parameters:
      return give_parameters(*request);
    case FoxgloveRequest::Kind::set_parameters:
      // The answer holds what goes on to be true.
      send(status_text(level_warning, "this server is read-only: parameters are changed in the page of `tactor view`"));
      return give_parameters(*request);
    case FoxgloveRequest::Kind::follow_parameters:
      follows_all_ = follows_all_ || request->names.empty();
      for (const std::string& name : request->names) {
        if (hub_.values().count(name) > 0) followed_.insert(name);
      }
      return;
    case FoxgloveRequest::Kind::unfollow_parameters:
      if (request->names.empty()) follows_all_ = false, followed_.clear();
      for (const std::string& name : request->names) followed_.erase(name);
      return;
    case FoxgloveRequest::Kind::other:
      return;
  }
}

void Viewer::subscribe(const FoxgloveRequest& request) {
  const FoxgloveMessages& translator = hub_.translator();
  for (const auto& [id, channel] : request.subscriptions) {
    if (channel >= translator.channels().size()) {
      send(status_text(level_warning, "there is no channel " + std::to_string(channel)));
      continue;
    }
    if (channels_.size() >= most_subscriptions && channels_.count(id) == 0) {
      send(status_text(level_warning, "there are 256 subscriptions already"));
      continue;
    }
    channels_[id] = channel;
    for (const FoxgloveMessage& message : translator.first()) {
      if (message.channel == channel) push(data_of(id, message), true);
    }
  }
}

void Viewer::give_parameters(const FoxgloveRequest& request) {
  json list = json::array();
  for (const auto& [name, value] : hub_.values()) {
    const bool asked =
        request.names.empty() || std::find(request.names.begin(), request.names.end(), name) != request.names.end();
    if (asked) list.push_back({{"name", name}, {"value", json::parse(value)}});
  }
  json answer = {{"op", "parameterValues"}, {"parameters", std::move(list)}};
  if (!request.id.empty()) answer["id"] = request.id;
  send(answer.dump(-1, ' ', false, json::error_handler_t::replace));
}

void Viewer::tell_parameter(const std::string& name, const std::string& value) {
  if (!open_ || (!follows_all_ && followed_.count(name) == 0)) return;
  send(json({{"op", "parameterValues"}, {"parameters", {{{"name", name}, {"value", json::parse(value)}}}}}).dump());
}

void Viewer::send(std::string text) {
  push(std::move(text), false);
}

void Viewer::send(const FoxgloveMessage& message) {
  for (const auto& [id, channel] : channels_) {
    if (channel != message.channel) continue;
    if (waiting_bytes_ > most_waiting) {
      ++left_out_;
      continue;
    }
    if (left_out_ > 0) {
      push(
          status_text(level_warning, std::to_string(left_out_) + " messages were left out: they were not read in time"),
          false);
      left_out_ = 0;
    }
    push(data_of(id, message), true);
  }
}

void Viewer::send_time(std::int64_t time_ns) {
  if (waiting_bytes_ > most_waiting) return;
  std::string bytes(1, time_data);
  put_bytes(bytes, static_cast<std::uint64_t>(time_ns));
  push(std::move(bytes), true);
}

void Viewer::push(std::string bytes, bool binary) {
  if (!open_) return;
  waiting_bytes_ += bytes.size();
  waiting_.push_back({std::move(bytes), binary});
  if (waiting_bytes_ > most_waiting_in_all) return end();
  pump();
}

void Viewer::pump() {
  if (!open_ || writing_ || waiting_.empty()) return;
  current_ = std::move(waiting_.front());
  waiting_.pop_front();
  writing_ = true;
  stream_.binary(current_.binary);
  stream_.async_write(asio::buffer(current_.bytes), [self = shared_from_this()](error_code error, std::size_t) {
    self->writing_ = false;
    self->waiting_bytes_ -= self->current_.bytes.size();
    if (error) return self->end();
    self->pump();
  });
}

void Viewer::end() {
  if (ended_) return;
  ended_ = true;
  open_ = false;
  beast::get_lowest_layer(stream_).close();
  hub_.forget(shared_from_this());
}

}  // namespace

std::unique_ptr<FoxgloveServer> make_foxglove_server(asio::io_context& io, ViewSource& source, std::uint16_t port) {
  return std::make_unique<FoxgloveHub>(io, source, port);
}

}  // namespace tactor
