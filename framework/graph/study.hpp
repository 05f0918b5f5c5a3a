// A study file: which graphs are run by which methods, with which values and seeds.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace tactor {

/// Values that are tried one after the other.
struct StudyAxis {
  std::vector<std::string> paths;   ///< `node.parameter`; all of them get the same value
  std::vector<std::string> values;  ///< YAML, as after --set path=
};

/// A checked study file. Paths of files are absolute.
struct StudySpec {
  std::string name;   ///< the file's stem
  std::string title;  ///< one line of prose, or empty
  std::vector<std::filesystem::path> graphs;
  std::vector<std::filesystem::path> methods;  ///< laid over every graph, one at a time; none: the graphs as they are
  std::vector<std::string> set;                ///< `path=value` of every run
  std::vector<StudyAxis> vary;                 ///< every combination is run, the last axis fastest
  std::int64_t seeds = 20;
  std::uint64_t first_seed = 1001;
};

/// Reads a study. Throws GraphError with every error of the file itself; the graphs are not looked into.
StudySpec load_study(const std::filesystem::path& file);

}  // namespace tactor
