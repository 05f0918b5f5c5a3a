// Tables of comma-separated values, plain or compressed, and what becomes of their columns.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <fstream>

#include "framework/core/check.hpp"
#include "framework/core/temporary_folder.hpp"
#include "nodes/source/columns.hpp"
#include "nodes/source/csv_table.hpp"
#include "require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactor;
  static const TemporaryFolder folder;
  const auto file = folder.path() / "table.csv";
  std::ofstream(file, std::ios::binary).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    const CsvTable table = read_csv(file);
    fuzz::require(table.values.size() == table.rows() * table.columns.size(), "rows are whole");
    for (const double value : table.values) fuzz::require(std::isfinite(value), "numbers are finite");
    const std::string last = table.columns.back().heading;
    const MappedMessages messages = map_columns(
        table,
        {{"time", table.columns[0].heading + " [s]"}, {"force.x", last + " [N]"}, {"position.y", last + " [mm]"}},
        "columns");
    fuzz::require(messages.force.size() == table.rows(), "each row gives a message");
  } catch (const InputError& error) {
    fuzz::require(error.what()[0] != '\0', "a refusal says why");
  }
  return 0;
}
