#include "devices/usb/calibration.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "framework/core/check.hpp"
#include "framework/core/random.hpp"

namespace tactor {

namespace {

constexpr const char* heading = "tactor calibration 1";

std::filesystem::path default_folder() {
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  if (runtime != nullptr && runtime[0] == '/') return std::filesystem::path(runtime) / "tactor";
  return std::filesystem::temp_directory_path() / ("tactor-" + std::to_string(geteuid()));
}

bool is_ours_alone(const std::filesystem::path& file) {
  struct stat status {};
  return lstat(file.c_str(), &status) == 0 && S_ISREG(status.st_mode) && status.st_uid == geteuid() &&
         (status.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

}  // namespace

CalibrationStore::CalibrationStore() : folder_(default_folder()) {}

std::filesystem::path CalibrationStore::file(const std::string& identity) const {
  char name[40];
  std::snprintf(name, sizeof name, "usb-%016llx.zero", static_cast<unsigned long long>(derive_seed(1, identity)));
  return folder_ / name;
}

std::optional<std::vector<double>> CalibrationStore::find(const std::string& identity, std::size_t axes) const {
  const std::filesystem::path path = file(identity);
  if (!is_ours_alone(path)) return std::nullopt;
  std::ifstream in(path);
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
  const std::filesystem::path path = file(identity);
  const std::string partly = path.string() + "." + std::to_string(getpid());
  std::error_code error;
  if (std::filesystem::create_directories(folder_, error)) {
    std::filesystem::permissions(folder_, std::filesystem::perms::owner_all, error);
  }
  {
    std::ofstream out(partly, std::ios::trunc);
    out.precision(17);
    out << heading << "\ndevice " << identity << "\ncounts";
    for (const double count : counts) out << ' ' << count;
    out << "\nend\n";
    if (!out.flush()) throw RunError("the calibration cannot be kept: " + partly + " cannot be written");
  }
  std::filesystem::permissions(partly, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write, error);
  std::filesystem::rename(partly, path, error);
  if (error) throw RunError("the calibration cannot be kept: " + path.string() + ": " + error.message());
}

void CalibrationStore::forget(const std::string& identity) const {
  std::error_code ignored;
  std::filesystem::remove(file(identity), ignored);
}

}  // namespace tactor
