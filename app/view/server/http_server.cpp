// All of Boost.Beast is here: it takes long to compile.
#include "app/view/server/http_server.hpp"

// Asio of Boost 1.74 lacks it under C++20.
#include <utility>

#include <algorithm>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <deque>
#include <list>
#include <map>

#include "app/view/server/client_text.hpp"
#include "app/view/server/foxglove_server.hpp"
#include "app/view/server/frame_queue.hpp"
#include "app/web/listener.hpp"
#include "app/web/request_rules.hpp"
#include "app/web/upgrade.hpp"
#include "framework/core/check.hpp"

namespace tactor {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using boost::system::error_code;
using std::chrono::milliseconds;
using std::chrono::seconds;
using SteadyTime = std::chrono::steady_clock::time_point;

constexpr std::string_view protocol = "tactor.view";
constexpr std::uint32_t header_limit = 8 * 1024;  // bytes, of a request
constexpr std::size_t message_limit = 4 * 1024;   // bytes, from a page
constexpr seconds request_timeout{10};
constexpr seconds write_timeout{20};
constexpr std::size_t most_pages = 8;
constexpr std::size_t most_connections = 64;
constexpr std::size_t most_waiting_text = std::size_t{4} << 20U;  // bytes
constexpr milliseconds frame_period{25};
constexpr milliseconds idle_period{100};  // while no page is there
constexpr milliseconds status_period{250};
constexpr milliseconds farewell{1000};

struct Outgoing {
  std::string bytes;
  bool binary = false;
};

/// The object with more members behind those it has.
std::string with_members(std::string object, const std::string& members) {
  object.back() = ',';
  return object + members + "}";
}

class Server;

/// A page: a WebSocket that was let in.
class Page : public std::enable_shared_from_this<Page> {
 public:
  Page(Server& server, ClientId id, tcp::socket socket);
  void accept(const http::request<http::empty_body>& request);
  void send(std::string text);
  void add(const std::shared_ptr<const std::string>& chunk) {
    if (open_) frames_.add(chunk);
  }
  /// Writes what waits, where nothing is being written.
  void pump();
  /// Ends the connection where a write does not come to its end.
  void check(SteadyTime now);
  void end();
  [[nodiscard]] ClientId id() const { return id_; }
  [[nodiscard]] bool is_open() const { return open_; }
  [[nodiscard]] bool is_idle() const { return !writing_ && texts_.empty(); }
  [[nodiscard]] std::uint64_t dropped() const { return frames_.dropped(); }

 private:
  void read();
  void take(std::string_view text);
  void refuse();
  void replay(const std::vector<std::string>& frames);
  void write(Outgoing message);

  Server& server_;
  ClientId id_;
  websocket::stream<beast::tcp_stream> stream_;
  beast::flat_buffer buffer_{message_limit};
  std::deque<Outgoing> texts_;  // with the first binary messages
  std::size_t text_bytes_ = 0;
  FrameQueue frames_;
  std::size_t replayed_ = 0;
  bool replay_complete_ = false;
  Outgoing current_;
  bool open_ = false;
  bool writing_ = false;
  bool closing_ = false;
  SteadyTime write_began_;
};

/// A connection before it is a page.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(Server& server, tcp::socket socket);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  void read();
  void end();

 private:
  void answer(const http::request<http::empty_body>& request);
  void open_page(const http::request<http::empty_body>& request);
  void give(const http::request<http::empty_body>& request, const ViewFile& file);
  void refuse(http::status status, const std::string& why);
  void respond(http::response<http::string_body> response);

  void move_to_back();

  Server& server_;
  std::list<Connection*>::iterator place_;
  bool ended_ = false;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_{header_limit};
  std::optional<http::request_parser<http::empty_body>> parser_;
  std::optional<http::response<http::string_body>> response_;
};

class Server final : public ViewServer {
 public:
  Server(ViewSource& shown, const ViewPorts& ports) : source(shown), listener_(io_, ports.page, "the view", "--port") {
    url_ = "http://127.0.0.1:" + std::to_string(listener_.port()) + "/#" + token;
    if (ports.foxglove) foxglove_ = make_foxglove_server(source, *ports.foxglove, ports.allowed_origins);
  }

  [[nodiscard]] std::string url() const override { return url_; }
  [[nodiscard]] std::string foxglove_url() const override { return foxglove_ ? foxglove_->url() : std::string(); }

  void run() override {
    listener_.start([this](tcp::socket socket) { take_in(std::move(socket)); },
                    [this](const std::string& note) { source.note(note); });
    if (foxglove_) foxglove_->start();
    tick();
    io_.run();
  }

  void post(std::string text, std::optional<ClientId> client) override {
    asio::post(io_, [this, text = std::move(text), client] {
      // A page that is told too much goes.
      const std::map<ClientId, std::shared_ptr<Page>> pages = pages_;
      for (const auto& [id, page] : pages) {
        if (!client || *client == id) page->send(text);
      }
      if (foxglove_ && !client) foxglove_->tell(text);
    });
  }

  void stop() override {
    asio::post(io_, [this] {
      listener_.close();
      if (foxglove_) foxglove_->close();
      stop_by_ = std::chrono::steady_clock::now() + farewell;
    });
  }

  [[nodiscard]] std::uint32_t clients() const override { return count_; }

  // For connections and pages, on the server's thread.

  [[nodiscard]] bool has_room() const { return pages_.size() < most_pages; }

  void add_page(tcp::socket socket, const http::request<http::empty_body>& request) {
    const auto page = std::make_shared<Page>(*this, ++last_client_, std::move(socket));
    pages_[page->id()] = page;
    page->accept(request);
  }

  void opened(ClientId id) {
    if (in_control_ == 0) in_control_ = id;
    ++count_;
  }

  void closed(ClientId id, bool was_open) {
    if (pages_.erase(id) == 0) return;
    if (was_open) --count_;
    if (in_control_ != id) return;
    in_control_ = 0;
    source.release();
  }

  /// What a page asks for, but `ack`.
  void take(ClientId id, const ClientMessage& message) {
    if (message.kind == ClientMessage::Kind::control) {
      if (in_control_ == 0) in_control_ = id;
    } else if (in_control_ == id || message.kind == ClientMessage::Kind::stop) {
      source.receive(id, message);
    }
  }

  ViewSource& source;
  const std::string token = make_token();
  /// Those that are no page, by the time at which they last began to wait for something.
  std::list<Connection*> connections;

 private:
  void take_in(tcp::socket socket) {
    // Whoever says nothing, or takes nothing, gives way to whoever may have something to say.
    if (connections.size() >= most_connections) connections.front()->end();
    error_code ignored;
    socket.set_option(tcp::no_delay(true), ignored);
    std::make_shared<Connection>(*this, std::move(socket))->read();
  }

  void tick() {
    const SteadyTime now = std::chrono::steady_clock::now();
    if (source.replay() == nullptr) {
      if (std::string chunk = source.collect(); !chunk.empty()) {
        const auto shared = std::make_shared<const std::string>(std::move(chunk));
        for (const auto& [id, page] : pages_) page->add(shared);
        if (foxglove_) foxglove_->add(shared);
      }
      if (now >= next_status_) {
        next_status_ = now + status_period;
        tell_status();
      }
    }
    bool idle = true;
    // A page may go while it is looked at.
    const std::map<ClientId, std::shared_ptr<Page>> pages = pages_;
    for (const auto& [id, page] : pages) {
      page->pump();
      page->check(now);
      idle = idle && page->is_idle();
    }
    idle = idle && !(foxglove_ && foxglove_->is_sending());
    if (stop_by_ && (idle || now > *stop_by_)) {
      for (const auto& [id, page] : pages) page->end();
      io_.stop();
      return;
    }
    const bool watched = !pages.empty() || (foxglove_ && foxglove_->has_viewers());
    timer_.expires_after(watched ? frame_period : idle_period);
    timer_.async_wait([this](error_code error) {
      if (!error) tick();
    });
  }

  void tell_status() {
    if (pages_.empty()) return;
    const std::string status = source.status();
    if (status.empty()) return;
    const std::map<ClientId, std::shared_ptr<Page>> pages = pages_;
    for (const auto& [id, page] : pages) {
      if (!page->is_open()) continue;
      page->send(with_members(status, "\"in_control\":" + std::to_string(in_control_) +
                                          ",\"clients\":" + std::to_string(count_.load()) +
                                          ",\"dropped\":" + std::to_string(page->dropped())));
    }
  }

  std::string url_;
  asio::io_context io_{1};
  Listener listener_;
  asio::steady_timer timer_{io_};
  std::unique_ptr<FoxgloveServer> foxglove_;  // null: none
  std::map<ClientId, std::shared_ptr<Page>> pages_;
  std::atomic<std::uint32_t> count_{0};  // pages that are open
  ClientId last_client_ = 0;
  ClientId in_control_ = 0;  // 0: nobody
  SteadyTime next_status_;
  std::optional<SteadyTime> stop_by_;
};

Page::Page(Server& server, ClientId id, tcp::socket socket) : server_(server), id_(id), stream_(std::move(socket)) {}

void Page::accept(const http::request<http::empty_body>& request) {
  set_up(stream_, protocol, request_timeout);
  stream_.read_message_max(message_limit);
  stream_.async_accept(request, [self = shared_from_this()](error_code error) {
    if (error) return self->end();
    self->open_ = true;
    self->server_.opened(self->id_);
    self->send(with_members(self->server_.source.hello(), "\"client\":" + std::to_string(self->id_)));
    for (const std::string& message : self->server_.source.first_messages()) {
      self->texts_.push_back({message, true});
    }
    self->pump();
    self->read();
  });
}

void Page::send(std::string text) {
  if (!open_ || closing_) return;
  text_bytes_ += text.size();
  texts_.push_back({std::move(text), false});
  // A page that takes nothing while much is told has gone wrong.
  if (text_bytes_ > most_waiting_text) return end();
  pump();
}

void Page::pump() {
  if (!open_ || writing_ || closing_) return;
  if (!texts_.empty()) {
    Outgoing next = std::move(texts_.front());
    texts_.pop_front();
    if (!next.binary) text_bytes_ -= next.bytes.size();
    return write(std::move(next));
  }
  if (const std::vector<std::string>* frames = server_.source.replay()) return replay(*frames);
  if (std::optional<std::string> frame = frames_.next()) write({std::move(*frame), true});
}

void Page::replay(const std::vector<std::string>& frames) {
  if (replayed_ < frames.size()) {
    if (frames_.take_number()) write({frames[replayed_++], true});
  } else if (!replay_complete_) {
    replay_complete_ = true;
    send(R"({"type":"complete"})");
  }
}

void Page::write(Outgoing message) {
  current_ = std::move(message);
  writing_ = true;
  write_began_ = std::chrono::steady_clock::now();
  stream_.binary(current_.binary);
  stream_.async_write(asio::buffer(current_.bytes), [self = shared_from_this()](error_code error, std::size_t) {
    self->writing_ = false;
    if (error) return self->end();
    self->pump();
  });
}

void Page::read() {
  stream_.async_read(buffer_, [self = shared_from_this()](error_code error, std::size_t) {
    if (error) return self->end();
    if (!self->stream_.got_text()) return self->refuse();
    const auto data = self->buffer_.data();
    self->take({static_cast<const char*>(data.data()), data.size()});
    self->buffer_.consume(self->buffer_.size());
    if (!self->closing_ && self->open_) self->read();
  });
}

void Page::take(std::string_view text) {
  const std::optional<ClientMessage> message = read_client_text(text);
  if (!message) return refuse();
  if (message->kind != ClientMessage::Kind::ack) return server_.take(id_, *message);
  if (!frames_.acknowledge(message->frame)) return refuse();
  pump();
}

void Page::refuse() {
  if (closing_) return;
  closing_ = true;
  stream_.async_close(websocket::close_code::policy_error, [self = shared_from_this()](error_code) { self->end(); });
}

void Page::check(SteadyTime now) {
  if (writing_ && now - write_began_ > write_timeout) end();
}

void Page::end() {
  const bool was_open = open_;
  open_ = false;
  beast::get_lowest_layer(stream_).close();
  server_.closed(id_, was_open);
}

Connection::Connection(Server& server, tcp::socket socket)
    : server_(server), place_(server.connections.insert(server.connections.end(), this)), stream_(std::move(socket)) {}

Connection::~Connection() {
  if (!ended_) server_.connections.erase(place_);
}

void Connection::move_to_back() {
  if (!ended_) server_.connections.splice(server_.connections.end(), server_.connections, place_);
}

void Connection::end() {
  if (ended_) return;
  ended_ = true;
  server_.connections.erase(place_);
  stream_.close();
}

void Connection::read() {
  move_to_back();
  parser_.emplace();
  parser_->header_limit(header_limit);
  stream_.expires_after(request_timeout);
  http::async_read(stream_, buffer_, *parser_, [self = shared_from_this()](error_code error, std::size_t) {
    if (error == http::error::header_limit || error == http::error::buffer_overflow) {
      return self->refuse(http::status::request_header_fields_too_large, "the header is longer than 8 KiB");
    }
    if (error == http::error::end_of_stream || error == beast::error::timeout ||
        error == asio::error::operation_aborted || error == asio::error::connection_reset ||
        error == http::error::partial_message) {
      return;
    }
    if (error) return self->refuse(http::status::bad_request, "this is not a request that the view knows");
    self->answer(self->parser_->get());
  });
}

void Connection::answer(const http::request<http::empty_body>& request) {
  if (request.count(http::field::host) != 1 || !is_own_host(field_of(request, http::field::host))) {
    return refuse(http::status::misdirected_request, "this server answers only to localhost and 127.0.0.1");
  }
  if (websocket::is_upgrade(request)) return open_page(request);
  if (request.method() != http::verb::get && request.method() != http::verb::head) {
    return refuse(http::status::method_not_allowed, "the view serves only files");
  }
  const std::string_view target(request.target().data(), request.target().size());
  for (const ViewFile& file : view_files()) {
    if (target == file.path) return give(request, file);
  }
  refuse(http::status::not_found, "there is no such file");
}

void Connection::open_page(const http::request<http::empty_body>& request) {
  const auto target = request.target();
  if (std::string_view(target.data(), target.size()) != "/stream") {
    return refuse(http::status::not_found, "there is no such stream");
  }
  if (!is_same_origin(field_of(request, http::field::origin), field_of(request, http::field::host))) {
    return refuse(http::status::forbidden, "the page has another origin");
  }
  const auto token = offered_token(field_of(request, http::field::sec_websocket_protocol), protocol);
  if (!token || !same_secret(*token, server_.token)) {
    return refuse(http::status::unauthorized, "the token is missing or wrong: open the address that tactor printed");
  }
  if (!server_.has_room()) return refuse(http::status::service_unavailable, "8 pages are open already");
  server_.add_page(stream_.release_socket(), request);
}

void Connection::give(const http::request<http::empty_body>& request, const ViewFile& file) {
  http::response<http::string_body> response{http::status::ok, 11};
  response.set(http::field::content_type, file.content_type);
  response.set(http::field::content_encoding, "gzip");
  if (request.method() == http::verb::get) response.body() = file.gzip;
  const auto host = request[http::field::host];
  // Not every browser takes 'self' for a WebSocket of the same origin.
  response.set(
      "Content-Security-Policy",
      "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self' ws://" +
          std::string(host.data(), host.size()) + "; base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
  response.keep_alive(request.keep_alive());
  respond(std::move(response));
}

void Connection::refuse(http::status status, const std::string& why) {
  respond(refusal_of(status, why));
}

void Connection::respond(http::response<http::string_body> response) {
  response_ = std::move(response);
  response_->set(http::field::server, "tactor");
  response_->set(http::field::cache_control, "no-store");
  response_->set("X-Content-Type-Options", "nosniff");
  response_->set("Referrer-Policy", "no-referrer");
  response_->set("Cross-Origin-Opener-Policy", "same-origin");
  response_->set("Cross-Origin-Resource-Policy", "same-origin");
  response_->prepare_payload();
  move_to_back();
  stream_.expires_after(write_timeout);
  http::async_write(stream_, *response_, [self = shared_from_this()](error_code error, std::size_t) {
    if (error) return;
    if (self->response_->keep_alive()) return self->read();
    self->stream_.socket().shutdown(tcp::socket::shutdown_send, error);
  });
}

}  // namespace

std::unique_ptr<ViewServer> make_http_server(ViewSource& source, const ViewPorts& ports) {
  return std::make_unique<Server>(source, ports);
}

}  // namespace tactor
