#include "app/view/foxglove/export_mcap.hpp"

#include <algorithm>

#include "app/view/foxglove/foxglove_messages.hpp"
#include "app/view/foxglove/mcap_writer.hpp"
#include "app/view/samples.hpp"

namespace tactor {

void export_mcap(std::ostream& out, const std::string& hello, const std::vector<std::string>& meshes,
                 const std::vector<std::string>& frames) {
  FoxgloveMessages translator(hello, meshes);
  McapWriter writer(out);
  writer.add_metadata("tactor", translator.about());
  std::vector<McapWriter::ChannelId> ids;
  for (const FoxgloveChannel& channel : translator.channels()) {
    ids.push_back(writer.add_channel(channel.topic, channel.schema_name, channel.schema));
  }
  std::vector<FoxgloveMessage> messages = translator.first();
  const auto write_all = [&] {
    std::stable_sort(messages.begin(), messages.end(),
                     [](const FoxgloveMessage& a, const FoxgloveMessage& b) { return a.time_ns < b.time_ns; });
    for (const FoxgloveMessage& message : messages) {
      writer.add_message(ids[message.channel], message.time_ns, message.json);
    }
    messages.clear();
  };
  write_all();
  const std::vector<bool> all(ids.size(), true);
  for (const std::string& frame : frames) {
    for_each_chunk(frame, [&](std::string_view chunk) { translator.add(chunk, all, messages); });
    write_all();
  }
  writer.finish();
}

}  // namespace tactor
