// Both encodings of the bridge's messages hold the same, and refuse what is wrong with the field's name.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>

#include "app/bridge/bridge_json.hpp"
#include "app/bridge/bridge_packed.hpp"

BOOST_AUTO_TEST_SUITE(bridge_codec_test)

using namespace tactor;
using nlohmann::json;

namespace {

constexpr std::size_t listed = 3;

/// Gives every number of a record another value; rotations and normals are of unit length.
struct Filler {
  double next = 0.1;
  double number() { return next = std::fmod(next * 1.7 + 0.3, 1.0) + 1e-3; }
  void operator()(const char*, std::uint64_t& value) { value = 7; }
  void operator()(const char*, std::int32_t& value) { value = 1; }
  void operator()(const char*, double& value) { value = number(); }
  void operator()(const char*, Time& value) { value = {static_cast<std::int64_t>(number() * 1e9)}; }
  void operator()(const char* name, Vec3& v) {
    v = {number(), number(), -number()};
    if (std::string(name) == "n_W") v = v / norm(v);
  }
  void operator()(const char*, Quat& q) { q = normalized({number(), number(), -number(), number()}); }
  void operator()(const char*, std::array<double, 6>& values) {
    for (double& value : values) value = number();
  }
  template <class T>
  void operator()(const char* name, std::optional<T>& value) {
    (*this)(name, value.emplace());
  }
  template <class Record>
  void operator()(const char*, std::vector<Record>& list) {
    list.resize(listed);
    for (Record& one : list) fields(*this, one);
  }
  template <class Record>
  requires(!IsPlain<Record>) void operator()(const char*, Record& record) { fields(*this, record); }
  template <class T>
  void or_default(const char* name, T& value) {
    (*this)(name, value);
  }
  template <class T>
  void if_told(std::optional<bool>& has, const char* name, T& value) {
    has = true;
    (*this)(name, value);
  }
};

template <class Record>
Record filled() {
  Record record;
  Filler filler;
  fields(filler, record);
  return record;
}

BridgeResult result_in(const std::variant<BridgeNext, BridgeResult>& message) {
  return std::get<BridgeResult>(message);
}

/// The field and the message of the refusal; "nothing" where there is none.
std::pair<std::string, std::string> refusal(const std::function<void()>& work) {
  try {
    work();
  } catch (const BridgeRefusal& error) {
    return {error.field(), error.what()};
  }
  return {"nothing", "nothing"};
}

std::string refused_field(const json& message) {
  return refusal([&] { static_cast<void>(read_client_message(message.dump())); }).first;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_result_is_the_same_in_both_encodings_to_the_last_bit) {
  const auto result = filled<BridgeResult>();
  const BridgeResult by_text = result_in(read_client_message(to_text(result)));
  const BridgeResult by_bytes = result_in(read_client_bytes(to_bytes(result)));
  BOOST_TEST(to_bytes(by_text) == to_bytes(result));
  BOOST_TEST(to_bytes(by_bytes) == to_bytes(result));
  BOOST_TEST(to_text(by_bytes) == to_text(result));
  BOOST_TEST(by_text.contacts->size() == listed);
}

BOOST_AUTO_TEST_CASE(a_step_is_the_same_in_both_encodings_to_the_last_bit) {
  const auto step = filled<BridgeStep>();
  BOOST_TEST(to_bytes(read_step(to_text(step))) == to_bytes(step));
  BOOST_TEST(to_text(read_step_bytes(to_bytes(step))) == to_text(step));
}

BOOST_AUTO_TEST_CASE(fields_that_are_not_given_stay_empty) {
  BridgeResult result = filled<BridgeResult>();
  result.felt.reset();
  result.contacts.reset();
  for (const BridgeResult& read :
       {result_in(read_client_message(to_text(result))), result_in(read_client_bytes(to_bytes(result)))}) {
    BOOST_TEST(!read.felt.has_value());
    BOOST_TEST(!read.contacts.has_value());
    BOOST_TEST(read.contact.has_value());
    BOOST_TEST(read.bodies->size() == listed);
  }
}

BOOST_AUTO_TEST_CASE(packed_numbers_lie_where_the_layout_has_them) {
  const auto step = filled<BridgeStep>();
  const std::string bytes = to_bytes(step);
  const json layout = json::parse(packed_layouts())["step"];
  const json text = json::parse(to_text(step));
  BOOST_TEST(layout["bytes"] == bytes.size());
  BOOST_TEST(bytes[0] == layout["kind"].get<char>());
  std::size_t looked_at = 0;
  for (const json& field : layout["fields"]) {
    const std::string name = field["name"];
    std::string pointer = "/" + name;
    std::replace(pointer.begin(), pointer.end(), '.', '/');
    const json& value = text.at(json::json_pointer(pointer));
    const char* at = bytes.data() + field["offset"].get<std::size_t>();
    for (std::size_t i = 0; i < field["count"]; ++i, ++looked_at) {
      const json& number = value.is_array() ? value[i] : value;
      if (field["type"] == "f64") {
        double found = 0;
        std::memcpy(&found, at + 8 * i, 8);
        BOOST_TEST(found == number.get<double>(), name);
      } else {
        std::int64_t found = 0;
        std::memcpy(&found, at + 8 * i, 8);
        BOOST_TEST(found == number.get<std::int64_t>(), name);
      }
    }
  }
  BOOST_TEST(looked_at == 3 + 2 * 14 + 7);
}

BOOST_AUTO_TEST_CASE(a_refusal_of_a_text_names_the_field) {
  const json good = json::parse(to_text(filled<BridgeResult>()));
  BOOST_TEST(refused_field(good) == "nothing");
  const auto changed = [&good](const std::string& pointer, const json& value) {
    json text = good;
    text[json::json_pointer(pointer)] = value;
    return refused_field(text);
  };
  BOOST_TEST(changed("/tool/p_WT/1", "x") == "tool.p_WT");
  BOOST_TEST(changed("/tool/p_WT", {1, 2}) == "tool.p_WT");
  BOOST_TEST(changed("/tool", 1) == "tool");
  BOOST_TEST(changed("/id", -1) == "id");
  BOOST_TEST(changed("/id", 1.5) == "id");
  BOOST_TEST(changed("/tol", 1) == "tol");
  BOOST_TEST(changed("/contacts/1/n_W", {0, 0}) == "contacts[1].n_W");
  BOOST_TEST(changed("/contacts/2/other", 0.5) == "contacts[2].other");
  BOOST_TEST(changed("/contacts/2/body", 5'000'000'000) == "contacts[2].body");
  BOOST_TEST(changed("/contacts/0/pushes", 1) == "contacts[0].pushes");
  BOOST_TEST(changed("/bodies", 1) == "bodies");
  BOOST_TEST(changed("/bodies/0/p_WB", 1) == "bodies[0].p_WB");
  BOOST_TEST(changed("/type", "results") == "type");
  BOOST_TEST(changed("/contacts", json(10'000, good["contacts"][0])) == "contacts");
  json without = good;
  without["tool"].erase("v_WT");
  BOOST_TEST(refused_field(without) == "tool.v_WT");
  without = good;
  for (const char* name : {"p_TC", "H_W", "body", "other", "weight", "inertia", "creep", "lift"}) {
    without["contacts"][0].erase(name);
  }
  for (const char* name : {"R_WT", "w_WT"}) without["tool"].erase(name);
  BOOST_TEST(refused_field(without) == "nothing");
  const BridgeResult read = result_in(read_client_message(without.dump()));
  BOOST_TEST(read.contacts->front().contact.weight == 1.0);
  BOOST_TEST(read.contacts->front().pair.other == ContactPair::fixed);
  BOOST_TEST((read.tool->X_WT.R == Quat{}));
  BOOST_TEST(!read.tool->has_rotation.value_or(true));
  BOOST_TEST(!read.contacts->front().has_p_TC.value_or(true));
  BOOST_TEST(read.contacts->back().has_p_TC.value_or(false));
  // Bytes leave the same out.
  const BridgeResult again = result_in(read_client_bytes(to_bytes(read)));
  BOOST_TEST(to_text(again) == to_text(read));
  BOOST_TEST(!json::parse(to_text(again))["tool"].contains("R_WT"));
}

BOOST_AUTO_TEST_CASE(a_rotation_is_told_whole_or_not_at_all) {
  const json good = json::parse(to_text(filled<BridgeResult>()));
  for (const char* name : {"R_WT", "w_WT"}) {
    json half = good;
    half["tool"].erase(name);
    BOOST_TEST(refused_field(half) == "tool.w_WT");
  }
  json half = good;
  half["bodies"][1].erase("R_WB");
  BOOST_TEST(refused_field(half) == "bodies[1].w_WB");
}

BOOST_AUTO_TEST_CASE(objects_are_bounded_while_they_are_read) {
  json many = json::parse(to_text(filled<BridgeResult>()));
  for (int i = 0; i < 21; ++i) many["tool"]["x" + std::to_string(i)] = 0;
  const auto [field, why] = refusal([&] { static_cast<void>(read_client_message(many.dump())); });
  BOOST_TEST(field == "");
  BOOST_TEST(why.find("at most 20 fields") != std::string::npos);
  const char* twice =
      R"({"type": "result", "id": 1, "tool": {"p_WT": [0, 0, 0], "v_WT": [0, 0, 0], "v_WT": [1, 0, 0]}})";
  BOOST_TEST(refusal([&] { static_cast<void>(read_client_message(twice)); }).first == "v_WT");
  // The same name in another object is another field.
  const char* once = R"({"type": "result", "id": 1, "felt": {"force": [0, 0, 0], "torque": [0, 0, 0]},
                         "contact": {"force": [0, 0, 0], "torque": [0, 0, 0]}})";
  BOOST_TEST(refusal([&] { static_cast<void>(read_client_message(once)); }).first == "nothing");
}

BOOST_AUTO_TEST_CASE(what_is_no_message_is_refused) {
  for (const char* text : {"", "{", "[]", "1", "{}", R"({"type": 1})", R"({"type": "result", "id": NaN})"}) {
    BOOST_TEST_CONTEXT(text) {
      BOOST_TEST(refusal([text] { static_cast<void>(read_client_message(text)); }).first != "nothing");
    }
  }
}

BOOST_AUTO_TEST_CASE(bytes_of_any_other_length_are_refused) {
  const std::string bytes = to_bytes(filled<BridgeResult>());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    BOOST_TEST_CONTEXT(size) {
      BOOST_TEST(refusal([&] { static_cast<void>(read_client_bytes(bytes.substr(0, size))); }).first != "nothing");
    }
  }
  BOOST_TEST(refusal([&] { static_cast<void>(read_client_bytes(bytes + '\0')); }).first != "nothing");
}

BOOST_AUTO_TEST_CASE(a_count_beyond_the_bytes_asks_for_no_memory) {
  BridgeResult result = filled<BridgeResult>();
  result.contacts.reset();
  result.bodies.reset();
  std::string bytes = to_bytes(result);
  const json layout = json::parse(packed_layouts())["result"];
  for (const json& field : layout["fields"]) {
    const std::string name = field["name"];
    if (name != "contacts" && name != "bodies") continue;
    std::string changed = bytes;
    const std::uint32_t given = 0x3f;
    const std::uint64_t many = ~std::uint64_t{0}, one = 1;
    std::memcpy(changed.data() + field["offset"].get<std::size_t>(), &one, 8);
    BOOST_TEST(refusal([&] { static_cast<void>(read_client_bytes(changed)); }).first == name);
    std::memcpy(changed.data() + 4, &given, 4);
    BOOST_TEST(refusal([&] { static_cast<void>(read_client_bytes(changed)); }).first == "");
    std::memcpy(changed.data() + field["offset"].get<std::size_t>(), &many, 8);
    BOOST_TEST(refusal([&] { static_cast<void>(read_client_bytes(changed)); }).first == name);
  }
  bytes[4] = 0x7f;
  BOOST_TEST(refusal([&] { static_cast<void>(read_client_bytes(bytes)); }).first == "given");
}

BOOST_AUTO_TEST_CASE(a_packed_index_out_of_range_is_refused) {
  BridgeResult result = filled<BridgeResult>();
  std::string bytes = to_bytes(result);
  const json layouts = json::parse(packed_layouts());
  for (const json& field : layouts["contact"]["fields"]) {
    if (field["name"] != "body") continue;
    const std::int64_t far = std::int64_t{1} << 32U;
    std::memcpy(bytes.data() + layouts["result"]["bytes"].get<std::size_t>() + field["offset"].get<std::size_t>(), &far,
                8);
  }
  BOOST_TEST(refusal([&] { static_cast<void>(read_client_bytes(bytes)); }).first == "body");
}

BOOST_AUTO_TEST_CASE(next_is_read_in_both_encodings) {
  BOOST_TEST(std::holds_alternative<BridgeNext>(read_client_message(R"({"type": "next"})")));
  BOOST_TEST(std::holds_alternative<BridgeNext>(read_client_bytes(std::string("\4\0\0\0", 4))));
}

BOOST_AUTO_TEST_SUITE_END()
