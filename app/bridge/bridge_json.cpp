#include "app/bridge/bridge_json.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>

#include "framework/yaml/diagnostics.hpp"

namespace tactor {

namespace {

using Json = nlohmann::ordered_json;

Json json_of(double value) {
  return value;
}
Json json_of(std::int32_t value) {
  return value;
}
Json json_of(std::uint64_t value) {
  return value;
}
Json json_of(Time time) {
  return time.ns;
}
Json json_of(const Vec3& v) {
  return {v.x, v.y, v.z};
}
Json json_of(const Quat& q) {
  return {q.w, q.x, q.y, q.z};
}
template <std::size_t n>
Json json_of(const std::array<double, n>& values) {
  return values;
}
template <class Record>
Json json_of(const Record& record);
template <class Record>
Json json_of(const std::vector<Record>& list) {
  Json array = Json::array();
  for (const Record& one : list) array.push_back(json_of(one));
  return array;
}

class JsonWriter {
 public:
  explicit JsonWriter(Json& object) : object_(object) {}
  template <class T>
  void operator()(const char* name, const T& value) {
    object_[name] = json_of(value);
  }
  template <class T>
  void operator()(const char* name, const std::optional<T>& value) {
    if (value) object_[name] = json_of(*value);
  }
  template <class T>
  void or_default(const char* name, const T& value) {
    (*this)(name, value);
  }
  template <class T>
  void if_told(const std::optional<bool>& has, const char* name, const T& value) {
    if (has.value_or(false)) (*this)(name, value);
  }

 private:
  Json& object_;
};

template <class Record>
Json json_of(const Record& record) {
  Json object = Json::object();
  JsonWriter writer(object);
  fields(writer, record);
  return object;
}

template <class Record>
std::string text_of_message(const char* type, const Record& record) {
  Json object{{"type", type}};
  JsonWriter writer(object);
  fields(writer, record);
  return object.dump();
}

[[noreturn]] void refuse(const BridgePath& at, const std::string& message) {
  throw BridgeRefusal(at.text(), message);
}

void read(const Json& from, double& value, const BridgePath& at) {
  if (!from.is_number()) refuse(at, "expected a number");
  value = from.get<double>();
}
template <class Integer>
requires std::integral<Integer>
void read(const Json& from, Integer& value, const BridgePath& at) {
  using Limits = std::numeric_limits<Integer>;
  const bool fits =
      std::unsigned_integral<Integer>
          ? from.is_number_unsigned()
          : from.is_number_integer() &&
                (from.is_number_unsigned() ? from.get<std::uint64_t>() <= static_cast<std::uint64_t>(Limits::max())
                                           : from.get<std::int64_t>() >= static_cast<std::int64_t>(Limits::min()));
  if (!fits) refuse(at, "expected a whole number in range");
  value = from.get<Integer>();
}
void read(const Json& from, Time& time, const BridgePath& at) {
  read(from, time.ns, at);
}
template <std::size_t n>
void read(const Json& from, std::array<double, n>& values, const BridgePath& at) {
  if (!from.is_array() || from.size() != n) refuse(at, "expected " + std::to_string(n) + " numbers in a list");
  for (std::size_t i = 0; i < n; ++i) read(from[i], values[i], at);
}
void read(const Json& from, Vec3& v, const BridgePath& at) {
  std::array<double, 3> values{};
  read(from, values, at);
  v = {values[0], values[1], values[2]};
}
void read(const Json& from, Quat& q, const BridgePath& at) {
  std::array<double, 4> values{};
  read(from, values, at);
  q = {values[0], values[1], values[2], values[3]};
}
template <class Record>
void read(const Json& from, Record& record, const BridgePath& at);
template <class Record>
void read(const Json& from, std::vector<Record>& list, const BridgePath& at) {
  if (!from.is_array()) refuse(at, "expected a list");
  if (from.size() > most_of(list)) {
    refuse(at,
           "expected at most " + std::to_string(most_of(list)) + " in the list, found " + std::to_string(from.size()));
  }
  list.resize(from.size());
  for (std::size_t i = 0; i < list.size(); ++i) {
    read(from[i], list[i], BridgePath{at.parent, at.name, static_cast<std::ptrdiff_t>(i)});
  }
}

class JsonReader {
 public:
  JsonReader(const Json& object, const BridgePath& at) : object_(object), at_(at) {
    if (!object.is_object()) refuse(at, "expected an object");
  }
  template <class T>
  void operator()(const char* name, T& value) {
    const BridgePath at{&at_, name};
    const auto found = find(name);
    if (found == object_.end()) refuse(at, "this field is missing");
    read(*found, value, at);
  }
  template <class T>
  void operator()(const char* name, std::optional<T>& value) {
    value.reset();
    const auto found = find(name);
    if (found == object_.end() || found->is_null()) return;
    read(*found, value.emplace(), BridgePath{&at_, name});
  }
  template <class T>
  void or_default(const char* name, T& value) {
    const auto found = find(name);
    if (found != object_.end()) read(*found, value, BridgePath{&at_, name});
  }
  template <class T>
  void if_told(std::optional<bool>& has, const char* name, T& value) {
    const auto found = find(name);
    const bool is_there = found != object_.end();
    if (has.value_or(is_there) != is_there) {
      refuse({&at_, name}, "expected both of the rotation and the angular velocity, or neither");
    }
    has = is_there;
    if (is_there) read(*found, value, BridgePath{&at_, name});
  }
  /// Refuses fields that nobody asked for.
  void finish() const {
    if (object_.size() == taken_) return;
    for (const auto& [name, value] : object_.items()) {
      if (std::find(names_.begin(), names_.end(), name) == names_.end()) {
        const BridgePath at{&at_, name.c_str()};
        refuse(at, "there is no such field" + did_you_mean(name, names_));
      }
    }
  }

 private:
  Json::const_iterator find(const char* name) {
    names_.emplace_back(name);
    const auto found = object_.find(name);
    if (found != object_.end()) ++taken_;
    return found;
  }

  const Json& object_;
  const BridgePath& at_;
  std::vector<std::string> names_;  // of the fields
  std::size_t taken_ = 0;           // those that the object has
};

template <class Record>
void read(const Json& from, Record& record, const BridgePath& at) {
  JsonReader reader(from, at);
  fields(reader, record);
  reader.finish();
}

/// Refuses objects that no message has, while they are parsed.
class ObjectRule {
 public:
  bool operator()(int /*depth*/, Json::parse_event_t event, const Json& parsed) {
    if (event == Json::parse_event_t::object_start) open_.emplace_back();
    if (event == Json::parse_event_t::object_end) open_.pop_back();
    if (event == Json::parse_event_t::key) take(parsed.get<std::string>());
    return true;
  }

 private:
  void take(const std::string& key) {
    std::vector<std::string>& keys = open_.back();
    if (std::find(keys.begin(), keys.end(), key) != keys.end()) {
      throw BridgeRefusal(key, "expected each field once, found it twice in an object");
    }
    if (keys.size() == most_keys) {
      throw BridgeRefusal("", "expected at most " + std::to_string(most_keys) + " fields in an object");
    }
    keys.push_back(key);
  }

  static constexpr std::size_t most_keys = 20;
  std::vector<std::vector<std::string>> open_;  // the keys of each open object
};

/// The object without its type, which `type` becomes.
Json object_in(std::string_view text, std::string& type) {
  ObjectRule rule;
  Json object = Json::parse(text, std::ref(rule), false);
  if (object.is_discarded()) throw BridgeRefusal("", "expected JSON");
  if (!object.is_object()) throw BridgeRefusal("", "expected an object");
  const auto found = object.find("type");
  if (found == object.end() || !found->is_string()) throw BridgeRefusal("type", "expected a text");
  type = found->get<std::string>();
  object.erase(found);
  return object;
}

template <class Record>
Record record_in(const Json& object) {
  Record record;
  read(object, record, BridgePath{});
  return record;
}

}  // namespace

std::string to_text(const BridgeStep& step) {
  return text_of_message("step", step);
}

std::string to_text(const BridgeResult& result) {
  return text_of_message("result", result);
}

std::string to_text(const CouplingParameters& coupling) {
  return json_of(coupling).dump();
}

std::string to_text(const BridgeError& error) {
  const Json object{{"type", "error"}, {"message", error.message}, {"field", error.field}};
  return object.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::variant<BridgeNext, BridgeResult> read_client_message(std::string_view text) {
  std::string type;
  const Json object = object_in(text, type);
  if (type == "next") return BridgeNext{};
  if (type != "result") throw BridgeRefusal("type", "expected result or next");
  return record_in<BridgeResult>(object);
}

BridgeStep read_step(std::string_view text) {
  std::string type;
  const Json object = object_in(text, type);
  if (type != "step") throw BridgeRefusal("type", "expected step");
  return record_in<BridgeStep>(object);
}

}  // namespace tactor
