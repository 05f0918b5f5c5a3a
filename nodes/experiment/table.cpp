#include "nodes/experiment/table.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <system_error>

#include "framework/core/check.hpp"
#include "framework/core/value_error.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view table_header =
    "trial,run,block,condition,other,level,comparison,response,correct,response_time_s,peak_1_N,peak_2_N,seed\n";
constexpr std::size_t table_columns = 13;

/// The shortest text that reads back to the same number; empty for what is no number.
std::string number_text(double value) {
  if (!std::isfinite(value)) return {};
  std::array<char, 32> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  return {digits.data(), end.ptr};
}

/// What was measured, to a millionth.
std::string measured_text(double value) {
  return number_text(std::round(value * 1e6) / 1e6);
}

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields(1);
  for (const char c : line) {
    if (c == ',') {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  return fields;
}

template <class T>
bool read_number(const std::string& text, T& value) {
  const char* end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, value);
  return read.ec == std::errc() && read.ptr == end;
}

std::string last_error() {
  return std::generic_category().message(errno);
}

}  // namespace

ParticipantCode participant_code(const std::string& text) {
  const auto refuse = [&text] {
    return ValueError(
        "participant",
        "participant: expected a code of up to four letters and then up to six digits, such as P07, found "
        "\"" +
            text + "\"; a code, never a name: --set protocol.participant=P07");
  };
  const auto digit = std::find_if(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
  const auto letters = std::distance(text.begin(), digit);
  const auto digits = std::distance(digit, text.end());
  const bool good =
      std::all_of(text.begin(), digit, [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }) &&
      std::all_of(digit, text.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (!good || letters < 1 || letters > 4 || digits < 1 || digits > 6) throw refuse();
  ParticipantCode code{text, 0};
  if (!read_number(std::string(digit, text.end()), code.number)) throw refuse();
  return code;
}

void TrialTable::open(int flags) {
  file_ = FileDescriptor(::open(path_.c_str(), flags | O_WRONLY | O_APPEND | O_CLOEXEC, 0644));
  if (!file_ && errno == EEXIST) {
    throw ValueError("participant", path_.string() +
                                        " exists: the participant has been here; resume: true continues the table, "
                                        "another code begins one");
  }
  if (!file_) throw ValueError("folder", path_.string() + " cannot be written: " + last_error());
  if (::flock(file_.number(), LOCK_EX | LOCK_NB) != 0) {
    throw ValueError("participant", path_.string() + " is being written by another run");
  }
}

void TrialTable::write(const std::string& text) {
  if (!file_.write_all(text.data(), text.size()) || ::fdatasync(file_.number()) != 0) {
    throw RunError(path_.string() + " cannot be written: " + last_error());
  }
}

TrialTable TrialTable::begin(const fs::path& file, std::vector<std::string> codes, std::uint64_t seed) {
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  if (error) throw ValueError("folder", file.parent_path().string() + " cannot be made: " + error.message());
  TrialTable table(file, std::move(codes), seed);
  table.open(O_CREAT | O_EXCL);
  table.write(std::string(table_header));
  return table;
}

ExperimentRow TrialTable::read_row(const std::string& line, std::size_t number) const {
  const std::vector<std::string> fields = fields_of(line);
  if (fields.size() != table_columns) {
    throw ValueError("participant", place(number) + ": expected " + std::to_string(table_columns) + " columns, found " +
                                        std::to_string(fields.size()));
  }
  ExperimentRow row;
  const auto read = [&](std::size_t column, auto& value) {
    if (read_number(fields[column], value)) return;
    throw ValueError("participant", place(number) + ": expected a number in column " + std::to_string(column + 1) +
                                        ", found \"" + fields[column] + "\"");
  };
  const auto condition = [&](std::size_t column) {
    const auto at = std::find(codes_.begin(), codes_.end(), fields[column]);
    if (at != codes_.end()) return static_cast<std::int32_t>(at - codes_.begin());
    throw ValueError("conditions", place(number) + ": the graph has no condition \"" + fields[column] + "\"");
  };
  read(0, row.trial);
  read(1, row.run);
  read(2, row.block);
  row.condition = condition(3);
  row.other = condition(4);
  read(5, row.level);
  read(6, row.comparison);
  read(7, row.response);
  row.correct = -1;
  if (!fields[8].empty()) read(8, row.correct);
  read(9, row.response_time);
  std::uint64_t seed = 0;
  read(12, seed);
  if (seed != seed_) {
    throw ValueError("participant", place(number) + ": the table was begun with another seed: expected " +
                                        std::to_string(seed_) + ", found " + fields[12] +
                                        "; give the seed and the code that it was begun with");
  }
  return row;
}

TrialTable TrialTable::resume(const fs::path& file, std::vector<std::string> codes, std::uint64_t seed) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw ValueError("resume", file.string() + " cannot be read: there is no table to continue");
  // Read only once no other run can write it, and cut only once all of it is known to be this table.
  TrialTable table(file, std::move(codes), seed);
  table.open(0);
  std::string text(std::istreambuf_iterator<char>(stream), {});
  // A row that a crash has cut off has no end of line.
  text.resize(text.find_last_of('\n') + 1);
  if (!text.empty() && !text.starts_with(table_header)) {
    throw ValueError("participant", table.place(1) + ": expected the heading of a table of trials, found another file");
  }
  std::size_t line = 2;
  for (std::size_t begin = table_header.size(); begin < text.size(); ++line) {
    const std::size_t end = text.find('\n', begin);
    table.rows_.push_back(table.read_row(text.substr(begin, end - begin), line));
    begin = end + 1;
  }
  if (::ftruncate(table.file_.number(), static_cast<off_t>(text.size())) != 0) {
    throw ValueError("folder", file.string() + " cannot be written: " + last_error());
  }
  if (text.empty()) table.write(std::string(table_header));
  return table;
}

void TrialTable::add(const ExperimentRow& row) {
  const auto code = [this](std::int32_t index) { return codes_[static_cast<std::size_t>(index)]; };
  const std::string correct = row.correct < 0 ? "" : std::to_string(row.correct);
  std::string line;
  for (const std::string& field :
       {std::to_string(row.trial), std::to_string(row.run), std::to_string(row.block), code(row.condition),
        code(row.other), number_text(row.level), std::to_string(row.comparison), std::to_string(row.response), correct,
        measured_text(row.response_time), measured_text(row.peak_first), measured_text(row.peak_second),
        std::to_string(seed_)}) {
    line += (line.empty() ? "" : ",") + field;
  }
  write(line + "\n");
}

}  // namespace tactor
