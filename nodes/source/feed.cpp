#include "nodes/source/feed.hpp"

#include "framework/core/value_error.hpp"
#include "framework/node/declare.hpp"

namespace tactor {

namespace {

const MessageType& type_of_feed(const FeedSource::Params& params) {
  if (const MessageType* type = known_message_type(params.message)) return *type;
  throw ValueError("message", "expected a message type of the other nodes of the graph, found " + params.message +
                                  "; `tactor schema --messages` describes them all");
}

}  // namespace

FeedSource::FeedSource(const Params& params, const NodeContext& /*context*/) {
  message.set_type(type_of_feed(params));
}

NodeInfo FeedSource::declare() {
  return Declare<FeedSource>("source.feed", "Sends the messages that a program gives it during the run.")
      .details(
          "Use it in programs that use Tactor as a library. Session::feed sends messages here, and they go along the "
          "edges like those of any node. A run that no program feeds gets none.")
      .role(Role::source)
      .fed()
      .output("message", &FeedSource::message, "what the program sends", type_of_feed)
      .text("message", &Params::message, std::nullopt, "the message type, for example Target")
      .info();
}

}  // namespace tactor
