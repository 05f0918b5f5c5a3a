#include "nodes/physics/engine/model_files.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>
#include <system_error>

#include "framework/core/check.hpp"

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

void add_files_of(const fs::path& model, std::vector<fs::path>& files) {
  std::ifstream in(model);
  const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (!in) throw InputError("cannot read " + model.string());
  std::vector<fs::path> folders{model.parent_path()};
  for (const std::string& name : attributes(text, "meshdir|texturedir|assetdir")) {
    folders.push_back(model.parent_path() / name);
  }
  for (const std::string& name : attributes(text, "file")) {
    for (const fs::path& folder : folders) {
      std::error_code ignored;
      const fs::path file = (folder / name).lexically_normal();
      if (!fs::is_regular_file(file, ignored) || std::find(files.begin(), files.end(), file) != files.end()) continue;
      files.push_back(file);
      if (file.extension() == ".xml") add_files_of(file, files);
    }
  }
}

}  // namespace

std::vector<fs::path> model_files(const fs::path& file) {
  std::vector<fs::path> files{file.lexically_normal()};
  add_files_of(file, files);
  files.erase(files.begin());
  return files;
}

}  // namespace tactor
