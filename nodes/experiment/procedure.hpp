// The order of the trials of an experiment with a person, as a function of its design, a seed and the answers.
#pragma once

#include <boost/random/mersenne_twister.hpp>
#include <cstdint>
#include <optional>
#include <vector>

namespace tactor {

enum class Procedure : std::uint8_t {
  staircase,  ///< the level follows the answers
  constant,   ///< fixed levels, each several times, in random order
  pairs,      ///< conditions against each other, without a level
};

enum class StepScale : std::uint8_t {
  linear,  ///< a step adds
  factor,  ///< a step multiplies
};

enum class ConditionOrder : std::uint8_t { balanced, random, as_listed };

/// A transformed up-down staircase (Levitt 1971): the level falls by a step after `down` right answers in a row and
/// rises by a step after a wrong one.
struct StaircaseDesign {
  double start = 0;           ///< the first level
  std::vector<double> steps;  ///< the step up until the first reversal, the second, ...; the last one stays
  StepScale scale = StepScale::linear;
  int down = 2;
  double down_to_up = 1;       ///< a step down as a part of a step up; of a factor: of its logarithm
  double least = 0, most = 0;  ///< bounds of the level
  int reversals = 8;           ///< it ends after so many
  int averaged = 6;            ///< the threshold is the mean of the levels at the last so many reversals
  int most_trials = 0;         ///< and after so many trials at the latest
};

/// The share of right answers at which a staircase rests whose steps up and down are small and equal: p^down = 1/2
/// (Levitt 1971).
double staircase_target(int down);

class Staircase {
 public:
  explicit Staircase(const StaircaseDesign& design);
  [[nodiscard]] double level() const { return level_; }
  [[nodiscard]] bool is_over() const;
  void answer(bool right);
  /// The levels at which the direction changed.
  [[nodiscard]] const std::vector<double>& reversals() const { return reversals_; }
  /// The mean of the last `averaged` reversals, of a factor the geometric mean; none before there are so many, and
  /// where half of them are at `least` or `most`.
  [[nodiscard]] std::optional<double> threshold() const;

 private:
  void move(int direction);

  StaircaseDesign design_;
  double level_;
  int right_ = 0;      // in a row
  int direction_ = 0;  // of the last step, -1 or 1
  int trials_ = 0;
  std::vector<double> reversals_;
};

struct Design {
  Procedure procedure = Procedure::staircase;
  std::size_t conditions = 1;
  ConditionOrder order = ConditionOrder::balanced;
  StaircaseDesign staircase;
  std::vector<double> levels;  ///< of Procedure::constant
  int repeats = 1;             ///< of each level, or of each pair
};

/// Two intervals, one after the other. The comparison has the level, or is the first condition of a pair.
struct Trial {
  std::size_t block = 0;
  std::size_t condition = 0;  ///< of the comparison; index into the conditions of the design
  std::size_t other = 0;      ///< of the other interval; the same one except in pairs
  double level = 0;           ///< of the comparison; 0 in pairs
  int comparison = 0;         ///< the interval that holds it: 0 the first, 1 the second
  bool operator==(const Trial&) const = default;
};

/// Row `row` of a square in which each of n conditions is at every place equally often and follows every other one
/// equally often (Williams 1949): over n rows where n is even, over 2 n where it is odd. Rows repeat.
std::vector<std::size_t> balanced_row(std::size_t n, std::size_t row);

/// The trials of one participant.
class Schedule {
 public:
  /// `study_seed`: the same for all participants, which deals the conditions out over the square. `participant`: their
  /// number, which chooses the row. `seed`: of the participant's own draws.
  Schedule(const Design& design, std::uint64_t study_seed, std::uint64_t participant, std::uint64_t seed);

  /// The trial that is to be made; null where all are done.
  [[nodiscard]] const Trial* trial() const { return trial_ ? &*trial_ : nullptr; }
  /// Its answer: the interval that was chosen. The next trial follows from it.
  void answer(int interval);
  [[nodiscard]] std::size_t blocks() const { return blocks_; }
  /// The conditions in the order of their blocks.
  [[nodiscard]] const std::vector<std::size_t>& order() const { return order_; }
  /// Of the newest staircase, where there is one.
  [[nodiscard]] std::optional<double> threshold() const { return staircase_ ? staircase_->threshold() : std::nullopt; }
  /// How much is done, 0 to 1; a staircase counts by its reversals.
  [[nodiscard]] double progress() const;

 private:
  void begin_block();
  void choose_trial();

  Design design_;
  boost::random::mt19937_64 random_;
  std::vector<std::size_t> order_;
  std::size_t blocks_ = 0, block_ = 0;
  std::vector<Trial> listed_;  // of the block, where its trials are known beforehand
  std::size_t next_ = 0;
  std::optional<Staircase> staircase_;
  std::optional<Trial> trial_;
};

}  // namespace tactor
