// What the disk cache returns is what it was given; damage and a full or read-only disk are noted and harm nothing.
#include <boost/test/unit_test.hpp>

#include <fmt/format.h>
#include <sys/stat.h>
#include <xxhash.h>

#include <chrono>
#include <fstream>
#include <thread>
#include <vector>

#include "framework/core/disk_cache.hpp"
#include "framework/core/temporary_folder.hpp"

BOOST_AUTO_TEST_SUITE(disk_cache_test)

using namespace tactor;
namespace fs = std::filesystem;

namespace {

std::string read(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(in), {});
}

void write(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

const std::string key = content_key({"a mesh"});
const std::string bytes("some\0bytes \xff", 12);

}  // namespace

BOOST_AUTO_TEST_CASE(what_was_stored_is_loaded_and_what_was_not_is_absent_without_a_word) {
  const TemporaryFolder folder;
  const DiskCache cache("test", 1, folder.path() / "made" / "on demand");
  BOOST_TEST(!cache.load(key).bytes);
  BOOST_TEST(cache.load(key).note.empty());
  BOOST_TEST(cache.store(key, bytes).empty());
  BOOST_TEST(cache.load(key).bytes.value().view() == bytes);
  BOOST_TEST(cache.store(key, "").empty());
  BOOST_TEST(cache.load(key).bytes.value().view().empty());
  // No part of a file is left over.
  BOOST_TEST(std::distance(fs::directory_iterator(cache.file(key).parent_path()), fs::directory_iterator()) == 1);
}

BOOST_AUTO_TEST_CASE(keys_depend_on_every_part_and_on_where_parts_end) {
  const std::vector<std::string> keys{content_key({}),         content_key({""}),       content_key({"ab"}),
                                      content_key({"a", "b"}), content_key({"b", "a"}), content_key({"ab", ""})};
  for (std::size_t i = 0; i < keys.size(); ++i) {
    BOOST_TEST(keys[i].size() == 32U);
    for (std::size_t j = 0; j < i; ++j) BOOST_TEST(keys[i] != keys[j]);
  }
  BOOST_TEST(content_key({"ab"}) == keys[2]);
}

BOOST_AUTO_TEST_CASE(the_key_of_a_file_is_the_hash_of_its_bytes_whatever_its_size) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "file";
  std::string content;
  for (const std::size_t size : {0U, 1U, 240U, 262143U, 262144U, 262145U, 1000000U}) {
    while (content.size() < size) content += static_cast<char>(content.size() % 251);
    write(file, content);
    const XXH128_hash_t hash = XXH3_128bits(content.data(), content.size());
    BOOST_TEST(file_key(file) == fmt::format("{:016x}{:016x}", hash.high64, hash.low64));
  }
  content.back() = static_cast<char>(content.back() ^ 1);
  const std::string before = file_key(file);
  write(file, content);
  BOOST_TEST(file_key(file) != before);
  BOOST_TEST(file_key(folder.path()) == "missing");
  BOOST_TEST(file_key(folder.path() / "no_such_file") == "missing");
}

BOOST_AUTO_TEST_CASE(an_entry_of_another_version_kind_or_key_is_not_used) {
  const TemporaryFolder folder;
  const DiskCache cache("test", 1, folder.path()), newer("test", 2, folder.path()), other("other", 1, folder.path());
  BOOST_TEST(cache.store(key, bytes).empty());
  BOOST_TEST(!newer.load(key).bytes);
  BOOST_TEST(newer.load(key).note.empty());
  const std::string second = content_key({"another mesh"});
  fs::copy_file(cache.file(key), cache.file(second));
  fs::copy_file(cache.file(key), other.file(key));
  for (const DiskCache::Found& found : {cache.load(second), other.load(key)}) {
    BOOST_TEST(!found.bytes);
    BOOST_TEST(found.note.find("damaged") != std::string::npos);
  }
  BOOST_TEST(newer.store(key, "new").empty());
  BOOST_TEST(newer.load(key).bytes.value().view() == "new");
}

BOOST_AUTO_TEST_CASE(damage_at_any_byte_and_truncation_at_any_length_are_found_and_noted) {
  const TemporaryFolder folder;
  const DiskCache cache("test", 1, folder.path());
  BOOST_TEST(cache.store(key, bytes).empty());
  const std::string good = read(cache.file(key));
  std::vector<std::string> damaged{good + "x"};
  for (std::size_t i = 0; i < good.size(); ++i) {
    damaged.push_back(good.substr(0, i));
    for (const int bit : {0, 7}) {
      damaged.push_back(good);
      damaged.back()[i] = static_cast<char>(damaged.back()[i] ^ (1 << bit));
    }
  }
  std::size_t noted = 0;
  for (const std::string& file : damaged) {
    write(cache.file(key), file);
    const DiskCache::Found found = cache.load(key);
    BOOST_TEST(!found.bytes);
    if (found.note.find(cache.file(key).string() + ": the cached file is damaged") != std::string::npos) ++noted;
  }
  // Eight of them changed the version, which makes an entry absent.
  BOOST_TEST(noted == damaged.size() - 8);
  BOOST_TEST(cache.store(key, bytes).empty());
  BOOST_TEST(cache.load(key).bytes.value().view() == bytes);
}

BOOST_AUTO_TEST_CASE(a_folder_that_cannot_be_written_is_noted_with_the_mend) {
  const TemporaryFolder folder;
  write(folder.path() / "a file", "");
  const DiskCache cache("test", 1, folder.path() / "a file" / "cache");
  const std::string note = cache.store(key, bytes);
  BOOST_TEST_MESSAGE(note);
  BOOST_TEST(note.find("a file/cache: the cache cannot be written") != std::string::npos);
  BOOST_TEST(note.find("TACTOR_CACHE") != std::string::npos);
  BOOST_TEST(!cache.load(key).bytes);
  // A folder that stands where the entry belongs can neither be read nor replaced.
  const DiskCache blocked("test", 1, folder.path());
  fs::create_directories(blocked.file(key) / "in the way");
  BOOST_TEST(blocked.load(key).note.find("is not a regular file") != std::string::npos);
  BOOST_TEST(!blocked.store(key, bytes).empty());
  BOOST_TEST(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()) == 2);
}

BOOST_AUTO_TEST_CASE(a_folder_that_is_there_and_takes_no_files_is_noted) {
  const DiskCache cache("test", 1, "/proc/self");
  BOOST_TEST(cache.store(key, bytes).find("/proc/self: the cache cannot be written") == 0U);
  BOOST_TEST(!cache.load(key).bytes);
}

BOOST_AUTO_TEST_CASE(entries_are_for_their_user_alone_whatever_the_umask) {
  const TemporaryFolder folder;
  const mode_t before = ::umask(0);
  const DiskCache cache("test", 1, folder.path() / "made" / "too");
  BOOST_TEST(cache.store(key, bytes).empty());
  ::umask(before);
  BOOST_TEST(static_cast<unsigned>(fs::status(cache.file(key)).permissions()) == 0600U);
  for (const fs::path& made : {folder.path() / "made", folder.path() / "made" / "too"}) {
    BOOST_TEST(static_cast<unsigned>(fs::status(made).permissions()) == 0700U);
  }
}

BOOST_AUTO_TEST_CASE(a_folder_or_an_entry_that_others_may_write_is_not_used) {
  const TemporaryFolder folder;
  const DiskCache cache("test", 1, folder.path());
  BOOST_TEST(cache.store(key, bytes).empty());
  fs::permissions(cache.file(key), fs::perms::others_write, fs::perm_options::add);
  BOOST_TEST(!cache.load(key).bytes);
  BOOST_TEST(cache.load(key).note.find("other users may write it") != std::string::npos);
  BOOST_TEST(cache.store(key, bytes).empty());
  BOOST_TEST(cache.load(key).bytes.value().view() == bytes);
  fs::permissions(folder.path(), fs::perms::group_write, fs::perm_options::add);
  BOOST_TEST(!cache.load(key).bytes);
  const std::string note = cache.store(key, bytes);
  BOOST_TEST(note.find(folder.path().string() + ": other users may write it") != std::string::npos, note);
  BOOST_TEST(note.find("TACTOR_CACHE") != std::string::npos, note);
}

BOOST_AUTO_TEST_CASE(without_any_folder_nothing_is_kept_and_that_is_noted) {
  const DiskCache cache("test", 1, fs::path());
  BOOST_TEST(!cache.load(key).bytes);
  BOOST_TEST(cache.store(key, bytes).find("the cache cannot be written: there is no folder to keep files in") == 0U);
}

BOOST_AUTO_TEST_CASE(an_entry_of_more_bytes_than_any_has_asks_for_no_memory) {
  const TemporaryFolder folder;
  const DiskCache cache("test", 1, folder.path());
  BOOST_TEST(cache.store(key, bytes).empty());
  // The size in the header is right, so nothing but the bound refuses it before 1 TiB is asked for.
  const std::uint64_t size = (std::uint64_t{1} << 40U);
  {
    std::fstream file(cache.file(key), std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(16);
    file.write(reinterpret_cast<const char*>(&size), sizeof size);
  }
  fs::resize_file(cache.file(key), size + 40);
  BOOST_TEST(!cache.load(key).bytes);
  BOOST_TEST(cache.load(key).note.find("damaged") != std::string::npos);
}

BOOST_AUTO_TEST_CASE(what_killed_writers_left_is_removed_after_a_day_and_nothing_else) {
  const TemporaryFolder folder;
  const DiskCache cache("test", 1, folder.path());
  const fs::path old_part = cache.file(key).string() + ".part.1.0", new_part = cache.file(key).string() + ".part.1.1",
                 users_own = folder.path() / "notes.txt";
  const std::string second = content_key({"an old mesh"});
  BOOST_TEST(cache.store(second, bytes).empty());
  for (const fs::path& file : {old_part, new_part, users_own}) write(file, "half");
  const auto now = fs::file_time_type::clock::now();
  for (const fs::path& file : {old_part, users_own, cache.file(second)}) {
    fs::last_write_time(file, now - std::chrono::hours(25));
  }
  fs::last_write_time(new_part, now - std::chrono::hours(23));
  BOOST_TEST(cache.store(key, bytes).empty());
  BOOST_TEST(!fs::exists(old_part));
  for (const fs::path& file : {new_part, users_own, cache.file(second), cache.file(key)}) {
    BOOST_TEST(fs::exists(file), file);
  }
}

BOOST_AUTO_TEST_CASE(threads_that_store_and_load_one_key_see_whole_entries) {
  const TemporaryFolder folder;
  const DiskCache cache("test", 1, folder.path());
  BOOST_TEST(cache.store(key, std::string(5000, '0')).empty());
  std::vector<int> bad(4, 0);
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t) {
      threads.emplace_back([&, t] {
        for (int i = 0; i < 50; ++i) {
          if (!cache.store(key, std::string(5000, static_cast<char>('0' + t))).empty()) ++bad[t];
          const DiskCache::Found found = cache.load(key);
          if (!found.bytes || found.bytes->view().find_first_not_of(found.bytes->view().front()) != std::string::npos)
            ++bad[t];
        }
      });
    }
  }
  for (const int count : bad) BOOST_TEST(count == 0);
}

BOOST_AUTO_TEST_SUITE_END()
