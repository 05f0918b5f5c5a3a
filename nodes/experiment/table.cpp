#include "nodes/experiment/table.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <system_error>

#include "framework/core/check.hpp"
#include "framework/core/value_error.hpp"
#include "nodes/experiment/number_text.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view table_header =
    "trial,run,block,condition,other,level,comparison,response,correct,response_time_s,peak_1_N,peak_2_N,limited_1,"
    "limited_2,seed,design\n";
/// What the heading of each version began with.
constexpr std::string_view every_version = "trial,run,block,condition,other,level,";
constexpr std::size_t table_columns = 16;
constexpr std::size_t seed_column = 14;
constexpr std::size_t design_column = 15;

/// What was measured, to a millionth; empty where nothing was.
std::string measured_text(double value) {
  return std::isfinite(value) ? shortest(std::round(value * 1e6) / 1e6) : "";
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

/// Makes the disk keep which files a folder holds.
void keep_folder(const fs::path& folder) {
  const FileDescriptor opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  // A file system without a folder to write says EINVAL.
  if (opened && (::fsync(opened.number()) == 0 || errno == EINVAL)) return;
  throw ValueError("folder", folder.string() + " cannot be written: " + last_error());
}

/// Makes the folder and those above it, and makes the disk keep them.
void make_folder(const fs::path& folder) {
  std::error_code error;
  if (folder.empty() || fs::is_directory(folder, error)) return;
  make_folder(folder.parent_path());
  fs::create_directory(folder, error);
  if (error) throw ValueError("folder", folder.string() + " cannot be made: " + error.message());
  keep_folder(folder.parent_path().empty() ? "." : folder.parent_path());
}

}  // namespace

ParticipantCode participant_code(const std::string& text) {
  const bool good = text.size() >= 2 && text.size() <= 4 && text[0] >= 'A' && text[0] <= 'Z' &&
                    std::all_of(text.begin() + 1, text.end(), [](char c) { return c >= '0' && c <= '9'; });
  ParticipantCode code{text, 0};
  if (!good || !read_number(text.substr(1), code.number)) {
    throw ValueError("participant",
                     "participant: expected one capital letter and then one to three digits, such as P07, found \"" +
                         text + "\"; a code, never a name, initials or a date");
  }
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
  if (!lock_.take(file_.number(), path_)) {
    throw ValueError("participant", path_.string() + " is being written by another run" + lock_.holder());
  }
  // A row is on the disk only where the disk also knows the file. Rows change nothing in the folder.
  keep_folder(path_.parent_path().empty() ? "." : path_.parent_path());
}

void TrialTable::write(const std::string& text) {
  if (!file_.write_all(text.data(), text.size()) || ::fdatasync(file_.number()) != 0) {
    throw RunError(path_.string() + " cannot be written: " + last_error());
  }
}

TrialTable TrialTable::begin(const fs::path& file, TableOwner owner) {
  make_folder(file.parent_path());
  TrialTable table(file, std::move(owner));
  table.open(O_CREAT | O_EXCL);
  table.write(std::string(table_header));
  return table;
}

void TrialTable::check_owner(const std::vector<std::string>& fields, std::size_t number) const {
  const std::string differing = owner_.design.differing(fields[design_column]);
  if (!differing.empty()) {
    throw ValueError("participant", place(number) + ": the table was begun with another design and cannot be " +
                                        "continued: " + differing +
                                        " differ; give the graph as it was when the table was begun");
  }
  if (fields[seed_column] != std::to_string(owner_.seed)) {
    throw ValueError("participant", place(number) + ": the table was begun with another seed: expected " +
                                        std::to_string(owner_.seed) + ", found " + fields[seed_column] +
                                        "; use the seed and the code that it was begun with");
  }
}

ExperimentRow TrialTable::read_row(const std::string& line, std::size_t number) const {
  const std::vector<std::string> fields = fields_of(line);
  if (fields.size() != table_columns) {
    throw ValueError("participant", place(number) + ": expected " + std::to_string(table_columns) + " columns, found " +
                                        std::to_string(fields.size()));
  }
  check_owner(fields, number);
  ExperimentRow row;
  const auto read = [&](std::size_t column, auto& value) {
    if (read_number(fields[column], value)) return;
    throw ValueError("participant", place(number) + ": expected a number in column " + std::to_string(column + 1) +
                                        ", found \"" + fields[column] + "\"");
  };
  const auto condition = [&](std::size_t column) {
    const auto at = std::find(owner_.codes.begin(), owner_.codes.end(), fields[column]);
    if (at != owner_.codes.end()) return static_cast<std::int32_t>(at - owner_.codes.begin());
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
  return row;
}

TrialTable TrialTable::resume(const fs::path& file, TableOwner owner) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw ValueError("resume", file.string() + " cannot be read: there is no table to continue");
  // Read only once no other run can write it, and cut only once all of it is known to be this table.
  TrialTable table(file, std::move(owner));
  table.open(0);
  std::string text(std::istreambuf_iterator<char>(stream), {});
  // A row that a crash has cut off has no end of line.
  text.resize(text.find_last_of('\n') + 1);
  if (!text.empty() && !text.starts_with(table_header) && text.starts_with(every_version)) {
    throw ValueError("participant", table.place(1) +
                                        ": the table is of an earlier version of Tactor, which had other columns, and "
                                        "cannot be continued; another code begins a new one");
  }
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
  const auto code = [this](std::int32_t index) { return owner_.codes[static_cast<std::size_t>(index)]; };
  const std::string correct = row.correct < 0 ? "" : std::to_string(row.correct);
  std::string line;
  for (const std::string& field :
       {std::to_string(row.trial), std::to_string(row.run), std::to_string(row.block), code(row.condition),
        code(row.other), shortest(row.level), std::to_string(row.comparison), std::to_string(row.response), correct,
        measured_text(row.response_time), measured_text(row.peak_first), measured_text(row.peak_second),
        measured_text(row.limited_first), measured_text(row.limited_second), std::to_string(owner_.seed),
        owner_.design.digest()}) {
    line += (line.empty() ? "" : ",") + field;
  }
  write(line + "\n");
}

}  // namespace tactor
