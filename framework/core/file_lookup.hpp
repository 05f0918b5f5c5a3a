// Finds the files that graphs, studies, profiles and command lines name, all in one order.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tactor {

/// A kind of files, and the folders of the user and of the program that hold them.
struct FileKind {
  std::string noun = "a file";  ///< for error texts
  std::string variable{};       ///< of the environment: the user's folders, with `:` between them; empty: none
  std::string folder{};         ///< the program's: `meshes`; empty: the program has no such files
  std::string part{};           ///< a folder inside of each of these, which a name may leave out: `usb`
  std::string ending{};         ///< that a name of a file in these folders may leave out: `.yaml`
};

inline const FileKind any_file{};
inline const FileKind mesh_files{.variable = "TACTOR_MESH_PATH", .folder = "meshes"};
inline const FileKind graph_files{
    .noun = "a graph file", .variable = "TACTOR_GRAPH_PATH", .folder = "graphs", .ending = ".yaml"};
/// Graphs that are laid over others.
inline const FileKind method_files{
    .noun = "a graph file", .variable = "TACTOR_GRAPH_PATH", .folder = "graphs", .part = "methods", .ending = ".yaml"};

inline const FileKind study_files{
    .noun = "a study file", .variable = "TACTOR_GRAPH_PATH", .folder = "graphs", .part = "studies", .ending = ".yaml"};

/// The result of a search.
struct FileSearch {
  std::filesystem::path file;                ///< empty if there is none
  std::vector<std::filesystem::path> tried;  ///< every place that was searched, in order
};

/// Looks for `name` in the folders `beside` (an empty one is that of the command), then in those of the user, then in
/// those of the installation: FOLDER and share/tactor/FOLDER in its prefix. An absolute name is
/// looked for where it says. A folder of that name does not count. At last a name without the ending is looked for with
/// it in `beside`.
FileSearch find_file(const std::filesystem::path& name, const std::vector<std::filesystem::path>& beside,
                     const FileKind& kind);

/// The folders of the user and of the program where such files lie, in the order in which they are searched: `part` in
/// a folder before the folder itself.
std::vector<std::filesystem::path> folders_of(const FileKind& kind);

/// The files of that kind and ending of the user and the program, each name once, as find_file finds it.
std::vector<std::filesystem::path> files_of(const FileKind& kind);

/// The names that find_file finds files of this file name by, in the folders below those of the user and the program:
/// `bunny/scene` for scene.yaml. Each once, in order.
std::vector<std::string> names_in_folders(const std::filesystem::path& file_name, const FileKind& kind);

}  // namespace tactor
