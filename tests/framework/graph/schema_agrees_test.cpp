// What the JSON Schema of graphs allows, the reader takes; what it forbids, the reader refuses.

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "framework/core/temporary_folder.hpp"
#include "framework/fields/write_fields.hpp"
#include "framework/graph/plan.hpp"
#include "framework/graph/readers.hpp"
#include "framework/graph/scene_fields.hpp"
#include "framework/node/registry.hpp"

BOOST_AUTO_TEST_SUITE(schema_agrees_test)

using namespace tactor;
using Json = nlohmann::ordered_json;

namespace {

/// Draws values that a schema allows; or, if it spoils, that are wrong in one place.
class Draw {
 public:
  Draw(std::uint32_t seed, std::string file, bool spoils) : dice_(seed), file_(std::move(file)), spoils_(spoils) {}

  Json value(const Json& schema) {
    if (schema.contains("const")) return schema["const"];
    if (schema.contains("anyOf")) return alternative(schema);
    if (schema.contains("enum")) return spoil() ? Json("no such word") : schema["enum"][below(schema["enum"].size())];
    const Json type = schema["type"].is_array() ? schema["type"][0] : schema["type"];
    if (type == "object") return object(schema);
    if (type == "array") return list(schema);
    if (type == "number") return number(schema, false);
    if (type == "integer") return number(schema, true);
    if (type == "boolean") return spoil() ? Json("maybe") : Json(below(2) == 1);
    BOOST_TEST_REQUIRE(type == "string");
    return spoil() ? Json::array({1}) : Json(file_);
  }
  /// Whether one place is wrong.
  [[nodiscard]] bool is_spoilt() const { return spoilt_; }

 private:
  std::size_t below(std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(dice_); }
  bool spoil() {
    if (!spoils_ || spoilt_ || below(8) != 0) return false;
    return spoilt_ = true;
  }
  Json alternative(const Json& schema) {
    std::vector<Json> real;
    for (const Json& one : schema["anyOf"]) {
      // Null takes a value out of the file that another extends.
      if (one.value("type", Json()) != "null") real.push_back(one);
    }
    const Json& one = real[below(real.size())];
    if (!one.contains("pattern")) return value(one);
    // A number with its unit; the bounds stand at the bare one.
    Json bare = number(real[0], false);
    const std::string unit = schema.value("unit", "1");
    return unit == "1" || !bare.is_number() ? bare : Json(bare.dump() + " " + unit);
  }
  Json object(const Json& schema) {
    if (spoil()) return Json("no map");
    Json drawn = Json::object();
    const Json none = Json::object();
    const Json& properties = schema.contains("properties") ? schema["properties"] : none;
    const Json required = schema.value("required", Json::array());
    if (schema.contains("maxProperties")) {
      const auto one = std::next(properties.begin(), static_cast<std::ptrdiff_t>(below(properties.size())));
      drawn[one.key()] = value(one.value());
      return drawn;
    }
    for (const auto& [key, inner] : properties.items()) {
      const bool needed = std::find(required.begin(), required.end(), key) != required.end();
      if (needed ? !spoil() : below(2) == 0) drawn[key] = value(inner);
    }
    if (schema["additionalProperties"].is_object()) {
      for (std::size_t i = 0; i < below(3); ++i) drawn["a" + std::to_string(i)] = value(schema["additionalProperties"]);
    } else if (spoil()) {
      drawn["no_such_key"] = 1;
    }
    return drawn;
  }
  Json list(const Json& schema) {
    if (spoil()) return Json("no list");
    Json drawn = Json::array();
    std::size_t size = schema.contains("minItems") ? schema["minItems"].get<std::size_t>() : 1 + below(3);
    if (schema.contains("minItems") && spoil()) ++size;
    for (std::size_t i = 0; i < size; ++i) drawn.push_back(value(schema["items"]));
    return drawn;
  }
  Json number(const Json& schema, bool whole) {
    const bool open = schema.contains("exclusiveMinimum");
    const bool low = open || schema.contains("minimum"), high = schema.contains("maximum");
    const double least = low ? schema[open ? "exclusiveMinimum" : "minimum"].get<double>() : -1e3;
    const double most = high ? schema["maximum"].get<double>() : std::max(least, 0.0) + 1e3;
    const auto as = [whole](double v) { return whole ? Json(static_cast<std::int64_t>(v)) : Json(v); };
    if (spoil()) {
      if (low && below(2) == 0) return as(open ? least : least - 1);
      return high ? as(most + 1) : Json("no number");
    }
    // At the bounds as often as between them.
    if (!open && low && below(4) == 0) return as(least);
    if (high && below(4) == 0) return as(most);
    const double drawn = least + (most - least) * std::uniform_real_distribution<double>(0.001, 1)(dice_);
    return as(whole ? std::ceil(drawn) : drawn);
  }

  std::mt19937 dice_;
  std::string file_;
  bool spoils_;
  bool spoilt_ = false;
};

/// Rules over several keys, which no schema says.
bool is_of_several_keys(const std::string& message) {
  for (const std::string_view text :
       {"expected one of mesh, sphere", "expected either", "expected low at or below", "a unit quaternion",
        "sum of the other two", "along different lines", "only a body with motion", "only a mesh has",
        "expected no mass", "a plane has no end", "above zero length", "scene.tool", "moving bodies",
        "expected it with policy", "of at least 1 ns", "of at most 1000000000"}) {
    if (message.find(text) != std::string::npos) return true;
  }
  return false;
}

/// The errors of the reader that the schema has to know too.
template <class Read>
std::vector<std::string> errors_of(const Json& drawn, const Read& read) {
  Diagnostics diagnostics;
  const auto tree = parse_yaml(drawn.dump(), "drawn.yaml", diagnostics);
  BOOST_TEST_REQUIRE(tree.has_value());
  read(*tree, diagnostics);
  std::vector<std::string> errors;
  for (const Diagnostic& one : diagnostics.list()) {
    if (!is_of_several_keys(one.message)) errors.push_back(one.message);
  }
  return errors;
}

template <class Read>
bool has_any_error(const Json& drawn, const Read& read) {
  Diagnostics diagnostics;
  read(*parse_yaml(drawn.dump(), "drawn.yaml", diagnostics), diagnostics);
  return diagnostics.any();
}

/// Draws by the schema under `key`, and reads.
template <class Read>
void check_agreement(const char* key, const Read& read) {
  Registry registry({});
  const Json schema = Json::parse(graph_schema(registry))["properties"][key];
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "mesh.off").string();
  std::ofstream(file) << "OFF\n";
  int spoilt = 0;
  for (std::uint32_t seed = 0; seed < 5000; ++seed) {
    for (const bool spoils : {false, true}) {
      Draw draw(seed, file, spoils);
      const Json drawn = draw.value(schema);
      const std::vector<std::string> errors = errors_of(drawn, read);
      spoilt += static_cast<int>(draw.is_spoilt());
      const std::string first = errors.empty() ? "nothing" : errors.front();
      BOOST_REQUIRE_MESSAGE(draw.is_spoilt() || errors.empty(),
                            first << ", for what the schema allows: " << drawn.dump());
      // A key that its neighbours make out of place is told alone.
      BOOST_REQUIRE_MESSAGE(!draw.is_spoilt() || !errors.empty() || has_any_error(drawn, read),
                            "nothing, for what the schema forbids: " << drawn.dump());
    }
  }
  BOOST_TEST(spoilt > 2500);
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_reader_takes_the_scenes_that_the_schema_allows_and_no_others) {
  const FileFinder files{std::filesystem::path()};
  check_agreement("scene", [&](const Tree& tree, Diagnostics& diagnostics) { read_scene(tree, files, diagnostics); });
}

BOOST_AUTO_TEST_CASE(the_reader_takes_the_live_settings_that_the_schema_allows_and_no_others) {
  const FileFinder files{std::filesystem::path()};
  check_agreement("live", [&](const Tree& tree, Diagnostics& diagnostics) { read_live(tree, files, diagnostics); });
}

BOOST_AUTO_TEST_CASE(a_scene_that_is_written_reads_back_the_same) {
  Registry registry({});
  const Json schema = Json::parse(graph_schema(registry))["properties"]["scene"];
  const FileFinder files{std::filesystem::path()};
  int written = 0;
  for (std::uint32_t seed = 0; seed < 2000; ++seed) {
    Diagnostics diagnostics;
    const auto read = [&](const std::string& text) {
      return read_scene(*parse_yaml(text, "drawn.yaml", diagnostics), files, diagnostics);
    };
    const Scene scene = read(Draw(seed, __FILE__, false).value(schema).dump());
    if (diagnostics.any()) continue;
    ++written;
    const std::string text = FieldWriter::text(scene);
    const Scene again = read(text);
    BOOST_REQUIRE_MESSAGE(!diagnostics.any(), text);
    BOOST_REQUIRE(again.gravity_W == scene.gravity_W);
    BOOST_REQUIRE(again.camera == scene.camera);
    BOOST_REQUIRE(again.tool_name == scene.tool_name);
    BOOST_REQUIRE(again.bodies.size() == scene.bodies.size());
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      const Body &a = scene.bodies[i], &b = again.bodies[i];
      BOOST_REQUIRE(b.name == a.name);
      BOOST_REQUIRE(b.shape == a.shape);
      BOOST_REQUIRE(b.X_WB == a.X_WB);
      BOOST_REQUIRE(b.motion == a.motion);
      BOOST_REQUIRE(b.material == a.material);
      if (a.motion == Motion::deformable) BOOST_REQUIRE(b.deformable.fixed == a.deformable.fixed);
      if (a.motion == Motion::deformable) BOOST_REQUIRE(b.deformable.inclusions == a.deformable.inclusions);
      if (a.motion != Motion::deformable) BOOST_REQUIRE(b.mass == a.mass);
      if (a.motion != Motion::deformable) BOOST_REQUIRE(b.inertia == a.inertia);
    }
  }
  BOOST_TEST(written > 100);
}

BOOST_AUTO_TEST_SUITE_END()
