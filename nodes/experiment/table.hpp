// The table of one participant: a row a trial, kept on the disk before the next trial begins.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "framework/core/file_descriptor.hpp"
#include "framework/core/write_lock.hpp"
#include "nodes/experiment/design.hpp"
#include "nodes/experiment/messages.hpp"

namespace tactor {

/// A participant's code such as P07: one capital letter, then one to three digits. So it holds no name, no initials and
/// no date.
struct ParticipantCode {
  std::string text;
  std::uint64_t number = 0;  ///< 0: for practice, nothing is written
};
/// Throws ValueError("participant", ...) if the text is not a code.
ParticipantCode participant_code(const std::string& text);

/// Whose table it is.
struct TableOwner {
  std::vector<std::string> codes;  ///< of the conditions
  std::uint64_t seed = 0;          ///< of the participant's draws
  StudyDesign design;
};

/// FOLDER/CODE.csv. Conditions are written by their codes, so that the table tells the name of no method.
class TrialTable {
 public:
  /// Begins the file. Throws ValueError where it exists.
  static TrialTable begin(const std::filesystem::path& file, TableOwner owner);
  /// Goes on with the file: reads its rows, and takes away a row that was cut off. Throws ValueError where it has not
  /// these conditions, this seed and this design.
  static TrialTable resume(const std::filesystem::path& file, TableOwner owner);

  /// What it held when it was opened.
  [[nodiscard]] const std::vector<ExperimentRow>& rows() const { return rows_; }
  /// Adds a row, and returns when the disk has it. Throws RunError where it has not.
  void add(const ExperimentRow& row);

 private:
  TrialTable(std::filesystem::path path, TableOwner owner) : path_(std::move(path)), owner_(std::move(owner)) {}
  void open(int flags);
  void write(const std::string& text);
  void check_owner(const std::vector<std::string>& fields, std::size_t number) const;
  [[nodiscard]] ExperimentRow read_row(const std::string& line, std::size_t number) const;
  [[nodiscard]] std::string place(std::size_t line) const { return path_.string() + ":" + std::to_string(line); }

  std::filesystem::path path_;
  TableOwner owner_;
  FileDescriptor file_;
  WriteLock lock_;
  std::vector<ExperimentRow> rows_;
};

}  // namespace tactor
