#include "app/run/envelope.hpp"

#include <cmath>
#include <utility>

namespace tactor {

void Envelope::extend(Piece& piece, const Piece& by) {
  if (by.low.value < piece.low.value) piece.low = by.low;
  if (by.high.value > piece.high.value) piece.high = by.high;
  piece.count += by.count;
}

void Envelope::add(double time_s, double value) {
  if (!std::isfinite(value)) return;
  const Sample sample{time_s, value};
  const Piece single{sample, sample, 1};
  if (!pieces_.empty() && pieces_.back().count < count_of_piece_) return extend(pieces_.back(), single);
  if (pieces_.size() == most_pieces_) {
    for (std::size_t i = 0; i + 1 < pieces_.size(); i += 2) {
      extend(pieces_[i], pieces_[i + 1]);
      pieces_[i / 2] = pieces_[i];
    }
    if (pieces_.size() % 2 == 1) pieces_[pieces_.size() / 2] = pieces_.back();
    pieces_.resize((pieces_.size() + 1) / 2);
    count_of_piece_ *= 2;
    return add(time_s, value);
  }
  pieces_.push_back(single);
}

Series Envelope::series(std::string name, std::string unit) const {
  Series series{std::move(name), std::move(unit), {}, {}};
  const auto put = [&series](const Sample& sample) {
    series.time.push_back(sample.time_s);
    series.value.push_back(sample.value);
  };
  for (const Piece& piece : pieces_) {
    const bool low_first = piece.low.time_s < piece.high.time_s;
    put(low_first ? piece.low : piece.high);
    if (piece.low.time_s != piece.high.time_s || piece.low.value != piece.high.value)
      put(low_first ? piece.high : piece.low);
  }
  return series;
}

}  // namespace tactor
