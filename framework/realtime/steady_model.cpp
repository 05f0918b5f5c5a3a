#include "framework/realtime/steady_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include <Eigen/Dense>

#include "framework/core/check.hpp"
#include "framework/realtime/likelihood.hpp"

namespace tactor {

namespace {

constexpr double departure_time = 0.01;  // s
constexpr std::size_t resonator_states = 4;

constexpr double shortest = 0.02;  // time constant, by the interval

constexpr double slow_from = 0.5;  // an interval by the shortest time constant

// The table, in quarters of an octave to both sides of the nominal interval.
constexpr int rows_per_octave = 4, rows_to_a_side = 5;
constexpr std::size_t row_count = 2 * rows_to_a_side + 1;

/// The interval of a row of the table, by the nominal one.
double interval_of(int row) {
  return std::exp2(static_cast<double>(row - rows_to_a_side) / rows_per_octave);
}

constexpr auto most = static_cast<int>(SteadyModel::most_states);
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, most, most>;
using Column = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, most, 1>;
using Complex4 = std::array<std::complex<double>, 4>;

/// x' = A x + noise of the spectral density N.
struct Continuous {
  Matrix A, N;
};
/// One interval of it: x <- F x + noise of the covariance Q.
struct Discrete {
  Matrix F, Q;
};

/// By Taylor's series over a part of the interval, which is then doubled.
Discrete over(const Continuous& law, double interval) {
  const int doublings = std::max(0, static_cast<int>(std::ceil(std::log2(interval * law.A.norm()))) + 4);
  const double h = interval / std::exp2(doublings);
  const auto n = law.A.rows();
  Discrete d{Matrix::Identity(n, n), Matrix::Zero(n, n)};
  // The derivatives of F are A^k F, those of Q follow from Q' = A Q + Q A^T + N.
  Matrix term_F = d.F, term_Q = Matrix::Zero(n, n);
  for (int k = 1; k <= 12; ++k) {
    term_F = (h / k * law.A * term_F).eval();
    term_Q = (h / k * (law.A * term_Q + term_Q * law.A.transpose() + (k == 1 ? law.N : Matrix::Zero(n, n)))).eval();
    d.F += term_F;
    d.Q += term_Q;
  }
  for (int k = 0; k < doublings; ++k) {
    d.Q = (d.F * d.Q * d.F.transpose() + d.Q).eval();
    d.F = (d.F * d.F).eval();
  }
  return d;
}

Matrix chain(std::size_t order) {
  const auto n = static_cast<Eigen::Index>(order);
  Matrix A = Matrix::Zero(n, n);
  for (Eigen::Index i = 0; i + 1 < n; ++i) A(i, i + 1) = 1;
  return A;
}

/// Both resonators pass on what is far below their frequencies. `unit`: s, of time.
Matrix resonators(const MotionLaw& law, double unit) {
  Matrix A = Matrix::Zero(resonator_states, resonator_states);
  for (Eigen::Index i = 0; i < 2; ++i) {
    const double w = 2 * std::numbers::pi * law.frequencies[static_cast<std::size_t>(i)] * unit;
    A(2 * i, 2 * i + 1) = 1;
    A(2 * i + 1, 2 * i) = -w * w;
    A(2 * i + 1, 2 * i + 1) = -2 * law.damping * w;
    if (i > 0) A(2 * i + 1, 2 * i - 2) = w * w;
  }
  return A;
}

/// The noise into the state `into` of n.
Matrix noise_into(Eigen::Index n, Eigen::Index into, double density) {
  Matrix N = Matrix::Zero(n, n);
  N(into, into) = density;
  return N;
}

/// The variance, before a sample, that a filter settles at; samples are C x with the variance `r`. By the doubling
/// algorithm (E. Chu, H. Fan, W. Lin, J. Wang, "Structure-preserving algorithms for periodic discrete-time algebraic
/// Riccati equations", Int. J. Control 77, 2004).
Matrix settled(const Discrete& d, const Column& C, double r) {
  const auto n = d.F.rows();
  Matrix A = d.F.transpose(), G = C * C.transpose() / r, H = d.Q;
  for (int k = 0; k < 40; ++k) {
    const Eigen::PartialPivLU<Matrix> W(Matrix::Identity(n, n) + G * H);
    const Matrix WA = W.solve(A), WG = W.solve(G);
    const Matrix grown = A.transpose() * H * WA;
    G = (G + A * WG * A.transpose()).eval();
    H = (H + grown).eval();
    G = (0.5 * (G + G.transpose())).eval();
    H = (0.5 * (H + H.transpose())).eval();
    A = (A * WA).eval();
    if (grown.norm() <= 1e-14 * H.norm()) break;
  }
  return H;
}

struct Update {
  Column gain;
  double variance;  // of the innovation
};

Update update_of(const Matrix& P, const Column& C, double r) {
  const Column to_sample = P * C;
  const double variance = C.dot(to_sample) + r;
  return {to_sample / variance, variance};
}

/// The variance after a sample, in Joseph's form, which stays positive.
Matrix updated(const Matrix& P, const Column& C, double r) {
  const Column gain = update_of(P, C, r).gain;
  const Matrix kept = Matrix::Identity(P.rows(), P.rows()) - gain * C.transpose();
  return kept * P * kept.transpose() + r * gain * gain.transpose();
}

}  // namespace

SteadyModel::SteadyModel(const MotionLaw& law, double noise, double nominal)
    : order_(law.order),
      states_(law.order + (law.tremor > 0 ? resonator_states : 0)),
      tremor_(law.tremor > 0),
      law_(law),
      nominal_(nominal) {
  TACTOR_DEMAND(law.departure > 0 && noise > 0 && nominal > 0 && (law.order == 3 || law.order == 4));
  TACTOR_DEMAND(!tremor_ || (law.order == 3 && law.frequencies[0] > 0 && law.frequencies[1] > 0 && law.damping > 0));
  const auto n = static_cast<Eigen::Index>(states_), m = static_cast<Eigen::Index>(order_);
  const Matrix integrators = chain(order_);
  // The filter's time constant is (noise^2 T / q)^(1 / 2n). One that is much shorter than the interval makes no
  // difference: such a filter takes each sample as it is.
  const double exponent = 0.5 / static_cast<double>(order_), by_density = noise * noise * nominal;
  density_ =
      std::min(law.departure * law.departure / over({integrators, noise_into(m, m - 1, 1)}, departure_time).Q(0, 0),
               by_density / std::pow(shortest * nominal, 1 / exponent));
  // Time is counted in units of the filter's own, and values in those of the noise, so that all states are of one size.
  const double time_constant = std::pow(by_density / density_, exponent), unit = std::max(nominal, time_constant);
  double quickest = 1 / time_constant;
  Column size = Column::Constant(n, noise);
  for (Eigen::Index i = 1; i < m; ++i) size[i] = size[i - 1] / unit;
  if (tremor_) size[m + 1] = size[m + 3] = noise / unit;

  Continuous whole{Matrix::Zero(n, n), Matrix::Zero(n, n)};
  whole.A.topLeftCorner(m, m) = integrators;
  whole.N(m - 1, m - 1) = density_ * unit / (size[m - 1] * size[m - 1]);
  Column C = Column::Zero(n);
  C[0] = 1;
  if (tremor_) {
    const Matrix A = resonators(law, unit);
    // At rest for long: its mean square for noise of density 1.
    Discrete rest = over({A, noise_into(resonator_states, 1, 1)}, 1 / A.norm());
    for (int k = 0; k < 60 && rest.F.norm() > 1e-14; ++k) {
      rest.Q = (rest.F * rest.Q * rest.F.transpose() + rest.Q).eval();
      rest.F = (rest.F * rest.F).eval();
    }
    const double density = law.tremor * law.tremor / (noise * noise) / rest.Q(2, 2);
    tremor_density_ = density * noise * noise / (unit * unit * unit);
    // Above its frequencies the tremor is a chain of four.
    const double rate = 2 * std::numbers::pi * law.frequencies[1];
    quickest = std::max({quickest, rate, std::pow(tremor_density_ * std::pow(rate, 4) / by_density, 1.0 / 8)});
    whole.A.bottomRightCorner(resonator_states, resonator_states) = A;
    whole.N(m + 1, m + 1) = density;
    C[m + 2] = 1;
  }
  slow_ = nominal * quickest <= slow_from;
  const Matrix before = settled(over(whole, nominal / unit), C, 1);
  const Matrix after = updated(before, C, 1);
  rows_.resize(row_count);
  for (std::size_t k = 0; k < row_count; ++k) {
    const double interval = nominal * interval_of(static_cast<int>(k));
    const Discrete d = over(whole, interval / unit);
    const Update update = update_of(d.F * after * d.F.transpose() + d.Q, C, 1);
    Row& row = rows_[k];
    for (Eigen::Index i = 0; i < n; ++i) row.gain[static_cast<std::size_t>(i)] = update.gain[i] * size[i] / noise;
    row.by_deviation = 1 / (noise * std::sqrt(update.variance));
    row.log_variance = std::log(update.variance);
    if (!tremor_) continue;
    for (Eigen::Index i = 0; i < 4; ++i) {
      for (Eigen::Index j = 0; j < 4; ++j) {
        row.F[static_cast<std::size_t>(4 * i + j)] = d.F(m + i, m + j) * size[m + i] / size[m + j];
      }
    }
  }
}

bool SteadyModel::takes(double interval, double nominal) {
  const double by = interval / nominal;
  return by > interval_of(0) && by < interval_of(row_count - 1);
}

SteadyModel::Lookup SteadyModel::find(double interval, double nominal) {
  const double octaves = std::log2(interval / nominal);
  const int row = std::clamp(static_cast<int>(std::floor(octaves * rows_per_octave + 1e-9)) + rows_to_a_side, 0,
                             static_cast<int>(row_count) - 2);
  // Straight in the interval, so that what goes with it is exact between rows.
  const double low = nominal * interval_of(row), high = nominal * interval_of(row + 1);
  return {static_cast<std::size_t>(row), std::clamp((interval - low) / (high - low), 0.0, 1.0), interval};
}

void SteadyModel::start(const Vec3& value, const Vec3& rate) {
  state_ = {value, rate};
}

void SteadyModel::predict(const Lookup& at) {
  const double T = at.interval;
  if (order_ == 4) {
    state_[0] += T * (state_[1] + T / 2 * (state_[2] + T / 3 * state_[3]));
    state_[1] += T * (state_[2] + T / 2 * state_[3]);
    state_[2] += T * state_[3];
  } else {
    state_[0] += T * (state_[1] + T / 2 * state_[2]);
    state_[1] += T * state_[2];
  }
  if (!tremor_) return;
  const Row &a = rows_[at.row], &b = rows_[at.row + 1];
  std::array<Vec3, 4> next;
  for (std::size_t i = 0; i < 4; ++i) {
    // The first resonator is not moved by the second.
    for (std::size_t j = 0; j < (i < 2 ? 2 : 4); ++j) {
      const double F = a.F[4 * i + j] + at.share * (b.F[4 * i + j] - a.F[4 * i + j]);
      next[i] += F * state_[3 + j];
    }
  }
  std::copy(next.begin(), next.end(), state_.begin() + 3);
}

Vec3 SteadyModel::correct(const Lookup& at, const Vec3& sample) {
  const Row &a = rows_[at.row], &b = rows_[at.row + 1];
  const auto between = [&](double low, double high) { return low + at.share * (high - low); };
  const Vec3 innovation = sample - value();
  for (std::size_t i = 0; i < states_; ++i) state_[i] += between(a.gain[i], b.gain[i]) * innovation;
  return log_likelihood(between(a.by_deviation, b.by_deviation) * innovation, between(a.log_variance, b.log_variance));
}

std::complex<double> SteadyModel::response(double angular_frequency, double stiffness) const {
  const Row& row = rows_[find(nominal_, nominal_).row];
  // x_k = (I - K C^T) F x_(k-1) + K z_k, and y = (I - F / z)^-1 K solves it up to a factor, block by block: the rest
  // has rank one.
  const std::complex<double> back = std::polar(1.0, -angular_frequency * nominal_);
  Complex4 y{};
  for (std::size_t i = order_; i-- > 0;) {
    y[i] = row.gain[i];
    double step = 1;
    for (std::size_t j = i + 1; j < order_; ++j) {
      step *= nominal_ / static_cast<double>(j - i);
      y[i] += back * step * y[j];
    }
    y[i] /= 1.0 - back;
  }
  std::complex<double> shown = y[0], force = stiffness * y[0] + y[1];
  double gain = row.gain[0];
  if (tremor_) {
    // The first resonator drives the second, each of two states.
    Complex4 tremor{};
    for (std::size_t i = 0; i < 4; i += 2) {
      const auto F = [&](std::size_t to, std::size_t from) { return back * row.F[4 * to + from]; };
      std::complex<double> p = row.gain[order_ + i], v = row.gain[order_ + i + 1];
      for (std::size_t j = 0; j < i; ++j) p += F(i, j) * tremor[j], v += F(i + 1, j) * tremor[j];
      const std::complex<double> of_p = 1.0 - F(i, i), of_v = 1.0 - F(i + 1, i + 1);
      const std::complex<double> both = of_p * of_v - F(i, i + 1) * F(i + 1, i);
      tremor[i] = (of_v * p + F(i, i + 1) * v) / both;
      tremor[i + 1] = (F(i + 1, i) * p + of_p * v) / both;
    }
    shown += tremor[2];
    force += stiffness * tremor[2] + tremor[3];
    gain += row.gain[order_ + 2];
  }
  return force / (1.0 + shown - gain);
}

double SteadyModel::spectrum(double angular_frequency) const {
  double density = density_ / std::pow(angular_frequency, 2 * static_cast<double>(order_));
  if (tremor_) {
    double of_tremor = tremor_density_ / std::pow(2 * std::numbers::pi * law_.frequencies[0], 4);
    for (const double frequency : law_.frequencies) {
      const double by = angular_frequency / (2 * std::numbers::pi * frequency);
      of_tremor /= std::norm(std::complex<double>(1 - by * by, 2 * law_.damping * by));
    }
    density += of_tremor;
  }
  return density;
}

}  // namespace tactor
