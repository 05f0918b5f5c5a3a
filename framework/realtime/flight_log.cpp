#include "framework/realtime/flight_log.hpp"

#include <algorithm>
#include <cstdlib>
#include <map>
#include <sstream>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream text(line);
  for (std::string cell; std::getline(text, cell, '\t');) cells.push_back(cell);
  return cells;
}

void read_names(const std::string& names, FlightLog& log) {
  std::istringstream text(names);
  for (std::string line; std::getline(text, line);) {
    const std::vector<std::string> cells = cells_of(line);
    const auto is = [&cells](const char* word, std::size_t count) { return cells.size() == count && cells[0] == word; };
    if (is("graph", 2)) {
      log.graph = cells[1];
    } else if (is("node", 4)) {
      log.nodes.push_back({cells[1], cells[2], std::atof(cells[3].c_str()), {}});
    } else if (is("in", 4) && !log.nodes.empty()) {
      log.nodes.back().inputs.push_back({cells[1], cells[2], cells[3] == "OUTER"});
    } else {
      throw InputError("expected the names of a run in its header, found '" + line + "'");
    }
  }
}

/// The whole records by their sequence, and how many are torn.
void read_records(std::string_view bytes, const FlightHeader& header, FlightLog& log) {
  for (std::uint64_t place = 0; place < header.capacity; ++place) {
    FlightRecord record;
    std::memcpy(static_cast<void*>(&record), bytes.data() + header.records_at + place * sizeof record, sizeof record);
    const bool is_empty = record.kind == FlightKind::none && record.checksum == 0 && record.time_ns == 0;
    if (is_empty) continue;
    if (record.checksum != checksum_of(record) || record.sequence % header.capacity != place) {
      ++log.torn;
    } else {
      log.records.push_back(record);
    }
  }
  std::sort(log.records.begin(), log.records.end(),
            [](const FlightRecord& a, const FlightRecord& b) { return a.sequence < b.sequence; });
}

}  // namespace

std::string flight_names(const std::string& graph, const std::vector<FlightNode>& nodes) {
  std::string text = "graph\t" + graph + "\n";
  for (const FlightNode& node : nodes) {
    text += "node\t" + node.name + "\t" + node.type + "\t" + std::to_string(node.rate_hz) + "\n";
    for (const FlightNode::In& in : node.inputs) {
      text += "in\t" + in.from + "\t" + in.port + "\t" + (in.is_outer ? "OUTER" : "INNER") + "\n";
    }
  }
  return text;
}

FlightLog read_flight(std::string_view bytes) {
  FlightHeader header;
  if (bytes.size() < sizeof header) throw InputError("expected a flight file, found one that is too short");
  std::memcpy(static_cast<void*>(&header), bytes.data(), sizeof header);
  const std::string_view texts = bytes.substr(sizeof header);
  const std::string wrong = fault_of(header, texts.substr(0, header.layout_bytes), bytes.size());
  if (!wrong.empty()) throw InputError(wrong);
  FlightLog log;
  log.version.assign(header.version.data(), strnlen(header.version.data(), header.version.size()));
  log.process = static_cast<long>(header.process);
  log.end = header.end;
  // A run that never began counts from when its ring was made.
  log.origin_ns = header.origin_ns != 0 ? header.origin_ns : header.made_ns;
  log.has_begun = header.origin_ns != 0;
  log.unix_ns = header.unix_ns + (log.origin_ns - header.made_ns);
  read_names(std::string(texts.substr(header.layout_bytes, header.names_bytes)), log);
  read_records(bytes, header, log);
  return log;
}

Time FlightLog::last() const {
  Time last;
  for (const FlightRecord& record : records) last = std::max(last, time_of(record));
  return last;
}

Time FlightLog::first() const {
  Time first = last();
  for (const FlightRecord& record : records) first = std::min(first, time_of(record));
  return first;
}

std::string FlightLog::name_of(std::uint16_t node) const {
  return node < nodes.size() ? nodes[node].name : "";
}

std::vector<FlightWords> FlightLog::events() const {
  std::vector<FlightWords> events;
  std::map<std::uint64_t, std::size_t> begun;  // by the sequence of part 0
  for (const FlightRecord& record : records) {
    if (record.kind != FlightKind::event) continue;
    const auto text = body_of<FlightText>(record);
    const std::size_t length = std::min<std::size_t>(text.length, text.text.size());
    const std::string words(reinterpret_cast<const char*>(text.text.data()), length);
    if (const auto found = begun.find(text.first); text.part > 0 && found != begun.end()) {
      events[found->second].words += words;
    } else {
      begun[text.first] = events.size();
      events.push_back({time_of(record), record.node, text.event, words});
    }
  }
  std::stable_sort(events.begin(), events.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  return events;
}

}  // namespace tactor
