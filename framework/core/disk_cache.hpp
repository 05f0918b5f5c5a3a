// A cache on disk for bytes that are expensive to compute, under the hash of their inputs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "framework/core/large_vector.hpp"
#include "framework/core/user_folders.hpp"

namespace tactor {

/// A key over the parts, in their order: XXH3, 128 bits, as 32 hexadecimal digits. Each part counts with its length, so
/// that different lists give different keys.
std::string content_key(std::initializer_list<std::string_view> parts);

/// Likewise over the bytes of a file, of any size; `missing` where it cannot be read.
std::string file_key(const std::filesystem::path& file);

/// One file an entry, `FOLDER/KEY.KIND`. A file holds a magic, the version of the layout, the size and a checksum over
/// all of these, the kind, the key and the bytes, so what `load` returns is what `store` was given. Several processes
/// and threads may use one folder: a file appears whole or not at all. Only a folder of the user's own is used (see
/// KeptFolder), because the checksum detects damage but not forgery by another user. The caller still checks every
/// count and index of an entry. Trouble with the disk is never an error, because everything in a cache can be computed
/// again; it is a note for the user.
class DiskCache {
 public:
  /// `kind`: what the bytes are, in lower-case letters. `version`: of their layout and of the code that makes them;
  /// entries of another version count as absent.
  DiskCache(std::string kind, std::uint32_t version, std::filesystem::path folder = default_cache_folder());

  /// The bytes of an entry, not set to zero first, which takes longer than to read them.
  class Bytes {
   public:
    /// They have no values yet.
    explicit Bytes(std::size_t size) : data_(LargeAllocator<char>().allocate(size), Free{size}) {}
    [[nodiscard]] char* data() { return data_.get(); }
    [[nodiscard]] std::string_view view() const { return {data_.get(), data_.get_deleter().size}; }

   private:
    struct Free {
      std::size_t size;
      void operator()(char* data) const { LargeAllocator<char>().deallocate(data, size); }
    };
    std::unique_ptr<char, Free> data_;
  };

  struct Found {
    std::optional<Bytes> bytes;  ///< empty if there is no entry or it fails its checks
    std::string note;            ///< why an existing entry was not used; otherwise empty
  };
  [[nodiscard]] Found load(const std::string& key) const;

  /// Returns a note if the entry cannot be written, otherwise an empty text.
  [[nodiscard]] std::string store(const std::string& key, std::string_view bytes) const;

  [[nodiscard]] std::filesystem::path file(const std::string& key) const;

 private:
  std::string kind_;
  std::uint32_t version_;
  std::filesystem::path folder_;
};

}  // namespace tactor
