// How much one file may cost whoever reads it: a small file must not fill the memory or keep the program for minutes.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

namespace tactor {

/// The program has been asked to end while it read a file.
class ReadingEnded : public std::runtime_error {
 public:
  explicit ReadingEnded(const std::string& file) : std::runtime_error("interrupted while " + file + " was read") {}
};

/// Lets every reader heed the requests to end the program: `count` gives how many there have been. It is called on the
/// thread that reads. Without it nothing ends a reader.
void heed_while_reading(int (*count)());

/// A run begins. From now on a request ends only the reading that it finds: what is read after it belongs to the
/// results of a run that the request has ended.
void heed_new_requests_alone();

/// The memory and work that one file may cost. A reader charges each thing that it makes of the file before it makes
/// it, and charges it again when it copies it. Nothing is given back, so that the budget bounds the work too. The
/// budget follows from the size of the file alone: what a header announces is worth nothing.
class ReadBudget {
 public:
  static constexpr std::uint64_t least = std::uint64_t{64} << 20U;    ///< bytes, for a file of any size
  static constexpr std::uint64_t per_byte = 64;                       ///< bytes for each byte of the file
  static constexpr std::uint64_t greatest = std::uint64_t{8} << 30U;  ///< bytes, whatever the size of the file
  static constexpr std::uint64_t step_cost = 4;                       ///< bytes that a step without memory counts for

  /// `file` names the file in messages; `file_bytes` is its size on the disk. `at_least`, in bytes, is for formats in
  /// which an honest file may pack a thousandfold.
  ReadBudget(std::string file, std::uint64_t file_bytes, std::uint64_t at_least = least);

  /// `bytes` more are about to be used, for what stands at `place` of the file (`:12`, `: cell 7`; may be empty).
  /// Throws InputError, beginning with the file and the place, if the budget does not hold them, and ReadingEnded if
  /// the program has been asked to end; once a run has begun, since the budget was made.
  void take(std::uint64_t bytes, const char* place = "") {
    if (!holds(bytes)) refuse(place);
  }
  void take(std::uint64_t bytes, const std::string& place) { take(bytes, place.c_str()); }
  /// The same, but false where the budget does not hold them.
  [[nodiscard]] bool holds(std::uint64_t bytes) {
    if (bytes > left_) return false;
    left_ -= bytes;
    if ((unseen_ += bytes) >= between_looks) look();
    return true;
  }
  /// A step of work that takes no memory: a value that is read and left out.
  void step() { take(step_cost); }

  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }
  [[nodiscard]] std::uint64_t used() const { return bytes_ - left_; }
  /// `reading it takes more than 64 MiB, ...`, for whoever uses `holds`.
  [[nodiscard]] std::string refusal() const;

 private:
  static constexpr std::uint64_t between_looks = std::uint64_t{1} << 18U;  // bytes: a millisecond or so

  [[noreturn]] void refuse(const char* place) const;
  void look();

  std::string file_;
  std::uint64_t file_bytes_, at_least_, bytes_, left_;
  std::uint64_t unseen_ = 0;  // bytes since the last look
  int asked_before_;
};

}  // namespace tactor
