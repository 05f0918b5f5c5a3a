#include "framework/realtime/mixed_filter.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "framework/core/check.hpp"
#include "framework/core/perception.hpp"
#include "framework/realtime/motion_filter.hpp"

namespace tactor {

namespace {

constexpr double even_from = 0.1;  // s of even intervals, from which on filters are mixed
// A tremor that is begun anew is taken to be less likely than the likeliest chain by this logarithm. It fades as all
// do, so that the tremor counts again after half a second.
constexpr double forgotten = 1e3;
constexpr double least_log = -14;  // of a likelihood by the largest: most kinds are as good as impossible

// How much what a hand feels of the error counts beside its mean square.
constexpr double weight_calm = 10;  // in a slow motion or a tremor
constexpr double weight_quick = 2;  // in a broad motion or a quick tremor, which hide some
constexpr double less_weight = 8;   // by this factor less from one chain to the next that is faster than `departure`
/// From this noise on, by departure. A finer encoder makes hardly any vibration, so there the error counts more.
constexpr double whole_from = 0.72;

// Each kind's sum is best for the spectrum of that kind alone. So a hand in broad motion is taken to move slowly too:
// else it would be shown too stiff at low frequencies. The slow motion moves a spring alone by this root of half the
// mean square, by the departure, as much in each octave. A broad motion of some mm/s passes for a quick tremor, which
// has little slow motion, because calm hands pay for it.
constexpr double slow_up_to = 5;  // Hz
constexpr double slow_of_broad = 1300;
constexpr double slow_of_quick_tremor = 65;

constexpr double stiffness_by_damping = 35;  // 1/s, k / b of a coupling
constexpr double handle_mass = 0.1;          // kg
constexpr double tail_from = 160;            // Hz; above, W grows with frequency
constexpr double first_frequency = 0.3;      // Hz, of the integrals
constexpr int frequencies = 120;

using Square = Eigen::MatrixXd;
using Line = Eigen::VectorXd;
using Responses = Eigen::VectorXcd;

struct Kind {
  MotionLaw law;
  double weight;    // of vibration
  double slow = 0;  // m or rad, of the slow motion beside it
};

constexpr std::array<double, 2> two_near(double frequency) {
  return {0.9 * frequency, 1.1 * frequency};
}

std::array<Kind, MixedFilter::models> kinds(double departure, double noise) {
  constexpr double sharp = 0.1, flat = 0.4;  // damping ratios of resonators
  const double d = departure, share = std::min(1.0, noise / (whole_from * d));
  std::array<Kind, MixedFilter::models> all;
  std::size_t n = 0;
  for (; n < MotionFilter::models; ++n) {
    const MotionFilter::Chain chain = MotionFilter::chain(n);
    all[n].law = {chain.order, chain.departure * d, 0, {}, 0};
    all[n].weight = weight_calm * std::pow(less_weight, -std::max(0.0, std::log2(chain.speed) / 2));
  }
  // On a hand that moves as chains do, or on one that hardly moves.
  for (const double moves : {d, 0.1 * d}) {
    for (const double frequency : {7.0, 10.0, 14.0}) {
      all[n++] = {{3, moves, 25 * d * 10 / frequency, two_near(frequency), sharp}, weight_calm};
    }
    all[n++] = {{3, moves, 75 * d, two_near(10), sharp}, weight_calm};
  }
  // Quick tremors of 13 and 16 Hz would show those of 12 to 18 Hz better, but a calm hand trembling at 7 Hz worse.
  all[n++] = {{3, 0.1 * d, 60 * d, two_near(19), sharp}, weight_quick, slow_of_quick_tremor * d};
  for (const double broad : {10 * d, 40 * d, 160 * d}) {
    all[n++] = {{3, 0.25 * d, broad, {6, 20}, flat}, weight_quick, slow_of_broad * d};
  }
  TACTOR_DEMAND(n == all.size());
  for (Kind& kind : all) kind.weight *= share;
  return all;
}

/// W^2, by its largest value up to tail_from.
double felt_squared(double frequency_Hz) {
  static const double least = [] {
    double smallest = vibration_force_threshold(tail_from, handle_mass);
    for (double f = 20; f < tail_from; f *= 1.05)
      smallest = std::min(smallest, vibration_force_threshold(f, handle_mass));
    return smallest;
  }();
  const double by = frequency_Hz > tail_from ? frequency_Hz / tail_from
                                             : least / vibration_force_threshold(frequency_Hz, handle_mass);
  return by * by;
}

}  // namespace

MixedFilter::MixedFilter(double departure, double noise, double nominal)
    : nominal_(nominal), chains_(departure, noise) {
  TACTOR_DEMAND(nominal <= longest);
  std::vector<Kind> used;
  std::vector<SteadyModel> steady;
  for (const Kind& kind : kinds(departure, noise)) {
    const bool trembles = kind.law.tremor > 0;
    const SteadyModel model(kind.law, noise, nominal);
    if (trembles && !model.slow()) continue;
    used.push_back(kind);
    steady.push_back(model);
    if (trembles) tremors_.push_back(model);
  }
  const auto count = static_cast<Eigen::Index>(used.size());
  std::vector<Square> A(used.size(), Square::Zero(count, count));
  Square missed_slowly = Square::Zero(count, count);  // of a slow motion whose mean square is 1
  int slow_frequencies = 0;
  const double last = 0.5 / nominal, first = std::min(first_frequency, last / 100);
  const double ratio = std::pow(last / first, 1.0 / frequencies);
  const double of_noise = noise * noise * nominal;
  for (int n = 0; n < frequencies; ++n) {
    const double low = first * std::pow(ratio, n), f = low * std::sqrt(ratio), w = 2 * std::numbers::pi * f;
    Responses error(count), H(count);
    for (Eigen::Index j = 0; j < count; ++j) {
      H[j] = steady[static_cast<std::size_t>(j)].response(w, stiffness_by_damping);
      error[j] = H[j] - std::complex<double>(stiffness_by_damping, w);
    }
    const Square moved = (error * error.adjoint()).real(), shaken = (H * H.adjoint()).real();
    const double width = low * (ratio - 1), felt = felt_squared(f);
    for (std::size_t i = 0; i < used.size(); ++i) {
      A[i] += width * (1 + used[i].weight * felt) * (steady[i].spectrum(w) * moved + of_noise * shaken);
    }
    if (f > slow_up_to) continue;
    missed_slowly += moved / (1 + w * w / (stiffness_by_damping * stiffness_by_damping));
    ++slow_frequencies;
  }
  for (std::size_t i = 0; i < used.size(); ++i) {
    A[i] += used[i].slow * used[i].slow / slow_frequencies * missed_slowly;
    // The filters are alike, so that the best sum is barely determined: none may count much. In units of each filter's
    // own error, because these may be many orders of magnitude apart.
    const Line unit = A[i].diagonal().cwiseSqrt().cwiseInverse();
    Square scaled = unit.asDiagonal() * A[i] * unit.asDiagonal();
    scaled.diagonal() += 1e-3 * A[i].diagonal().minCoeff() * unit.cwiseAbs2() + Line::Constant(count, 1e-9);
    const Line best = unit.cwiseProduct(scaled.llt().solve(unit));
    for (std::size_t j = 0; j < used.size(); ++j) mixing_[i][j] = best[static_cast<Eigen::Index>(j)] / best.sum();
  }
}

void MixedFilter::start(const Vec3& value) {
  chains_.start(value);
  for (SteadyModel& model : tremors_) model.start(value);
  likelihood_ = {};
  even_for_ = even_from;
  mix();
}

void MixedFilter::take(double interval, const Vec3& sample) {
  chains_.update(interval, sample);
  likelihood_.fade(interval);
  if (!SteadyModel::takes(interval, nominal_)) {
    even_for_ = 0;
    mix();
    const Vec3 unlikely = chains_.likelihood().most() - Vec3{forgotten, forgotten, forgotten};
    for (std::size_t i = 0; i < tremors_.size(); ++i) {
      tremors_[i].start(value_, rate_);
      likelihood_.set(chains + i, unlikely);
    }
    return;
  }
  even_for_ += interval;
  const SteadyModel::Lookup at = SteadyModel::find(interval, nominal_);
  for (std::size_t i = 0; i < tremors_.size(); ++i) {
    tremors_[i].predict(at);
    likelihood_.add(chains + i, tremors_[i].correct(at, sample));
  }
  mix();
}

void MixedFilter::count_from(const Vec3& value) {
  chains_.count_from(value);
  for (SteadyModel& model : tremors_) model.count_from(value);
  value_ += -1 * value;
}

bool MixedFilter::mixes() const {
  return even_for_ >= even_from;
}

void MixedFilter::mix() {
  if (!mixes()) {
    chains_.mix();
    value_ = chains_.value();
    rate_ = chains_.rate();
    return;
  }
  const std::size_t count = chains + tremors_.size();
  std::array<Vec3, models> values{}, rates{};
  for (std::size_t i = 0; i < chains; ++i) {
    likelihood_.set(i, chains_.likelihood().sum(i));
    values[i] = chains_.model(i).value();
    rates[i] = chains_.model(i).rate();
  }
  for (std::size_t i = chains; i < count; ++i) {
    values[i] = tremors_[i - chains].value();
    rates[i] = tremors_[i - chains].rate();
  }
  const Vec3 likeliest = likelihood_.most(count);
  for (int axis = 0; axis < 3; ++axis) {
    // Loops go over all models, so that the compiler knows their length. One that is not used has the share 0.
    std::array<double, models> share{};
    double whole = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const double log_p = likelihood_.sum(i)[axis] - likeliest[axis];
      if (log_p < least_log) continue;
      const double p = std::exp(log_p);
      whole += p;
      for (std::size_t j = 0; j < models; ++j) share[j] += p * mixing_[i][j];
    }
    double value = 0, rate = 0;
    for (std::size_t j = 0; j < models; ++j) {
      value += share[j] * values[j][axis];
      rate += share[j] * rates[j][axis];
    }
    value_[axis] = value / whole;
    rate_[axis] = rate / whole;
  }
}

}  // namespace tactor
