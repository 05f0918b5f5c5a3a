#include "app/flight/flight_text.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <map>
#include <nlohmann/json.hpp>

#include "app/csv_cell.hpp"
#include "framework/core/messages.hpp"
#include "framework/graph/text_table.hpp"
#include "framework/realtime/safety_gate.hpp"
#include "framework/record/csv_columns.hpp"

namespace tactor {

namespace {

using FlightJson = nlohmann::ordered_json;

constexpr std::size_t ticks_shown_before = 12, ticks_shown_after = 8;

/// The kinds whose records have numbers, with their names.
struct NumberedKind {
  FlightKind kind;
  const char* name;
  const MessageType& type;
};
const std::array<NumberedKind, 3>& numbered_kinds() {
  static const std::array<NumberedKind, 3> kinds{{{FlightKind::tick, "tick", message_type<FlightTick>()},
                                                  {FlightKind::device, "device", message_type<FlightDevice>()},
                                                  {FlightKind::exchange, "exchange", message_type<FlightExchange>()}}};
  return kinds;
}

const NumberedKind* numbered(FlightKind kind) {
  for (const NumberedKind& one : numbered_kinds()) {
    if (one.kind == kind) return &one;
  }
  return nullptr;
}

template <class Number>
double number_at(const FlightRecord& record, std::size_t offset) {
  Number number{};
  std::memcpy(&number, record.body.data() + offset, sizeof number);
  return static_cast<double>(number);
}

/// A number of a record; its types have these kinds of numbers alone.
double number_of(const FlightRecord& record, FieldKind kind, std::size_t offset) {
  switch (kind) {
    case FieldKind::u8:
      return number_at<std::uint8_t>(record, offset);
    case FieldKind::u32:
      return number_at<std::uint32_t>(record, offset);
    default:
      return number_at<float>(record, offset);
  }
}

std::string date_text(std::int64_t unix_ns) {
  return fmt::format("{:%F %T UTC}", fmt::gmtime(static_cast<std::time_t>(unix_ns / 1'000'000'000)));
}

/// The records by their time, and the words of events in the place of their first part.
struct FlightRow {
  Time time;
  const FlightRecord* record = nullptr;  // null: of an event
  const FlightWords* words = nullptr;
};
std::vector<FlightRow> rows_of(const FlightLog& log, const std::vector<FlightWords>& events) {
  std::vector<FlightRow> rows;
  for (const FlightRecord& record : log.records) {
    if (numbered(record.kind) != nullptr) rows.push_back({log.time_of(record), &record, nullptr});
  }
  for (const FlightWords& words : events) rows.push_back({words.time, nullptr, &words});
  std::stable_sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  return rows;
}

std::string ending_of(const FlightSource& source) {
  if (source.is_running) return "the run goes on";
  switch (source.log.end) {
    case FlightEnd::well:
      return "the run ended well";
    case FlightEnd::failed:
      return "the run failed";
    default:
      return "the process ended without a word";
  }
}

double length_of(const FlightVector& v) {
  return std::sqrt(static_cast<double>(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]));
}

/// A number with so many decimals; empty where it is not finite.
std::string cell_of(double value, int decimals) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals) : "";
}

/// The device whose last moments are shown: that of the fault, else the first.
std::size_t shown_device(const FlightLog& log, const std::vector<FlightFinding>& findings) {
  std::size_t first = log.nodes.size();
  for (const FlightRecord& record : log.records) {
    if (record.kind != FlightKind::device) continue;
    if (!findings.empty() && log.name_of(record.node) == findings.front().node) return record.node;
    first = std::min<std::size_t>(first, record.node);
  }
  return first;
}

std::string ticks_table(const FlightLog& log, const std::vector<FlightFinding>& findings, std::size_t columns) {
  const std::size_t device = shown_device(log, findings);
  std::vector<const FlightRecord*> ticks;
  for (const FlightRecord& record : log.records) {
    if (record.kind == FlightKind::device && record.node == device) ticks.push_back(&record);
  }
  if (ticks.empty()) return {};
  const Time around = findings.empty() ? log.last() : findings.front().time;
  const auto at = std::find_if(ticks.begin(), ticks.end(), [&](const auto* one) { return log.time_of(*one) > around; });
  const auto before = static_cast<std::size_t>(at - ticks.begin());
  const std::size_t from = before > ticks_shown_before ? before - ticks_shown_before : 0;
  const std::size_t to = std::min(ticks.size(), std::max(before, from) + ticks_shown_after);
  using Align = TextTable::Align;
  TextTable table({{"s", Align::right},
                   {"wanted N", Align::right},
                   {"given N", Align::right},
                   {"gate"},
                   {"cause"},
                   {"late us", Align::right},
                   {"step us", Align::right},
                   {"result ms", Align::right},
                   {"sample ms", Align::right}});
  for (std::size_t i = from; i < to; ++i) {
    const auto tick = body_of<FlightDevice>(*ticks[i]);
    table.add(
        {cell_of(log.time_of(*ticks[i]).seconds(), 4), cell_of(length_of(tick.wanted_force), 3),
         cell_of(length_of(tick.commanded_force), 3), std::string(name_of(static_cast<Engagement>(tick.engagement))),
         std::string(name_of(static_cast<SafetyCause>(tick.cause))), cell_of(tick.lateness_s * 1e6, 0),
         cell_of(tick.body_s * 1e6, 0), cell_of(tick.result_age_s * 1e3, 1), cell_of(tick.sample_age_s * 1e3, 1)});
  }
  return fmt::format("\nticks of {} round {:.3f} s\n", log.nodes[device].name, around.seconds()) + table.text(columns);
}

FlightJson json_of(const FlightFinding& finding) {
  return {{"fault", name_of(finding.fault)}, {"node", finding.node},           {"time_s", finding.time.seconds()},
          {"ended_run", finding.ended_run},  {"cut_force", finding.cut_force}, {"words", finding.words}};
}

/// The field's numbers: one, or a list.
FlightJson json_of(const FlightRecord& record, const Field& field) {
  const std::size_t count = count_of(field);
  FlightJson list = FlightJson::array();
  for (std::size_t i = 0; i < count; ++i) {
    const double value = number_of(record, field.kind, field.offset + i * element_size(field));
    list.push_back(std::isfinite(value) ? FlightJson(value) : FlightJson(nullptr));
  }
  return field.shape.empty() ? list.front() : list;
}

}  // namespace

std::string fault_line(const FlightFinding& finding) {
  const std::string whose = finding.node.empty() ? "the process" : "node " + finding.node;
  return fmt::format("{}, {}, {:.3f} s: {}", name_of(finding.fault), whose, finding.time.seconds(), finding.words);
}

std::string flight_text(const FlightSource& source, const std::vector<FlightFinding>& findings, std::size_t columns) {
  const FlightLog& log = source.log;
  std::string text = findings.empty() ? "nothing went wrong" : fault_line(findings.front());
  text +=
      fmt::format("\n\n{}: {}, process {}, {} {}, tactor {}; {}\n", source.path.string(), log.graph, log.process,
                  log.has_begun ? "begun" : "not begun, made", date_text(log.unix_ns), log.version, ending_of(source));
  text += fmt::format("{} records from {:.3f} s to {:.3f} s, {} torn\n", log.records.size(), log.first().seconds(),
                      log.last().seconds(), log.torn);
  if (findings.size() > 1) text += "\nalso found\n";
  for (std::size_t i = 1; i < findings.size(); ++i) text += "  " + fault_line(findings[i]) + "\n";
  return wrapped(text, columns) + ticks_table(log, findings, columns);
}

void write_flight_json(const FlightSource& source, const std::vector<FlightFinding>& findings, std::ostream& out) {
  const FlightLog& log = source.log;
  FlightJson first{{"fault", findings.empty() ? FlightJson(nullptr) : json_of(findings.front())},
                   {"file", source.path.string()},
                   {"graph", log.graph},
                   {"process", log.process},
                   {"has_begun", log.has_begun},
                   {"begun", date_text(log.unix_ns)},
                   {"begun_unix_s", static_cast<double>(log.unix_ns) * 1e-9},
                   {"tactor", log.version},
                   {"ending", ending_of(source)},
                   {"from_s", log.first().seconds()},
                   {"to_s", log.last().seconds()},
                   {"records", log.records.size()},
                   {"torn", log.torn},
                   {"findings", FlightJson::array()}};
  for (const FlightFinding& finding : findings) first["findings"].push_back(json_of(finding));
  // A sentence of a device may have bytes that are no UTF-8.
  const auto write = [&out](const FlightJson& json) {
    out << json.dump(-1, ' ', false, FlightJson::error_handler_t::replace) << '\n';
  };
  write(first);
  const std::vector<FlightWords> events = log.events();
  for (const FlightRow& row : rows_of(log, events)) {
    FlightJson json{{"time_s", row.time.seconds()}};
    if (row.record == nullptr) {
      json.update({{"node", log.name_of(row.words->node)}, {"kind", name_of(row.words->event)}});
      json["words"] = row.words->words;
    } else {
      const NumberedKind& kind = *numbered(row.record->kind);
      json["node"] = log.name_of(row.record->node);
      json["kind"] = kind.name;
      for (const Field& field : kind.type.fields) json[field.name] = json_of(*row.record, field);
    }
    write(json);
  }
}

void write_flight_csv(const FlightLog& log, std::ostream& out) {
  // Kinds share the columns that have the same heading.
  std::vector<std::string> headings;
  std::map<std::string, std::size_t> column_of;
  std::map<FlightKind, std::vector<CsvValue>> values;
  for (const NumberedKind& kind : numbered_kinds()) {
    values[kind.kind] = csv_values(kind.type);
    for (const CsvValue& value : values[kind.kind]) {
      if (column_of.try_emplace(value.heading, headings.size()).second) headings.push_back(value.heading);
    }
  }
  out << "time [s],node,kind,words";
  for (const std::string& heading : headings) out << ',' << csv_cell(heading);
  out << '\n';
  const std::vector<FlightWords> events = log.events();
  for (const FlightRow& row : rows_of(log, events)) {
    std::vector<std::string> cells(headings.size());
    const bool is_event = row.record == nullptr;
    const std::uint16_t node = is_event ? row.words->node : row.record->node;
    out << csv_cell(row.time.seconds()) << ',' << csv_cell(log.name_of(node)) << ','
        << (is_event ? name_of(row.words->event) : numbered(row.record->kind)->name) << ','
        << (is_event ? csv_cell(row.words->words) : "");
    if (!is_event) {
      for (const CsvValue& value : values[row.record->kind]) {
        cells[column_of[value.heading]] = csv_cell(number_of(*row.record, value.field->kind, value.offset));
      }
    }
    for (const std::string& cell : cells) out << ',' << cell;
    out << '\n';
  }
}

}  // namespace tactor
