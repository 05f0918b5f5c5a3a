// Files that users name are opened where they are files, and what else stands there is told at once.
#include <boost/test/unit_test.hpp>

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <new>
#include <string>

#include "framework/core/input_file.hpp"
#include "framework/core/temporary_folder.hpp"

BOOST_AUTO_TEST_SUITE(input_file_test)

using namespace tactor;
namespace fs = std::filesystem;

namespace {

std::string refusal(const fs::path& path, std::uint64_t most = 1000) {
  try {
    static_cast<void>(read_input_file(path, most));
  } catch (const InputError& error) {
    return error.what();
  }
  return "read";
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_file_of_up_to_the_bound_is_read_byte_by_byte) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "file";
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{4096}, std::size_t{100'001}}) {
    std::string bytes(size, 'x');
    for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<char>(i * 7);
    std::ofstream(path, std::ios::binary) << bytes;
    BOOST_TEST((read_input_file(path, size) == bytes));
    BOOST_TEST((read_input_file(path, size + 1) == bytes));
    if (size > 0) BOOST_TEST(refusal(path, size - 1).find("bytes, found a larger file") != std::string::npos);
  }
  // A file of the kernel, which shows no size.
  BOOST_TEST(fs::file_size("/proc/self/status") == 0U);
  BOOST_TEST(read_input_file("/proc/self/status", 100'000).find("Name:") == 0U);
  BOOST_TEST(refusal("/proc/self/status", 10).find("found a larger file") != std::string::npos);
}

BOOST_AUTO_TEST_CASE(what_is_no_file_is_refused_at_once_with_its_kind) {
  const TemporaryFolder folder;
  const auto at = [&](const char* name) { return folder.path() / name; };
  BOOST_TEST(::mkfifo(at("pipe").c_str(), 0600) == 0);
  fs::create_symlink("pipe", at("link"));
  const int socket = ::socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, at("socket").c_str(), sizeof address.sun_path - 1);
  BOOST_TEST(::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  for (const auto& [path, kind] : {std::pair{at("pipe"), "a pipe; write its content to a file"},
                                   {at("link"), "a pipe; write its content to a file"},
                                   {at("socket"), "a socket; write"},
                                   {fs::path("/dev/zero"), "a device; write"},
                                   {folder.path(), "a folder"}}) {
    const std::string text = refusal(path);
    BOOST_TEST(text.find(path.string() + ": expected a file, found " + kind) == 0U, text);
  }
  ::close(socket);
  BOOST_TEST(refusal(at("none")) == at("none").string() + ": there is no such file");
  BOOST_TEST(open_input(at("none")).is_missing);
  BOOST_TEST(!open_input(at("pipe")).is_missing);
}

BOOST_AUTO_TEST_CASE(refused_memory_becomes_an_error_that_names_the_file_and_its_size) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "large.csv";
  std::ofstream(path).close();
  fs::resize_file(path, 34'500'000);
  BOOST_CHECK_EXCEPTION(
      within_memory(path, []() -> int { throw std::bad_alloc(); }), InputError, [&](const InputError& error) {
        return std::string(error.what()).find(path.string() + ": the file (34.5 MB) needs more memory") == 0;
      });
  BOOST_TEST(within_memory(path, [] { return 7; }) == 7);
}

BOOST_AUTO_TEST_SUITE_END()
