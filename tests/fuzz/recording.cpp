// HDF5 recordings, as they are opened and read for replay and export: a good one with some of its bytes replaced.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

#include "framework/core/check.hpp"
#include "patched.hpp"
#include "require.hpp"
#include "tests/framework/record/recording_fixture.hpp"

// HDF5 itself leaks what it had made of a damaged file when it refuses it.
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libhdf5";
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactor;
  static const testing::Folder folder;
  static const std::string good = [] {
    const auto file = folder / "good.h5";
    const auto recorder = load_record_library().create(file, testing::header);
    testing::write_rows(*recorder, 20);
    recorder->close();
    return testing::bytes_of(file);
  }();
  const auto file = folder / "patched.h5";
  testing::write_bytes(file, fuzz::patched(good, data, size));
  try {
    const auto reader = load_record_library().open(file);
    for (std::size_t s = 0; s < reader->streams().size(); ++s) {
      const RecordedStream& stream = reader->streams()[s];
      fuzz::require(stream.count < 100'000'000, "a small file holds few messages");
      const std::uint64_t some = std::min<std::uint64_t>(stream.count, 1000);
      MessageBatch messages(stream.type);
      reader->read(s, 0, some, messages);
      fuzz::require(messages.size() == some, "each message is there");
      reader->read(s, stream.count - some, some, messages);
    }
  } catch (const InputError& error) {
    fuzz::require(error.what()[0] != '\0', "a refusal says why");
  }
  return 0;
}
