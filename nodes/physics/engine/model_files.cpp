#include "nodes/physics/engine/model_files.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>
#include <system_error>

#include "framework/core/check.hpp"
#include "framework/core/random.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

/// The values of the attributes that the expression names, in their order.
std::vector<std::string> attributes(const std::string& text, const char* names) {
  const std::regex attribute(std::string("[\\s](?:") + names + R"re()\s*=\s*(?:"([^"]*)"|'([^']*)'))re");
  std::vector<std::string> values;
  for (std::sregex_iterator found(text.begin(), text.end(), attribute), end; found != end; ++found) {
    values.push_back((*found)[1].matched ? (*found)[1] : (*found)[2]);
  }
  return values;
}

std::string contents_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string contents{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (!in) throw InputError("cannot read " + file.string());
  return contents;
}

/// Adds what is not there yet; true where something was added.
template <class T>
bool add_new(const T& item, std::vector<T>& list) {
  if (std::find(list.begin(), list.end(), item) != list.end()) return false;
  list.push_back(item);
  return true;
}

/// The names of files in a tree of models, and the folders in which they may lie.
struct ModelTree {
  fs::path main_folder;
  std::vector<fs::path> folders;
  std::vector<std::string> names;

  void read(const fs::path& model) {
    const std::string text = contents_of(model);
    add_new(model.parent_path(), folders);
    for (const std::string& name : attributes(text, "meshdir|texturedir|assetdir")) {
      add_new((main_folder / name).lexically_normal(), folders);
      add_new((model.parent_path() / name).lexically_normal(), folders);
    }
    for (const std::string& name : attributes(text, "file")) add_new(name, names);
  }
};

}  // namespace

std::vector<fs::path> model_files(const fs::path& file) {
  const fs::path main = file.lexically_normal();
  ModelTree tree{main.parent_path(), {main.parent_path()}, {}};
  tree.read(main);
  std::vector<fs::path> files{main};
  // A file that is found later can name a folder for a name that came before.
  for (bool more = true; more;) {
    more = false;
    const std::vector<fs::path> folders = tree.folders;
    const std::vector<std::string> names = tree.names;
    for (const std::string& name : names) {
      for (const fs::path& folder : folders) {
        std::error_code ignored;
        const fs::path found = (folder / name).lexically_normal();
        if (!fs::is_regular_file(found, ignored) || !add_new(found, files)) continue;
        more = true;
        if (found.extension() == ".xml") tree.read(found);
      }
    }
  }
  files.erase(files.begin());
  return files;
}

std::uint64_t hash_of_files(const fs::path& file) {
  std::uint64_t hash = derive_seed(0, contents_of(file));
  for (const fs::path& part : model_files(file)) hash = derive_seed(hash, contents_of(part));
  return hash;
}

}  // namespace tactor
