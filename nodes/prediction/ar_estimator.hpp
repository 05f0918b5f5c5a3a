// The methods that fit an auto-regressive model to a stream of vectors, behind one door.
#pragma once

#include <optional>

#include "nodes/prediction/ar_coefficients.hpp"
#include "nodes/prediction/autoregression.hpp"
#include "nodes/prediction/least_squares.hpp"
#include "nodes/prediction/sample_window.hpp"

namespace tactor {

enum class ArMethod { yule_walker, burg, covariance, rls };

struct ArEstimatorOptions {
  ArMethod method = ArMethod::yule_walker;
  std::size_t window = 300;  ///< samples; of no meaning for rls
  int max_order = 20;
  bool remove_mean = false;  ///< not for rls
  double forgetting = 0.99;  ///< of rls
};

/// One stream and its method, with scalar products over the axes. Nothing allocates after construction.
class ArEstimator {
 public:
  explicit ArEstimator(const ArEstimatorOptions& options);

  /// Needs a sample whose square is finite.
  void push(const Vec3& x);
  /// Takes the oldest sample out of the window; not for rls.
  void drop_oldest() { window_->drop_oldest(); }
  /// The samples that a model would be fitted to; for rls the sum of their weights.
  [[nodiscard]] double samples() const;
  /// Fits a model of order `order`, or with 0 of the one that `rule` chooses, up to a third of the samples at most.
  /// Order 0 where the samples hold no energy, or are too few for the order. A model of least squares with a root on or
  /// outside the unit circle is replaced: for the covariance method by that of Yule and Walker, for rls by the same
  /// coefficients with phi_i shrunk by shrink^i, shrink = 0.98, 0.98^2, ... until every root is inside; `unstable`
  /// tells.
  ArFit fit(int order, OrderRule rule, bool& unstable);

 private:
  ArFit fit_window(const OrderOptions& options, bool& unstable);

  ArEstimatorOptions options_;
  std::optional<AutocovarianceWindow> window_;
  std::optional<RecursiveEquations> recursion_;
  std::array<Vec3, ArCoefficients::max_order + 1> recent_{};  // for the recursion, newest first
  int seen_ = 0;
};

}  // namespace tactor
