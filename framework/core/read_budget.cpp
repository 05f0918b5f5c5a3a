#include "framework/core/read_budget.hpp"

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <utility>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

std::atomic<int (*)()> requests_to_end = nullptr;
std::atomic<bool> new_requests_alone = false;

int times_asked_to_end() {
  const auto count = requests_to_end.load();
  return count == nullptr ? 0 : count();
}

}  // namespace

void heed_while_reading(int (*count)()) {
  requests_to_end = count;
}

void heed_new_requests_alone() {
  new_requests_alone = true;
}

ReadBudget::ReadBudget(std::string file, std::uint64_t file_bytes, std::uint64_t at_least)
    : file_(std::move(file)),
      file_bytes_(file_bytes),
      at_least_(at_least),
      bytes_(std::clamp(std::min(file_bytes, greatest) * per_byte, at_least, greatest)),
      left_(bytes_),
      asked_before_(new_requests_alone ? times_asked_to_end() : 0) {}

std::string ReadBudget::refusal() const {
  char text[200];
  std::snprintf(text, sizeof text,
                "expected a file that takes at most %.0f MiB to read (%.0f MiB or %.0f times its size, at most %.0f "
                "GiB), found one of %.3g MB that takes more; it repeats or packs too much",
                static_cast<double>(bytes_) / 0x1p20, static_cast<double>(at_least_) / 0x1p20,
                static_cast<double>(per_byte), static_cast<double>(greatest) / 0x1p30,
                static_cast<double>(file_bytes_) / 1e6);
  return text;
}

void ReadBudget::refuse(const char* place) const {
  throw InputError(file_ + place + ": " + refusal());
}

void ReadBudget::look() {
  unseen_ = 0;
  if (times_asked_to_end() > asked_before_) throw ReadingEnded(file_);
}

}  // namespace tactor
