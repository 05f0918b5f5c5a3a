#include "nodes/experiment/procedure.hpp"

#include <algorithm>
#include <boost/random/uniform_int_distribution.hpp>
#include <cmath>
#include <numeric>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

/// Fisher and Yates, by distributions that are the same on every platform.
template <class T>
void shuffle_all(std::vector<T>& list, boost::random::mt19937_64& random) {
  for (std::size_t left = list.size(); left > 1; --left) {
    boost::random::uniform_int_distribution<std::size_t> place(0, left - 1);
    std::swap(list[left - 1], list[place(random)]);
  }
}

}  // namespace

double staircase_target(int down) {
  return std::pow(0.5, 1.0 / down);
}

Staircase::Staircase(const StaircaseDesign& design) : design_(design), level_(design.start) {
  TACTOR_DEMAND(!design.steps.empty());
}

bool Staircase::is_over() const {
  return static_cast<int>(reversals_.size()) >= design_.reversals ||
         (design_.most_trials > 0 && trials_ >= design_.most_trials);
}

void Staircase::move(int direction) {
  if (direction_ != 0 && direction != direction_) reversals_.push_back(level_);
  direction_ = direction;
  const double step = design_.steps[std::min(reversals_.size(), design_.steps.size() - 1)];
  const double part = direction > 0 ? 1.0 : -design_.down_to_up;
  level_ = design_.scale == StepScale::linear ? level_ + part * step : level_ * std::pow(step, part);
  level_ = std::clamp(level_, design_.least, design_.most);
}

void Staircase::answer(bool right) {
  ++trials_;
  if (!right) {
    right_ = 0;
    return move(1);
  }
  if (++right_ < design_.down) return;
  right_ = 0;
  move(-1);
}

std::optional<double> Staircase::threshold() const {
  const auto averaged = static_cast<std::size_t>(design_.averaged);
  if (reversals_.size() < averaged) return std::nullopt;
  // A staircase that turned at a bound every other time did not find where the answers turn.
  const auto at_bound = [this](double level) { return level <= design_.least || level >= design_.most; };
  if (2 * std::count_if(reversals_.end() - design_.averaged, reversals_.end(), at_bound) >= design_.averaged) {
    return std::nullopt;
  }
  const bool is_log = design_.scale == StepScale::factor;
  const double sum = std::accumulate(reversals_.end() - design_.averaged, reversals_.end(), 0.0,
                                     [&](double s, double x) { return s + (is_log ? std::log(x) : x); });
  const double mean = sum / static_cast<double>(averaged);
  return is_log ? std::exp(mean) : mean;
}

std::vector<std::size_t> balanced_row(std::size_t n, std::size_t row) {
  // 0, 1, n - 1, 2, n - 2, ...: neighbours differ by every amount once.
  std::vector<std::size_t> list(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t first = i % 2 == 1 ? (i + 1) / 2 : (n - i / 2) % n;
    list[i] = (first + row) % n;
  }
  if (n % 2 == 1 && (row / n) % 2 == 1) std::reverse(list.begin(), list.end());
  return list;
}

Schedule::Schedule(const Design& design, std::uint64_t study_seed, std::uint64_t participant, std::uint64_t seed)
    : design_(design), random_(seed), order_(design.conditions) {
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  if (design.order == ConditionOrder::balanced) {
    std::vector<std::size_t> dealt = order_;
    boost::random::mt19937_64 study(study_seed);
    shuffle_all(dealt, study);
    const std::vector<std::size_t> row = balanced_row(order_.size(), participant);
    for (std::size_t i = 0; i < row.size(); ++i) order_[i] = dealt[row[i]];
  } else if (design.order == ConditionOrder::random) {
    shuffle_all(order_, random_);
  }
  blocks_ = design.procedure == Procedure::pairs ? 1 : order_.size();
  begin_block();
  choose_trial();
}

void Schedule::begin_block() {
  listed_.clear();
  next_ = 0;
  staircase_.reset();
  switch (design_.procedure) {
    case Procedure::staircase:
      staircase_.emplace(design_.staircase);
      return;
    case Procedure::constant:
      for (int repeat = 0; repeat < design_.repeats; ++repeat) {
        for (const double level : design_.levels) {
          listed_.push_back({block_, order_[block_], order_[block_], level, repeat % 2});
        }
      }
      break;
    case Procedure::pairs:
      for (int repeat = 0; repeat < design_.repeats; ++repeat) {
        for (std::size_t a = 0; a < design_.conditions; ++a) {
          for (std::size_t b = a + 1; b < design_.conditions; ++b) listed_.push_back({block_, a, b, 0, repeat % 2});
        }
      }
      break;
  }
  shuffle_all(listed_, random_);
}

void Schedule::choose_trial() {
  trial_.reset();
  while (block_ < blocks_) {
    if (staircase_ && !staircase_->is_over()) {
      boost::random::uniform_int_distribution<int> either(0, 1);
      const std::size_t condition = order_[block_];
      trial_ = Trial{block_, condition, condition, staircase_->level(), either(random_)};
      return;
    }
    if (!staircase_ && next_ < listed_.size()) {
      trial_ = listed_[next_++];
      return;
    }
    if (++block_ < blocks_) begin_block();
  }
}

void Schedule::answer(int interval) {
  TACTOR_DEMAND(trial_.has_value());
  if (staircase_) staircase_->answer(interval == trial_->comparison);
  choose_trial();
}

double Schedule::progress() const {
  if (!trial_) return 1;
  double part = 0;
  if (staircase_) {
    part = static_cast<double>(staircase_->reversals().size()) / std::max(1, design_.staircase.reversals);
  } else if (!listed_.empty()) {
    part = static_cast<double>(next_ - 1) / static_cast<double>(listed_.size());
  }
  return (static_cast<double>(block_) + part) / static_cast<double>(blocks_);
}

}  // namespace tactor
