#include "devices/usb/calibration.hpp"

#include <sys/stat.h>

#include <cmath>
#include <cstdio>
#include <sstream>

#include "framework/core/check.hpp"
#include "framework/core/kept_folder.hpp"
#include "framework/core/random.hpp"
#include "framework/core/user_folders.hpp"

namespace tactor {

namespace {

constexpr const char* heading = "tactor calibration 1";

/// No record is longer: every axis takes less than 30 characters.
constexpr std::size_t most_bytes = 1 << 14;

}  // namespace

CalibrationStore::CalibrationStore() : folder_(runtime_folder()) {}

std::filesystem::path CalibrationStore::file(const std::string& identity) const {
  char name[40];
  std::snprintf(name, sizeof name, "usb-%016llx.zero", static_cast<unsigned long long>(derive_seed(1, identity)));
  return folder_ / name;
}

std::optional<std::vector<double>> CalibrationStore::find(const std::string& identity, std::size_t axes) const {
  const std::optional<KeptFolder> folder = KeptFolder::find(folder_);
  if (!folder) return std::nullopt;
  const std::optional<FileDescriptor> opened = folder->open(file(identity).filename().string());
  if (!opened) return std::nullopt;
  struct stat status {};
  if (::fstat(opened->number(), &status) != 0 || status.st_size > static_cast<off_t>(most_bytes)) return std::nullopt;
  std::string bytes(static_cast<std::size_t>(status.st_size), '\0');
  if (!opened->read_all(bytes.data(), bytes.size())) return std::nullopt;
  std::istringstream in(bytes);
  std::string first, whose, line;
  if (!std::getline(in, first) || first != heading) return std::nullopt;
  if (!std::getline(in, whose) || whose != "device " + identity) return std::nullopt;
  if (!std::getline(in, line) || !line.starts_with("counts ")) return std::nullopt;
  std::istringstream numbers(line.substr(7));
  std::vector<double> counts;
  for (double count = 0; numbers >> count;) {
    if (!std::isfinite(count)) return std::nullopt;
    counts.push_back(count);
  }
  // The last line: a record that was cut off has none.
  if (!numbers.eof() || counts.size() != axes || !std::getline(in, line) || line != "end") return std::nullopt;
  return counts;
}

void CalibrationStore::keep(const std::string& identity, const std::vector<double>& counts) const {
  std::ostringstream out;
  out.precision(17);
  out << heading << "\ndevice " << identity << "\ncounts";
  for (const double count : counts) out << ' ' << count;
  out << "\nend\n";
  try {
    KeptFolder::make(folder_).write(file(identity).filename().string(), {out.view()});
  } catch (const RunError& error) {
    throw RunError(std::string("the calibration cannot be kept: ") + error.what());
  }
}

void CalibrationStore::forget(const std::string& identity) const {
  try {
    if (const auto folder = KeptFolder::find(folder_)) folder->remove(file(identity).filename().string());
  } catch (const RunError&) {
    // `find` refuses such a folder, and a device without power has another identity when it comes back.
  }
}

}  // namespace tactor
