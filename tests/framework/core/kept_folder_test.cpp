// Files that the program keeps lie in folders of the user alone, and no other user leads reads or writes elsewhere.
#include <boost/test/unit_test.hpp>

#include <pwd.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <string>

#include "framework/core/check.hpp"
#include "framework/core/kept_folder.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/core/user_folders.hpp"

BOOST_AUTO_TEST_SUITE(kept_folder_test)

using namespace tactor;
namespace fs = std::filesystem;

namespace {

constexpr uid_t nobody = 65534;

std::string read(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(in), {});
}

void write(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

/// What an action throws; empty where it throws nothing.
template <class Action>
std::string refusal(const Action& action) {
  try {
    action();
  } catch (const RunError& error) {
    return error.what();
  }
  return {};
}

bool says(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// Sets or unsets a variable of the environment for as long as it lives.
class Variable {
 public:
  Variable(const char* name, const char* value) : name_(name) {
    if (const char* old = std::getenv(name)) old_ = old;
    set(value);
  }
  ~Variable() { set(old_ ? old_->c_str() : nullptr); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  void set(const char* value) { value == nullptr ? unsetenv(name_) : setenv(name_, value, 1); }
  const char* name_;
  std::optional<std::string> old_;
};

}  // namespace

BOOST_AUTO_TEST_CASE(what_is_written_is_read_back_and_only_its_user_may_read_it) {
  const TemporaryFolder temporary;
  const fs::path path = temporary.path() / "a" / "b";
  BOOST_TEST(!KeptFolder::find(path).has_value());
  const KeptFolder folder = KeptFolder::make(path);
  BOOST_TEST(!folder.open("file").has_value());
  folder.write("file", {"one", "two"});
  folder.write("file", {"three", "", "four"});
  BOOST_TEST(read(path / "file") == "threefour");
  std::string bytes(9, ' ');
  BOOST_TEST(KeptFolder::find(path)->open("file")->read_all(bytes.data(), bytes.size()));
  BOOST_TEST(bytes == "threefour");
  struct stat status {};
  for (const fs::path& made : {path.parent_path(), path}) {
    BOOST_TEST(::stat(made.c_str(), &status) == 0);
    BOOST_TEST((status.st_mode & 07777U) == 0700U);
  }
  BOOST_TEST(::stat((path / "file").c_str(), &status) == 0);
  BOOST_TEST((status.st_mode & 07777U) == 0600U);
  BOOST_TEST(std::distance(fs::directory_iterator(path), fs::directory_iterator()) == 1);
  folder.remove("file");
  folder.remove("file");
  BOOST_TEST(!folder.open("file").has_value());
}

BOOST_AUTO_TEST_CASE(a_link_in_the_folder_is_neither_read_nor_written_through) {
  const TemporaryFolder temporary;
  const fs::path victim = temporary.path() / "victim", path = temporary.path() / "kept";
  write(victim, "precious");
  const KeptFolder folder = KeptFolder::make(path);
  fs::create_symlink(victim, path / "file");
  BOOST_TEST(says(refusal([&] { static_cast<void>(folder.open("file")); }), "is a link"));
  BOOST_TEST(read(victim) == "precious");
  folder.write("file", {"new"});
  BOOST_TEST(read(victim) == "precious");
  BOOST_TEST(!fs::is_symlink(path / "file"));
  BOOST_TEST(read(path / "file") == "new");
}

BOOST_AUTO_TEST_CASE(a_folder_or_file_that_others_may_write_is_refused_with_its_name) {
  const TemporaryFolder temporary;
  const fs::path path = temporary.path() / "kept";
  for (const fs::perms bit : {fs::perms::group_write, fs::perms::others_write}) {
    KeptFolder::make(path).write("file", {"bytes"});
    fs::permissions(path / "file", bit, fs::perm_options::add);
    const std::string of_file = refusal([&] { static_cast<void>(KeptFolder::find(path)->open("file")); });
    BOOST_TEST(says(of_file, (path / "file").string() + ": other users may write it"), of_file);
    fs::permissions(path, bit, fs::perm_options::add);
    for (const std::string& of_folder :
         {refusal([&] { KeptFolder::make(path); }), refusal([&] { static_cast<void>(KeptFolder::find(path)); })}) {
      BOOST_TEST(says(of_folder, path.string() + ": other users may write it"), of_folder);
    }
    fs::permissions(path, bit, fs::perm_options::remove);
  }
  // The folder for temporary files itself is nobody's own.
  BOOST_TEST(!refusal([&] { KeptFolder::make("/tmp"); }).empty());
}

BOOST_AUTO_TEST_CASE(a_file_that_names_programs_is_refused_with_its_place_where_others_may_replace_it) {
  const TemporaryFolder temporary;
  const fs::path above = temporary.path() / "above", folder = above / "systems", file = folder / "file";
  fs::create_directories(folder);
  write(file, "bytes");
  const auto trouble = [](const fs::path& path) {
    return refusal([&] { static_cast<void>(open_programs_file(path)); });
  };
  BOOST_TEST(trouble(file).empty());
  BOOST_TEST(open_programs_file(file).folder == fs::canonical(folder));
  BOOST_TEST(!open_programs_file(folder / "nothing").file);
  BOOST_TEST(says(trouble(folder), "is not a regular file"));
  for (const fs::path& place : {file, folder}) {
    for (const fs::perms bit : {fs::perms::group_write, fs::perms::others_write}) {
      fs::permissions(place, bit, fs::perm_options::add);
      BOOST_TEST(says(trouble(file), place.string() + ": "), trouble(file));
      fs::permissions(place, bit, fs::perm_options::remove);
    }
  }
  fs::permissions(above, fs::perms::others_write, fs::perm_options::add);
  BOOST_TEST(says(trouble(file), above.string() + ": all users may replace what is in it"));
  BOOST_TEST(says(refusal([&] { static_cast<void>(KeptFolder::find(folder, KeptFolder::Decides::programs)); }),
                  above.string() + ": all users may replace"));
  BOOST_TEST(refusal([&] { static_cast<void>(KeptFolder::find(folder)); }).empty());
  fs::permissions(above, fs::perms::sticky_bit, fs::perm_options::add);
  BOOST_TEST(trouble(file).empty());
  // A link leads to the folder that counts.
  const fs::path link = temporary.path() / "link";
  fs::create_symlink(file, link);
  BOOST_TEST(open_programs_file(link).folder == fs::canonical(folder));
  fs::permissions(folder, fs::perms::others_write, fs::perm_options::add);
  BOOST_TEST(says(trouble(link), folder.string() + ": "));
}

BOOST_AUTO_TEST_CASE(a_folder_file_or_link_of_another_user_is_refused_with_that_name) {
  if (geteuid() != 0) {
    BOOST_TEST_MESSAGE("only root can make files of another user");
    return;
  }
  const TemporaryFolder temporary;
  const fs::path own = temporary.path() / "own", others = temporary.path() / "others", link = temporary.path() / "link";
  KeptFolder::make(own).write("file", {"bytes"});
  fs::create_directory(others);
  fs::create_directory(own / "below");
  fs::create_symlink(own, link);
  BOOST_TEST(::lchown(others.c_str(), nobody, nobody) == 0);
  BOOST_TEST(refusal([&] { KeptFolder::make(link / "below"); }).empty());  // a link of one's own
  BOOST_TEST(::lchown(link.c_str(), nobody, nobody) == 0);
  BOOST_TEST(says(refusal([&] { KeptFolder::make(others); }), others.string() + ": belongs to the user nobody"));
  BOOST_TEST(
      says(refusal([&] { KeptFolder::make(link / "below"); }), link.string() + ": is a link of the user nobody"));
  BOOST_TEST(says(refusal([&] { KeptFolder::make(link); }), link.string() + ": is a link of the user nobody"));
  BOOST_TEST(::chown((own / "file").c_str(), nobody, nobody) == 0);
  BOOST_TEST(
      says(refusal([&] { static_cast<void>(KeptFolder::make(own).open("file")); }), "belongs to the user nobody"));
}

BOOST_AUTO_TEST_CASE(pipes_and_folders_in_the_place_of_a_file_are_refused_at_once) {
  const TemporaryFolder temporary;
  const KeptFolder folder = KeptFolder::make(temporary.path());
  BOOST_TEST(::mkfifo((temporary.path() / "pipe").c_str(), 0600) == 0);
  fs::create_directory(temporary.path() / "folder");
  for (const char* name : {"pipe", "folder"}) {
    BOOST_TEST(says(refusal([&] { static_cast<void>(folder.open(name)); }), "is not a regular file"));
  }
}

BOOST_AUTO_TEST_CASE(links_that_turn_in_a_circle_and_files_on_the_way_are_refused) {
  const TemporaryFolder temporary;
  fs::create_symlink("circle", temporary.path() / "circle");
  BOOST_TEST(!refusal([&] { KeptFolder::make(temporary.path() / "circle"); }).empty());
  write(temporary.path() / "file", "");
  BOOST_TEST(says(refusal([&] { KeptFolder::make(temporary.path() / "file" / "kept"); }), "file: is not a folder"));
}

BOOST_AUTO_TEST_CASE(no_variable_leads_into_the_folder_for_temporary_files) {
  const Variable cache("TACTOR_CACHE", nullptr), xdg_cache("XDG_CACHE_HOME", nullptr), state("XDG_STATE_HOME", nullptr),
      runtime("XDG_RUNTIME_DIR", nullptr);
  {
    const Variable home("HOME", "/home/of/mine");
    BOOST_TEST(default_cache_folder() == "/home/of/mine/.cache/tactor");
    BOOST_TEST(state_folder() == "/home/of/mine/.local/state/tactor");
    BOOST_TEST(runtime_folder() == "/home/of/mine/.local/state/tactor");
    const Variable own_runtime("XDG_RUNTIME_DIR", "/run/user/7"), own_state("XDG_STATE_HOME", "not/absolute"),
        own_cache("TACTOR_CACHE", "relative");
    BOOST_TEST(runtime_folder() == "/run/user/7/tactor");
    BOOST_TEST(state_folder() == "/home/of/mine/.local/state/tactor");
    BOOST_TEST(default_cache_folder() == fs::current_path() / "relative");
  }
  for (const char* useless : {static_cast<const char*>(nullptr), "", "not/absolute"}) {
    const Variable home("HOME", useless);
    for (const fs::path& folder : {default_cache_folder(), state_folder(), runtime_folder()}) {
      BOOST_TEST(!folder.string().starts_with(fs::temp_directory_path().string() + "/tactor"), folder);
    }
    const passwd* user = ::getpwuid(::geteuid());
    if (user != nullptr && fs::is_directory(user->pw_dir)) {
      BOOST_TEST(default_cache_folder() == fs::path(user->pw_dir) / ".cache" / "tactor");
    }
  }
}

BOOST_AUTO_TEST_SUITE_END()
