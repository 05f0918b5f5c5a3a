// The table of one participant: a row a trial, kept on the disk before the next trial begins.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "framework/core/file_descriptor.hpp"
#include "nodes/experiment/messages.hpp"

namespace tactor {

/// A participant's code such as P07: up to four letters, then up to six digits. It is no name.
struct ParticipantCode {
  std::string text;
  std::uint64_t number = 0;  ///< 0: for practice, nothing is written
};
/// Throws ValueError("participant", ...) where the text is none.
ParticipantCode participant_code(const std::string& text);

/// FOLDER/CODE.csv. Conditions are written by their codes, so that the table tells the name of no method.
class TrialTable {
 public:
  /// Begins the file. Throws ValueError where it exists.
  static TrialTable begin(const std::filesystem::path& file, std::vector<std::string> codes, std::uint64_t seed);
  /// Goes on with the file: reads its rows, and takes away a row that was cut off. Throws ValueError where it is none
  /// of these conditions and this seed.
  static TrialTable resume(const std::filesystem::path& file, std::vector<std::string> codes, std::uint64_t seed);

  /// What it held when it was opened.
  [[nodiscard]] const std::vector<ExperimentRow>& rows() const { return rows_; }
  /// Adds a row, and returns when the disk has it. Throws RunError where it has not.
  void add(const ExperimentRow& row);

 private:
  TrialTable(std::filesystem::path path, std::vector<std::string> codes, std::uint64_t seed)
      : path_(std::move(path)), codes_(std::move(codes)), seed_(seed) {}
  void open(int flags);
  void write(const std::string& text);
  [[nodiscard]] ExperimentRow read_row(const std::string& line, std::size_t number) const;
  [[nodiscard]] std::string place(std::size_t line) const { return path_.string() + ":" + std::to_string(line); }

  std::filesystem::path path_;
  std::vector<std::string> codes_;
  std::uint64_t seed_;
  FileDescriptor file_;
  std::vector<ExperimentRow> rows_;
};

}  // namespace tactor
