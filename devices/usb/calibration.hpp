// What the counters of a device showed in a known pose, kept as long as the device keeps its power.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace tactor {

/// Keeps records in `runtime_folder()`, with the rules of KeptFolder: a folder of this user, and files that no one else
/// may write. A record is found by the identity of the device (see UsbPort::identity), which changes when it is
/// unplugged and when the machine boots: a zero that was lost is not found again.
class CalibrationStore {
 public:
  CalibrationStore();
  explicit CalibrationStore(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// The counts in the pose of calibration, one an axis; nothing where there is no record for this device. Throws
  /// RunError where somebody else may have written the record.
  [[nodiscard]] std::optional<std::vector<double>> find(const std::string& identity, std::size_t axes) const;
  /// Throws RunError where the record cannot be written.
  void keep(const std::string& identity, const std::vector<double>& counts) const;
  /// Without an error, also where there is no record.
  void forget(const std::string& identity) const;
  [[nodiscard]] std::filesystem::path file(const std::string& identity) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace tactor
