// A long curve in bounded memory: of each piece of it the least and the largest value.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "framework/node/report.hpp"

namespace tactor {

/// Takes values in the order of their times. It keeps at most `most_pieces` pieces of equally many values (at least 2),
/// so that no peak gets lost.
class Envelope {
 public:
  explicit Envelope(std::size_t most_pieces) : most_pieces_(most_pieces) {}

  /// Leaves out a value that is not finite.
  void add(double time_s, double value);
  [[nodiscard]] bool empty() const { return pieces_.empty(); }
  /// The values that were kept, by time; each value where it has no more than `most_pieces`.
  [[nodiscard]] Series series(std::string name, std::string unit) const;

 private:
  struct Sample {
    double time_s = 0, value = 0;
  };
  struct Piece {
    Sample low, high;
    std::size_t count = 0;
  };
  static void extend(Piece& piece, const Piece& by);

  std::size_t most_pieces_;
  std::size_t count_of_piece_ = 1;
  std::vector<Piece> pieces_;
};

}  // namespace tactor
