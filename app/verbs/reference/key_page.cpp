// The keys of graph files, from the schema that `tactor schema` prints, and of study files, from what their reader
// takes.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "app/study/spec/study_spec.hpp"
#include "app/verbs/reference/pages.hpp"
#include "framework/graph/plan.hpp"

namespace tactor {

namespace {

using Json = nlohmann::ordered_json;

/// Rows of the table: a row a key.
class KeyRows {
 public:
  KeyRows(const Json& schema, const PageWriter& page) : schema_(schema), page_(page) {}

  /// The keys of a map, and below each of them what its value may hold.
  void add_map(const Json& map, const std::string& prefix) {
    const auto properties = map.find("properties");
    if (properties != map.end()) {
      for (const auto& [key, value] : properties->items()) add_key(value, prefix.empty() ? key : prefix + "." + key);
    }
    const auto named = map.find("additionalProperties");
    if (named != map.end() && named->is_object())
      add_inside(*named, prefix + (map.contains("propertyNames") ? ".ARROW" : ".NAME"));
  }

  [[nodiscard]] const std::vector<std::vector<std::string>>& rows() const { return rows_; }

 private:
  void add_key(const Json& written, const std::string& path) {
    const Json& value = meant(written);
    // Alternatives may share a key, such as the jitter of costs.
    if (!seen_.insert(path).second) return;
    const std::string unit = value.value("unit", "");
    std::string doc = value.value("description", "");
    if (const std::string ending = " (unit " + unit + ")"; doc.ends_with(ending))
      doc.resize(doc.size() - ending.size());
    const auto usual = value.find("default");
    rows_.push_back({code_span(path), page_.text(type_of(value)), unit == "1" ? "" : page_.text(unit),
                     usual == value.end() ? "" : code_span(default_text(*usual)), page_.text(doc)});
    add_inside(value, path);
  }

  void add_inside(const Json& written, const std::string& path) {
    const Json& value = meant(written);
    add_map(value, path);
    const auto items = value.find("items");
    if (items != value.end() && items->is_object()) add_inside(*items, path + "[]");
    const auto alternatives = value.find("anyOf");
    if (alternatives == value.end()) return;
    for (const Json& one : *alternatives) {
      // A list of what may stand there alone says nothing new.
      const bool is_list_of_another = std::any_of(alternatives->begin(), alternatives->end(), [&](const Json& other) {
        return one.contains("items") && one["items"] == other;
      });
      if (!is_list_of_another) add_inside(one, path);
    }
  }

  /// What stands behind a reference, and without the null that only says that a value may be taken out.
  [[nodiscard]] const Json& meant(const Json& value) const {
    if (const auto reference = value.find("$ref"); reference != value.end()) {
      const std::string name = reference->get<std::string>();
      return schema_.at("$defs").at(name.substr(name.rfind('/') + 1));
    }
    const auto alternatives = value.find("anyOf");
    if (alternatives == value.end() || alternatives->size() != 2) return value;
    return (*alternatives)[1] == Json::object({{"type", "null"}}) ? meant((*alternatives)[0]) : value;
  }

  /// As a graph would say it.
  [[nodiscard]] static std::string default_text(const Json& value) {
    if (value.is_string()) return value.get<std::string>();
    if (value.is_number_float()) return fmt::format("{}", value.get<double>());
    if (!value.is_array()) return value.dump();
    std::string text;
    for (const Json& item : value) text += (text.empty() ? "" : ", ") + default_text(item);
    return "[" + text + "]";
  }

  [[nodiscard]] std::string type_of(const Json& value) const {
    if (value.contains("const"))
      return value["const"].is_string() ? value["const"].get<std::string>() : value["const"].dump();
    if (value.contains("enum")) {
      std::string words;
      // The node types have an index of their own.
      if (value["enum"].size() > 8) return "one of many";
      for (const Json& word : value["enum"]) words += (words.empty() ? "" : " | ") + word.get<std::string>();
      return words;
    }
    if (value.contains("anyOf") && value.contains("unit")) return "number";
    const auto type = value.find("type");
    if (type == value.end()) return value.contains("anyOf") ? "one of several" : "";
    if (type->is_array()) return (*type)[0] == "object" ? "map" : "text or list";
    if (*type == "string") return "text";
    if (*type == "object") return "map";
    if (*type == "array") {
      const std::string items = value.contains("items") ? type_of(value["items"]) : "";
      const std::string size = value.contains("maxItems") ? fmt::format("{} ", value["maxItems"].dump()) : "";
      return items == "number" ? "list of " + size + "numbers" : "list";
    }
    return type->get<std::string>();
  }

  const Json& schema_;
  const PageWriter& page_;
  std::vector<std::vector<std::string>> rows_;
  std::set<std::string> seen_;
};

}  // namespace

void add_key_page(const ReferenceSource& source, Pages& pages) {
  const Json schema = Json::parse(graph_schema(source.registry));
  PageWriter page("graph_keys.md", "Keys of graph and study files", source.types);
  page.prose("Look up a key of a graph or study file: what it takes, in which unit, and its default.");
  page.code("sh", "tactor schema > tactor.schema.json       # the same for an editor\n");
  page.markdown(
      fmt::format("{} tells with examples what they mean together. The parameters of nodes are on the pages of "
                  "their {}.",
                  page.link("Graph files", "graphs.md"), page.link("types", "nodes.md")));
  const std::vector<std::string> heads{"key", "takes", "unit", "default", "meaning"};
  page.heading(2, "Graph files");
  page.markdown(
      "A number may carry any unit of the same dimension; bare it is in the unit shown. `NAME` stands for a name of "
      "yours, `ARROW` for `from.output -> to.input`, `[]` for each item of a list.");
  KeyRows rows(schema, page);
  rows.add_map(schema, "");
  page.table(heads, rows.rows());

  page.heading(2, "Study files");
  page.markdown(fmt::format("{} tells how they work together.", page.link("Studies", "../howto/studies.md")));
  std::vector<std::vector<std::string>> studies;
  for (const StudyKey& key : keys_of_studies()) {
    studies.push_back(
        {code_span(key.name), page.text(key.value), key.unit, code_span(key.default_value), page.text(key.doc)});
  }
  page.table(heads, studies);
  page.put_into(pages);
}

}  // namespace tactor
