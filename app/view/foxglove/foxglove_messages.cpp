#include "app/view/foxglove/foxglove_messages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/view/foxglove/foxglove_scene.hpp"
#include "app/view/foxglove/foxglove_schemas.hpp"
#include "app/view/samples.hpp"

namespace tactor {

namespace {

using nlohmann::json;

constexpr const char* scene_update = "foxglove.SceneUpdate";
constexpr const char* frame_transform = "foxglove.FrameTransform";
constexpr FoxgloveColor contact_color{0.85, 0.20, 0.20, 1}, patch_color{0.25, 0.65, 0.35, 1},
    force_color{0.10, 0.30, 0.75, 1};
/// In sizes of the scene.
constexpr double normal_length = 0.15, length_per_newton = 0.25;
constexpr double force_period = 1.0 / 30;  // s

std::int64_t ns_of(double seconds) {
  return std::llround(seconds * 1e9);
}

/// `device.commanded` becomes `/device/commanded`.
std::string topic_of(std::string output) {
  std::replace(output.begin(), output.end(), '.', '/');
  return "/" + output;
}

void add_value(std::string& text, float value) {
  if (std::isfinite(value)) {
    fmt::format_to(std::back_inserter(text), "{}", value);
  } else {
    text += "null";
  }
}

/// The texts around the values of a row; those of `force.x`, `force.y` lie in one object. The first follows the time.
std::vector<std::string> pieces_of(const std::string& texts, const std::vector<std::string>& names) {
  std::vector<std::string> pieces;
  std::string open, text = texts;
  for (const std::string& name : names) {
    const std::size_t dot = name.find('.');
    const std::string group = dot == std::string::npos ? "" : name.substr(0, dot);
    if (group != open && !open.empty()) text += "}";
    text += ",";
    if (group != open && !group.empty()) {
      text += "\"" + group + "\":{";
    }
    text += "\"" + (dot == std::string::npos ? name : name.substr(dot + 1)) + "\":";
    open = group;
    pieces.push_back(std::move(text));
    text.clear();
  }
  pieces.push_back(open.empty() ? "}" : "}}");
  return pieces;
}

std::string schema_name_of(const std::string& role) {
  if (role == "delay") return "tactor.Delay";
  if (role == "contact_count") return "tactor.ContactCount";
  if (role == "safety") return "tactor.SafetyState";
  return "tactor.Wrench";
}

/// `0 none, 1 not_finite, ...`
std::string meanings_of(const json& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    text += (i > 0 ? ", " : "") + std::to_string(i) + " " + names[i].get<std::string>();
  }
  return text;
}

/// The columns of poses as Foxglove calls them.
std::string transform_name(const std::string& column) {
  return (column[0] == 'p' ? "translation" : "rotation") + column.substr(1);
}

std::string frame_texts(const std::string& child) {
  return R"(,"parent_frame_id":"world","child_frame_id":)" +
         json(child).dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace

FoxgloveMessages::FoxgloveMessages(const std::string& hello_text, std::span<const std::string> meshes) {
  const json hello = json::parse(hello_text);
  const json& bodies = hello["scene"]["bodies"];
  about_ = {{"graph", hello["graph"]}, {"title", hello["title"]}, {"version", hello["version"]}};
  for (const json& parameter : hello["parameters"]) parameters_[parameter["name"]] = parameter["value"].dump();
  size_ = scene_size(hello, meshes);

  const std::vector<std::string> frames{"parent_frame_id", "child_frame_id"};
  const std::vector<std::string> pose_names{"translation.x", "translation.y", "translation.z", "rotation.w",
                                            "rotation.x",    "rotation.y",    "rotation.z"};
  const std::vector<std::string> pose_units{"m", "m", "m", "1", "1", "1", "1"};
  const std::size_t scene_channel = channel("/scene", scene_update, scene_update_schema());
  const std::size_t frame_channel =
      channel("/tf", frame_transform, row_schema(frame_transform, frames, pose_names, pose_units));
  force_channel_ = channel("/force", scene_update, scene_update_schema());
  first_.push_back({scene_channel, 0, bodies_update(hello, meshes)});
  const auto add_first = [&](const std::string& frame, const json& pose) {
    std::string text = "{\"timestamp\":" + time_text(0);
    const std::vector<std::string> pieces = pieces_of(frame_texts(frame), pose_names);
    for (std::size_t i = 0; i < pose_names.size(); ++i) add_value(text += pieces[i], pose[i].get<float>());
    first_.push_back({frame_channel, 0, text + pieces.back()});
  };
  for (const json& body : bodies) {
    if (body["moves"].get<bool>()) add_first(body["name"], body["pose"]);
  }
  const json& start = hello["device"]["start"];
  add_first(handle_frame, start);
  handle_[0] = {start[0].get<float>(), start[1].get<float>(), start[2].get<float>()};
  // A live run is told in order of time, and only what was just now matters.
  if (hello["mode"] == "live") most_handles_ = 1024;

  for (const json& shown : hello["streams"]) {
    const std::string role = shown["role"], output = shown["name"];
    std::vector<std::string> names, units;
    for (const json& column : shown["columns"]) {
      names.push_back(column["name"]);
      units.push_back(column["unit"]);
      if (names.back() == "engagement") units.back() = meanings_of(hello["engagements"]);
      if (names.back() == "cause") units.back() = meanings_of(hello["causes"]);
    }
    Stream stream;
    stream.columns = names.size();
    columns_.push_back(names.size());
    stream.is_handle = role == "handle";
    stream.is_commanded = role == "commanded";
    if (role == "surface") {
      // Deformable bodies are shown at rest: as text, their surfaces would be megabytes a second.
      stream.kind = Kind::left_out;
    } else if (role == "contacts" || role == "patch") {
      stream.kind = role == "patch" ? Kind::patch : Kind::contacts;
      stream.channel = channel(topic_of(output), scene_update, scene_update_schema());
    } else if (role == "handle" || role == "body") {
      std::transform(names.begin(), names.end(), names.begin(), transform_name);
      stream.channel = frame_channel;
      stream.pieces =
          pieces_of(frame_texts(role == "handle" ? std::string(handle_frame)
                                                 : bodies[shown["body"].get<std::size_t>()]["name"].get<std::string>()),
                    names);
    } else {
      const std::string schema = schema_name_of(role);
      // What is told of a force beside it has a topic below.
      const bool beside = role == "delay" || role == "contact_count";
      stream.channel =
          channel(topic_of(output) + (beside ? "/" + names.front() : ""), schema, row_schema(schema, {}, names, units));
      stream.pieces = pieces_of("", names);
    }
    streams_.push_back(std::move(stream));
  }
}

std::size_t FoxgloveMessages::channel(const std::string& topic, const std::string& schema_name,
                                      const std::string& schema) {
  channels_.push_back({topic, schema_name, schema});
  return channels_.size() - 1;
}

void FoxgloveMessages::add_force(double time, const float* force, std::vector<FoxgloveMessage>& messages) {
  if (time < next_force_) return;
  next_force_ = time + force_period;
  FoxgloveArrow arrow;
  // Streams come one after another: the handle was here at the time of the force.
  const auto after = handle_.upper_bound(ns_of(time));
  std::copy_n((after == handle_.begin() ? after : std::prev(after))->second.data(), 3, arrow.p);
  std::copy_n(force, 3, arrow.d);
  arrow.length = std::hypot(force[0], force[1], force[2]) * length_per_newton * size_;
  messages.push_back({force_channel_, ns_of(time), arrows_update("commanded", ns_of(time), {arrow}, force_color)});
}

void FoxgloveMessages::add_rows(const Stream& stream, const ChunkSection& section, const std::vector<bool>& wanted,
                                std::vector<FoxgloveMessage>& messages) {
  for (std::size_t row = 0; row < section.times.size(); ++row) {
    const float* values = &section.values[row * stream.columns];
    const double time = section.times[row];
    if (stream.is_handle) handle_[ns_of(time)] = {values[0], values[1], values[2]};
    while (handle_.size() > most_handles_) handle_.erase(handle_.begin());
    if (stream.is_commanded && wanted[force_channel_]) add_force(time, values, messages);
    if (!wanted[stream.channel]) continue;
    FoxgloveMessage message{stream.channel, ns_of(time), "{\"timestamp\":" + time_text(ns_of(time))};
    for (std::size_t i = 0; i < stream.columns; ++i) add_value(message.json += stream.pieces[i], values[i]);
    message.json += stream.pieces.back();
    messages.push_back(std::move(message));
  }
}

void FoxgloveMessages::add(std::string_view chunk, const std::vector<bool>& wanted,
                           std::vector<FoxgloveMessage>& messages) {
  for_each_section(chunk, columns_, [&](const ChunkSection& section) {
    const Stream& stream = streams_[section.stream];
    if (stream.kind == Kind::left_out) return;
    if (stream.kind == Kind::rows) return add_rows(stream, section, wanted, messages);
    if (!wanted[stream.channel]) return;
    const bool is_patch = stream.kind == Kind::patch;
    std::vector<FoxgloveArrow> arrows;
    for (std::size_t i = 0; i < section.values.size(); i += stream.columns) {
      FoxgloveArrow arrow;
      std::copy_n(&section.values[i], 3, arrow.p);
      std::copy_n(&section.values[i + 3], 3, arrow.d);
      arrow.length = normal_length * size_;
      arrows.push_back(arrow);
    }
    const std::int64_t time = ns_of(section.times.front());
    messages.push_back(
        {stream.channel, time,
         arrows_update(channels_[stream.channel].topic, time, arrows, is_patch ? patch_color : contact_color)});
  });
}

}  // namespace tactor
