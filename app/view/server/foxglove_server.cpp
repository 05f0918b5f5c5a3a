// All that Boost.Beast does for Foxglove viewers is here: it takes long to compile.
#include "app/view/server/foxglove_server.hpp"

// Asio of Boost 1.74 lacks it under C++20.
#include <utility>

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/asio/post.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <list>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "app/view/foxglove/foxglove_messages.hpp"
#include "app/view/samples.hpp"
#include "app/view/server/foxglove_text.hpp"
#include "app/view/server/request_meter.hpp"
#include "app/view/server/viewer_queue.hpp"
#include "app/web/listener.hpp"
#include "app/web/request_rules.hpp"
#include "app/web/upgrade.hpp"
#include "framework/core/shell_word.hpp"
#include "framework/realtime/make_thread.hpp"

namespace tactor {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using boost::system::error_code;
using nlohmann::json;
using Shared = std::shared_ptr<const std::string>;
using LimitedStream = beast::basic_stream<tcp, asio::any_io_executor, beast::simple_rate_policy>;

constexpr std::size_t request_limit = 64 * 1024;  // bytes, from a viewer
constexpr std::uint32_t handshake_limit = 8 * 1024;
constexpr std::chrono::seconds handshake_timeout{5};
constexpr std::chrono::milliseconds look_for_room{50};
constexpr std::size_t most_viewers = 8;
constexpr std::size_t most_handshakes = 32;
constexpr std::size_t most_origins_told = 8;
/// Bytes of samples that wait to be translated; then whole chunks are left out.
constexpr std::size_t most_untranslated = std::size_t{1} << 20U;
/// What the system holds for a viewer; left alone it grows to some megabytes.
constexpr int send_buffer = 256 * 1024;
constexpr std::array<std::string_view, 2> protocols{"foxglove.sdk.v1", "foxglove.websocket.v1"};

enum BinaryOperation : char { message_data = 1, time_data = 2 };
enum StatusLevel : int { level_info = 0, level_warning = 1 };

template <class T>
void put_bytes(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

Shared shared(std::string text) {
  return std::make_shared<const std::string>(std::move(text));
}

std::string text_of(const json& object) {
  return object.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string status_text(StatusLevel level, const std::string& message) {
  return text_of({{"op", "status"}, {"level", static_cast<int>(level)}, {"message", message}});
}

/// A message of a channel, which all its viewers share.
struct Sample {
  std::size_t channel = 0;
  std::int64_t time_ns = 0;
  Shared body;
  bool kept = false;  // the server keeps it as long as it runs
};

class FoxgloveHub;

/// A connection, from its handshake on.
class Viewer : public std::enable_shared_from_this<Viewer> {
 public:
  Viewer(FoxgloveHub& hub, tcp::socket socket, std::size_t& waiting_of_all)
      : hub_(hub), stream_(std::move(socket)), timer_(stream_.get_executor()), waiting_(waiting_of_all) {
    // Frames that end no request are work too.
    beast::get_lowest_layer(stream_).rate_policy().read_limit(RequestMeter::a_second);
  }
  void accept();
  void send(std::string text);
  void send(const Sample& sample);
  void send_time(std::int64_t time_ns);
  void leave_out(std::uint64_t messages) { left_out_ += messages; }
  void tell_parameter(const std::string& name);
  [[nodiscard]] bool wants(std::size_t channel) const { return subscriptions_.count(channel) > 0; }
  [[nodiscard]] bool is_open() const { return open_; }
  [[nodiscard]] bool has_place() const { return has_place_; }
  void end();

 private:
  void answer();
  void refuse(http::status status, const std::string& why);
  void upgrade();
  void read();
  void read_later(std::chrono::steady_clock::duration wait);
  /// Returns the bytes that are sent once more for it.
  std::uint64_t take(std::string_view text);
  std::uint64_t subscribe(const FoxgloveRequest& request);
  void give_parameters(const std::vector<std::string>& names, const std::string& id);
  void tell_left_out();
  void push(ViewerMessage message);
  void pump();

  FoxgloveHub& hub_;
  websocket::stream<LimitedStream> stream_;
  asio::steady_timer timer_;
  beast::flat_buffer buffer_;
  http::request_parser<http::empty_body> parser_;
  TextResponse refusal_;
  RequestMeter meter_{std::chrono::steady_clock::now()};
  std::map<std::size_t, std::uint32_t> subscriptions_;  // by channel, of which a viewer may have one each
  std::set<std::size_t> greeted_;                       // channels whose first messages were sent
  std::set<std::string> followed_;                      // parameters
  bool follows_all_ = false;
  bool parameters_left_out_ = false;
  ViewerQueue waiting_;
  ViewerMessage current_;
  std::uint64_t left_out_ = 0;
  bool writing_ = false;
  bool has_place_ = false;  // one of those that may be open at once
  bool open_ = false;
  bool ended_ = false;
};

class FoxgloveHub final : public FoxgloveServer {
 public:
  FoxgloveHub(ViewSource& source, std::uint16_t port, std::vector<std::string> allowed_origins)
      : source_(source),
        allowed_origins_(std::move(allowed_origins)),
        translator_(source.hello(), source.first_messages()),
        listener_(io_, port, "the server for Foxglove", "--foxglove=PORT") {
    values_ = translator_.parameters();
    url_ = "ws://127.0.0.1:" + std::to_string(listener_.port());
    first_.resize(translator_.channels().size());
    for (const FoxgloveMessage& message : translator_.first()) {
      // The translator keeps the text, so that nothing has to count its users.
      const Shared body(Shared(), &message.json);
      first_[message.channel].push_back({message.channel, message.time_ns, body, true});
    }
    greeting_ = {shared(text_of({{"op", "serverInfo"},
                                 {"name", "tactor " + translator_.about().at("graph")},
                                 {"capabilities", {"time", "parameters", "parametersSubscribe"}},
                                 {"supportedEncodings", json::array()},
                                 {"metadata", translator_.about()}})),
                 shared(advertisement())};
  }
  ~FoxgloveHub() override {
    io_.stop();
    if (thread_.joinable()) thread_.join();
  }
  FoxgloveHub(const FoxgloveHub&) = delete;
  FoxgloveHub& operator=(const FoxgloveHub&) = delete;

  [[nodiscard]] std::string url() const override { return url_; }

  void start() override {
    listener_.start([this](tcp::socket socket) { take_in(std::move(socket)); },
                    [this](const std::string& note) { source_.note(note); });
    thread_ = make_thread("foxglove", [this] {
      try {
        io_.run();
      } catch (const std::exception& error) {
        // The run goes on without it.
        source_.note(std::string("the server for Foxglove has ended: ") + error.what());
        viewers_ = 0;
        sending_ = 0;
      }
    });
  }

  void add(Shared chunk) override {
    if (viewers_ == 0) return;
    const std::size_t size = chunk->size();
    if (untranslated_ + size > most_untranslated) {
      ++chunks_left_out_;
      return;
    }
    untranslated_ += size;
    asio::post(io_, [this, size, chunk = std::move(chunk)] {
      translate(*chunk);
      untranslated_ -= size;
    });
  }

  void tell(std::string text) override {
    ++texts_;
    asio::post(io_, [this, text = std::move(text)] {
      tell_viewers(text);
      --texts_;
    });
  }

  void close() override {
    asio::post(io_, [this] { listener_.close(); });
  }

  [[nodiscard]] bool is_sending() const override { return texts_ > 0 || untranslated_ > 0 || sending_ > 0; }
  [[nodiscard]] bool has_viewers() const override { return viewers_ > 0; }

  // For viewers, on the thread of the server.

  [[nodiscard]] bool has_room() const {
    return std::count_if(connections_.begin(), connections_.end(), [](const auto& v) { return v->has_place(); }) <
           static_cast<std::ptrdiff_t>(most_viewers);
  }
  /// Programs send no origin; a page of this server would have its own.
  [[nodiscard]] bool is_allowed(std::string_view origin, std::string_view host) {
    if (origin.empty() || is_same_origin(origin, host)) return true;
    const std::string name(origin);
    if (std::find(allowed_origins_.begin(), allowed_origins_.end(), name) != allowed_origins_.end()) return true;
    constexpr std::size_t longest = 256;  // that is worth telling
    if (name.size() <= longest && told_origins_.size() < most_origins_told && told_origins_.insert(name).second) {
      source_.note("a page of " + name + " asked for the stream for Foxglove and was refused; --allow-origin " +
                   as_typed(name) + " lets it in");
    }
    return false;
  }
  /// What every viewer is told first.
  [[nodiscard]] const std::array<Shared, 2>& greeting() const { return greeting_; }
  [[nodiscard]] std::size_t channel_count() const { return first_.size(); }
  /// The messages of a channel that a late viewer needs too.
  [[nodiscard]] const std::vector<Sample>& first_of(std::size_t channel) const { return first_[channel]; }
  /// Of parameters: JSON, by name.
  [[nodiscard]] const std::map<std::string, std::string>& values() const { return values_; }
  void forget(const std::shared_ptr<Viewer>& viewer) {
    connections_.remove(viewer);
    viewers_ = connections_.size();
  }
  void count_sending(int change) { sending_ += change; }

 private:
  [[nodiscard]] std::string advertisement() const {
    json channels = json::array();
    for (std::size_t i = 0; i < translator_.channels().size(); ++i) {
      const FoxgloveChannel& channel = translator_.channels()[i];
      channels.push_back({{"id", i},
                          {"topic", channel.topic},
                          {"encoding", "json"},
                          {"schemaName", channel.schema_name},
                          {"schema", channel.schema},
                          {"schemaEncoding", "jsonschema"}});
    }
    return text_of({{"op", "advertise"}, {"channels", std::move(channels)}});
  }

  void take_in(tcp::socket socket) {
    const auto has_no_place = [](const auto& viewer) { return !viewer->has_place(); };
    if (std::count_if(connections_.begin(), connections_.end(), has_no_place) >=
        static_cast<std::ptrdiff_t>(most_handshakes)) {
      // Whoever says nothing gives way to whoever may have something to say: the oldest stands first.
      const auto oldest = *std::find_if(connections_.begin(), connections_.end(), has_no_place);
      oldest->end();
    }
    error_code ignored;
    socket.set_option(tcp::no_delay(true), ignored);
    socket.set_option(asio::socket_base::send_buffer_size(send_buffer), ignored);
    connections_.push_back(std::make_shared<Viewer>(*this, std::move(socket), waiting_of_all_));
    viewers_ = connections_.size();
    connections_.back()->accept();
  }

  void tell_viewers(const std::string& text) {
    const json told = json::parse(text, nullptr, false);
    if (!told.is_object()) return;
    const auto viewers = connections_;
    if (told["type"] == "set") {
      const std::string name = told["parameter"];
      values_[name] = told["value"].dump();
      for (const auto& viewer : viewers) viewer->tell_parameter(name);
    } else if (told["type"] == "ended") {
      for (const auto& viewer : viewers) {
        if (viewer->is_open())
          viewer->send(status_text(level_info, "the run has ended: " + told["why"].get<std::string>()));
      }
    }
  }

  void translate(std::string_view chunk) {
    // One may go while it is told.
    const auto viewers = connections_;
    if (const std::uint64_t lost = chunks_left_out_.exchange(0); lost > 0) {
      for (const auto& viewer : viewers) viewer->leave_out(lost);
    }
    std::vector<bool> wanted(first_.size());
    for (std::size_t channel = 0; channel < wanted.size(); ++channel) {
      for (const auto& viewer : viewers) wanted[channel] = wanted[channel] || viewer->wants(channel);
    }
    messages_.clear();
    translator_.add(chunk, wanted, messages_);
    std::stable_sort(messages_.begin(), messages_.end(),
                     [](const FoxgloveMessage& a, const FoxgloveMessage& b) { return a.time_ns < b.time_ns; });
    const auto end = static_cast<std::int64_t>(std::max(chunk_end(chunk), 0.0) * 1e9);
    for (FoxgloveMessage& message : messages_) {
      // Viewers plot a message at the time that they were told last; a prediction is of a time to come.
      tell_time(viewers, std::min(message.time_ns, end));
      const Sample sample{message.channel, message.time_ns, shared(std::move(message.json))};
      for (const auto& viewer : viewers) viewer->send(sample);
    }
    tell_time(viewers, end);
  }

  void tell_time(const std::list<std::shared_ptr<Viewer>>& viewers, std::int64_t time_ns) {
    // A step back would be taken for a jump.
    if (time_ns <= told_ns_) return;
    told_ns_ = time_ns;
    for (const auto& viewer : viewers) viewer->send_time(time_ns);
  }

  ViewSource& source_;
  std::vector<std::string> allowed_origins_;
  std::set<std::string> told_origins_;
  std::string url_;
  FoxgloveMessages translator_;
  std::vector<std::vector<Sample>> first_;  // by channel
  std::array<Shared, 2> greeting_;
  std::map<std::string, std::string> values_;
  std::vector<FoxgloveMessage> messages_;
  std::int64_t told_ns_ = 0;
  std::atomic<std::size_t> viewers_{0};       // connections
  std::atomic<int> texts_{0};                 // that viewers have not been told
  std::atomic<std::size_t> untranslated_{0};  // bytes of chunks
  std::atomic<std::uint64_t> chunks_left_out_{0};
  std::atomic<int> sending_{0};     // viewers that something is being written to
  std::size_t waiting_of_all_ = 0;  // bytes; the queues in the context refer to it
  asio::io_context io_{1};
  Listener listener_;
  std::list<std::shared_ptr<Viewer>> connections_;  // as they came
  std::thread thread_;
};

void Viewer::accept() {
  parser_.header_limit(handshake_limit);
  beast::get_lowest_layer(stream_).expires_after(handshake_timeout);
  http::async_read(stream_.next_layer(), buffer_, parser_, [self = shared_from_this()](error_code error, std::size_t) {
    if (error) return self->end();
    self->answer();
  });
}

void Viewer::answer() {
  const auto& request = parser_.get();
  const std::string_view host = field_of(request, http::field::host);
  if (request.count(http::field::host) != 1 || !is_own_host(host)) {
    return refuse(http::status::misdirected_request, "this server answers only to localhost and 127.0.0.1");
  }
  if (request.count(http::field::origin) > 1 || !hub_.is_allowed(field_of(request, http::field::origin), host)) {
    return refuse(http::status::forbidden, "the page has another origin; --allow-origin ORIGIN lets it in");
  }
  if (!websocket::is_upgrade(request)) {
    return refuse(http::status::upgrade_required, "this server speaks the Foxglove WebSocket protocol alone");
  }
  if (!offered_protocol(field_of(request, http::field::sec_websocket_protocol), protocols)) {
    return refuse(http::status::bad_request, "expected the protocol foxglove.sdk.v1 or foxglove.websocket.v1");
  }
  if (!hub_.has_room()) return refuse(http::status::service_unavailable, "8 viewers are connected already");
  has_place_ = true;
  upgrade();
}

void Viewer::refuse(http::status status, const std::string& why) {
  refusal_ = refusal_of(status, why);
  http::async_write(stream_.next_layer(), refusal_,
                    [self = shared_from_this()](error_code, std::size_t) { self->end(); });
}

void Viewer::upgrade() {
  const auto offered = offered_protocol(field_of(parser_.get(), http::field::sec_websocket_protocol), protocols);
  beast::get_lowest_layer(stream_).expires_never();
  set_up(stream_, *offered, handshake_timeout);
  stream_.read_message_max(request_limit);
  stream_.async_accept(parser_.get(), [self = shared_from_this()](error_code error) {
    if (error) return self->end();
    self->buffer_.clear();
    self->open_ = true;
    for (const Shared& text : self->hub_.greeting()) self->push({{}, text, false, true});
    self->read();
  });
}

void Viewer::read() {
  if (!open_) return;
  // Whoever does not take its answers asks in vain: the request stays with the system, and with the viewer.
  if (!waiting_.has_room()) return read_later(look_for_room);
  stream_.async_read(buffer_, [self = shared_from_this()](error_code error, std::size_t) {
    if (error) return self->end();
    const auto data = self->buffer_.data();
    std::uint64_t work = data.size();
    // Bytes are messages and service calls, which nobody offered.
    if (self->stream_.got_text()) work += self->take({static_cast<const char*>(data.data()), data.size()});
    self->buffer_.consume(self->buffer_.size());
    self->read_later(self->meter_.spend(work, std::chrono::steady_clock::now()));
  });
}

void Viewer::read_later(std::chrono::steady_clock::duration wait) {
  if (wait <= std::chrono::steady_clock::duration::zero()) return read();
  timer_.expires_after(wait);
  timer_.async_wait([self = shared_from_this()](error_code error) {
    if (!error) self->read();
  });
}

std::uint64_t Viewer::take(std::string_view text) {
  const std::optional<FoxgloveRequest> request = read_foxglove_text(text);
  if (!request) {
    send(status_text(level_warning, "this is not a request of the Foxglove WebSocket protocol"));
    return 0;
  }
  switch (request->kind) {
    case FoxgloveRequest::Kind::subscribe:
      return subscribe(*request);
    case FoxgloveRequest::Kind::unsubscribe:
      for (const std::uint32_t id : request->ids) {
        std::erase_if(subscriptions_, [id](const auto& subscription) { return subscription.second == id; });
      }
      return 0;
    case FoxgloveRequest::Kind::get_parameters:
      give_parameters(request->names, request->id);
      return 0;
    case FoxgloveRequest::Kind::set_parameters:
      // The answer holds what goes on to be true.
      send(status_text(level_warning, "this server is read-only: parameters are changed in the page of `tactor view`"));
      give_parameters(request->names, request->id);
      return 0;
    case FoxgloveRequest::Kind::follow_parameters:
      follows_all_ = follows_all_ || request->names.empty();
      for (const std::string& name : request->names) {
        if (hub_.values().count(name) > 0) followed_.insert(name);
      }
      return 0;
    case FoxgloveRequest::Kind::unfollow_parameters:
      if (request->names.empty()) follows_all_ = false, followed_.clear();
      for (const std::string& name : request->names) followed_.erase(name);
      return 0;
    case FoxgloveRequest::Kind::other:
      return 0;
  }
  return 0;
}

std::uint64_t Viewer::subscribe(const FoxgloveRequest& request) {
  std::uint64_t again = 0;
  std::string wrong;
  for (const auto& [id, channel] : request.subscriptions) {
    const bool used = std::any_of(subscriptions_.begin(), subscriptions_.end(),
                                  [id = id](const auto& subscription) { return subscription.second == id; });
    // One warning for the whole request, so that an answer is not longer than what was asked.
    if (channel >= hub_.channel_count()) {
      wrong = "there is no channel " + std::to_string(channel);
    } else if (used || wants(channel)) {
      wrong = "there is a subscription of channel " + std::to_string(channel) + " or of this id already";
    } else {
      subscriptions_[channel] = id;
      const bool is_new = greeted_.insert(channel).second;
      for (const Sample& sample : hub_.first_of(channel)) {
        if (!is_new) again += sample.body->size();
        send(sample);
      }
    }
  }
  if (!wrong.empty()) send(status_text(level_warning, wrong));
  return again;
}

void Viewer::give_parameters(const std::vector<std::string>& names, const std::string& id) {
  const std::set<std::string> asked(names.begin(), names.end());
  json list = json::array();
  for (const auto& [name, value] : hub_.values()) {
    if (asked.empty() || asked.count(name) > 0) list.push_back({{"name", name}, {"value", json::parse(value)}});
  }
  json answer = {{"op", "parameterValues"}, {"parameters", std::move(list)}};
  if (!id.empty()) answer["id"] = id;
  send(text_of(answer));
}

void Viewer::tell_parameter(const std::string& name) {
  if (!open_ || (!follows_all_ && followed_.count(name) == 0)) return;
  if (waiting_.has_room()) return give_parameters({name}, {});
  parameters_left_out_ = true;
}

void Viewer::send(std::string text) {
  push({{}, shared(std::move(text)), false});
}

void Viewer::send(const Sample& sample) {
  const auto subscription = subscriptions_.find(sample.channel);
  if (!open_ || subscription == subscriptions_.end()) return;
  if (!sample.kept && !waiting_.has_room()) {
    ++left_out_;
    return;
  }
  tell_left_out();
  std::string head(1, message_data);
  put_bytes(head, subscription->second);
  put_bytes(head, static_cast<std::uint64_t>(std::max<std::int64_t>(sample.time_ns, 0)));
  push({std::move(head), sample.body, true, sample.kept});
}

void Viewer::tell_left_out() {
  if (left_out_ == 0 || !waiting_.has_room()) return;
  const std::string count = std::to_string(std::exchange(left_out_, 0));
  send(status_text(level_warning, count + " messages were left out: they were not read in time"));
}

void Viewer::send_time(std::int64_t time_ns) {
  static const Shared none = shared({});
  if (!open_ || !waiting_.has_room()) return;
  std::string bytes(1, time_data);
  put_bytes(bytes, static_cast<std::uint64_t>(time_ns));
  push({std::move(bytes), none, true});
}

void Viewer::push(ViewerMessage message) {
  if (!open_) return;
  waiting_.add(std::move(message));
  pump();
}

void Viewer::pump() {
  if (!open_ || writing_) return;
  if (waiting_.empty()) {
    if (!std::exchange(parameters_left_out_, false) || (!follows_all_ && followed_.empty())) return;
    return give_parameters(follows_all_ ? std::vector<std::string>() : std::vector(followed_.begin(), followed_.end()),
                           {});
  }
  current_ = waiting_.next();
  writing_ = true;
  hub_.count_sending(1);
  stream_.binary(current_.binary);
  const std::array<asio::const_buffer, 2> parts{asio::buffer(current_.head), asio::buffer(*current_.body)};
  stream_.async_write(parts, [self = shared_from_this()](error_code error, std::size_t) {
    self->writing_ = false;
    self->waiting_.sent(self->current_);
    if (error) self->end();
    // Counted while the next one begins, so that nobody sees a pause between them.
    self->pump();
    self->hub_.count_sending(-1);
  });
}

void Viewer::end() {
  if (ended_) return;
  ended_ = true;
  open_ = false;
  timer_.cancel();
  beast::get_lowest_layer(stream_).close();
  hub_.forget(shared_from_this());
}

}  // namespace

std::unique_ptr<FoxgloveServer> make_foxglove_server(ViewSource& source, std::uint16_t port,
                                                     std::vector<std::string> allowed_origins) {
  return std::make_unique<FoxgloveHub>(source, port, std::move(allowed_origins));
}

}  // namespace tactor
