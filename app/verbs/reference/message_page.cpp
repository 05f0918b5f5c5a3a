// The page of message types, made of their descriptions.
#include <fmt/format.h>

#include "app/verbs/reference/pages.hpp"
#include "framework/core/message.hpp"
#include "framework/core/message_json.hpp"

namespace tactor {

namespace {

/// `f64`, `f64 [3]`, `u8 [any number]`, `good = 0, dusty = 1`.
std::string field_kind(const Field& field, const PageWriter& page) {
  std::string text = field.kind == FieldKind::record ? page.text(field.record) : std::string(name_of(field.kind));
  if (!field.shape.empty()) text += fmt::format(" \\[{}\\]", fmt::join(field.shape, " × "));
  if (field.changes_size) text += ", any number";
  return text;
}

std::string enumerators(const Field& field) {
  std::string text;
  for (const Enumerator& value : field.enumerators) {
    text += (text.empty() ? "" : ", ") + code_span(value.name) + fmt::format(" = {}", value.value);
  }
  return text;
}

/// The fields, those of a record behind its own name: `contacts.p_WC`.
void add_fields(const std::vector<Field>& fields, const std::string& prefix, const std::string& frame,
                const PageWriter& page, std::vector<std::vector<std::string>>& rows) {
  for (const Field& field : fields) {
    const std::string in = field.frame.empty() ? frame : field.frame;
    const bool is_record = field.kind == FieldKind::record;
    const bool is_vector = !field.shape.empty() || !field.frame.empty();
    rows.push_back({code_span(prefix + field.name), field_kind(field, page),
                    is_record || field.unit == "1" ? "" : page.text(field.unit), is_record || !is_vector ? "" : in,
                    enumerators(field), page.text(field.doc)});
    if (is_record) add_fields(field.fields, prefix + field.name + ".", in, page, rows);
  }
}

/// `cause` is `stale`: No fresh segment has come for too long. An item for each value that has a doc.
void add_values(const std::vector<Field>& fields, const std::string& prefix, const PageWriter& page,
                std::vector<std::string>& items) {
  for (const Field& field : fields) {
    for (const Enumerator& value : field.enumerators) {
      if (value.doc.empty()) continue;
      items.push_back(code_span(prefix + field.name) + " is " + code_span(value.name) + ": " + page.text(value.doc));
    }
    add_values(field.fields, prefix + field.name + ".", page, items);
  }
}

/// The node types that have the message at a port, linked.
std::string ports_of(const std::string& message, bool outputs, const ReferenceSource& source, const PageWriter& page) {
  std::string text;
  for (const NodeInfo* info : source.registry.types()) {
    bool has = false;
    if (outputs) {
      for (const OutputInfo& output : info->outputs) has = has || output.type->name == message;
    } else {
      for (const InputInfo& input : info->inputs) has = has || input.type->name == message;
    }
    if (has) text += (text.empty() ? "" : ", ") + page.text(info->type);
  }
  return text;
}

}  // namespace

void add_message_page(const ReferenceSource& source, Pages& pages) {
  PageWriter page("message_types.md", "Message types", source.types);
  page.prose("Look up what the messages between nodes hold: fields with units, frames and meaning.");
  page.code("sh", "tactor schema --messages        # the same as JSON, of all installed libraries\n");
  page.markdown(fmt::format(
      "A field that shows no unit is a plain number. `ns` is a time. Vectors are expressed in the frame that the table "
      "shows: W is the world. The layout hash covers names, units, frames and kinds, but not the meaning; two types of "
      "one hash hold the same bytes. {} tells how to describe a type of your own.",
      page.link("Messages", "messages.md")));
  page.prose(
      "Each message also has three stamps. `valid` is the time of the run that it holds for, `produced` the time from "
      "which its readers see it. `sequence` counts the messages of its output from 0.");
  for (const auto& [name, type] : source.registry.message_types()) {
    if (type == &any_message()) continue;
    page.heading(2, name);
    page.prose(type->doc);
    std::vector<std::vector<std::string>> rows;
    add_fields(type->fields, "", type->frame, page, rows);
    page.table({"field", "kind", "unit", "frame", "values", "meaning"}, rows);
    std::vector<std::string> values;
    add_values(type->fields, "", page, values);
    page.list(values);
    page.markdown(fmt::format("{} bytes, layout hash `{:016x}`.", type->size, type->layout_hash));
    std::vector<std::string> items;
    const std::string senders = ports_of(name, true, source, page), readers = ports_of(name, false, source, page);
    if (!senders.empty()) items.push_back("Sent by " + senders);
    if (!readers.empty()) items.push_back("Read by " + readers);
    page.list(items);
  }
  page.put_into(pages);
}

}  // namespace tactor
