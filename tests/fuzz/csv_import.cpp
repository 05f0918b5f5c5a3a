// Streams as comma-separated values, read back as messages with records, enumerations and arrays that change size.
#include <cstddef>
#include <cstdint>
#include <fstream>

#include "framework/core/check.hpp"
#include "framework/core/message_batch.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/record/csv.hpp"
#include "require.hpp"
#include "tests/scan_nodes/scan.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactor;
  static const TemporaryFolder folder;
  const auto file = folder.path() / "stream.csv";
  std::ofstream(file, std::ios::binary).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    import_csv(file, message_type<Scan>(), [size](const Stamp&, const void* value) {
      const auto& scan = *static_cast<const Scan*>(value);
      fuzz::require(
          scan.quality == ScanQuality::good || scan.quality == ScanQuality::dusty || scan.quality == ScanQuality::blind,
          "an enumeration has a value of its own");
      // An element takes five numbers, with a character each.
      fuzz::require(scan.points.size() <= size, "an array is no longer than its text");
      double sum = 0;
      for (const ScanPoint& point : scan.points) sum += point.p_SP.x + point.brightness;
      static_cast<void>(sum);
    });
  } catch (const InputError& error) {
    fuzz::require(error.what()[0] != '\0', "a refusal says why");
  }
  return 0;
}
