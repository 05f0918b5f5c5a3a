// The request that a WebSocket begins with: its fields, a refusal, and how the stream is set up.
#pragma once

// Asio of Boost 1.74 lacks it under C++20.
#include <utility>

#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <string>
#include <string_view>

namespace tactor {

using UpgradeRequest = boost::beast::http::request<boost::beast::http::empty_body>;
using TextResponse = boost::beast::http::response<boost::beast::http::string_body>;

/// The value of a field of the request; empty where it has none. The request outlives it.
inline std::string_view field_of(const UpgradeRequest& request, boost::beast::http::field field) {
  const auto value = request[field];
  return {value.data(), value.size()};
}

/// A response that says why the request is refused, after which the connection ends.
inline TextResponse refusal_of(boost::beast::http::status status, const std::string& why) {
  namespace http = boost::beast::http;
  TextResponse response{status, 11};
  response.set(http::field::server, "tactor");
  response.set(http::field::content_type, "text/plain; charset=utf-8");
  response.body() = why + "\n";
  response.keep_alive(false);
  response.prepare_payload();
  return response;
}

/// Lets the stream speak `protocol`, each message in one frame, with `timeout` for the handshake and none after it.
template <class Stream>
void set_up(Stream& stream, std::string_view protocol, std::chrono::seconds timeout) {
  namespace websocket = boost::beast::websocket;
  websocket::stream_base::timeout limits{};
  limits.handshake_timeout = timeout;
  limits.idle_timeout = websocket::stream_base::none();
  stream.set_option(limits);
  stream.set_option(
      websocket::stream_base::decorator([chosen = std::string(protocol)](websocket::response_type& response) {
        response.set(boost::beast::http::field::server, "tactor");
        response.set(boost::beast::http::field::sec_websocket_protocol, chosen);
      }));
  stream.auto_fragment(false);
}

}  // namespace tactor
