// What a node on the way of the force could not use, counted by reason.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace tactor {

/// Why a message cannot be used.
enum class RefusalReason : std::uint8_t {
  none,
  not_finite,     ///< a value is NaN, infinite or out of range
  too_many,       ///< it counts more items than its array has, or fewer than none
  another_scene,  ///< it is of other bodies than those of the scene
  incomplete,     ///< what belongs to it has not come
  late,           ///< it is no newer than one before
  unsolved,       ///< the step from it on did not converge
};
/// In words, by reason. Of too_many the numbers are told.
inline constexpr auto refusal_words =
    std::to_array<std::string_view>({"", "not finite", "", "of another scene", "not complete",
                                     "no newer than one before", "its step did not converge"});
inline constexpr std::size_t refusal_count = refusal_words.size();

/// The messages of one kind that came to a node, and why it refused some. Allocates nothing.
class Refusals {
 public:
  /// `what`: `results`, `forces`, ...; `items`: what a message counts, `contacts`. Both outlive the object.
  explicit constexpr Refusals(const char* what, const char* items = "items") : what_(what), items_(items) {}

  /// One has come; `why` is none where it is used.
  void count(RefusalReason why) noexcept {
    ++came_;
    if (why != RefusalReason::none) ++refused_[static_cast<std::size_t>(why)];
  }
  /// One was refused because it counts `found` items where there is room for `room`.
  void count_too_many(std::int64_t found, std::int64_t room) noexcept {
    count(RefusalReason::too_many);
    found_ = found;
    room_ = room;
  }

  [[nodiscard]] const char* what() const { return what_; }
  [[nodiscard]] const char* items() const { return items_; }
  [[nodiscard]] std::uint64_t came() const { return came_; }
  [[nodiscard]] std::uint64_t refused(RefusalReason why) const { return refused_[static_cast<std::size_t>(why)]; }
  [[nodiscard]] std::uint64_t refused() const {
    std::uint64_t sum = 0;
    for (const std::uint64_t n : refused_) sum += n;
    return sum;
  }
  [[nodiscard]] std::int64_t found() const { return found_; }  ///< items of the newest that had too many
  [[nodiscard]] std::int64_t room() const { return room_; }

 private:
  const char* what_;
  const char* items_;
  std::uint64_t came_ = 0;
  std::array<std::uint64_t, refusal_count> refused_{};
  std::int64_t found_ = 0, room_ = 0;
};

/// A node that refuses messages and tells how many; asked after a run.
class Refusing {
 public:
  Refusing() = default;
  Refusing(const Refusing&) = delete;
  Refusing& operator=(const Refusing&) = delete;
  virtual ~Refusing();
  [[nodiscard]] virtual const Refusals& refusals() const = 0;
};

}  // namespace tactor
