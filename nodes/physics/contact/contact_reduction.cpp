#include "nodes/physics/contact/contact_reduction.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "framework/core/check.hpp"
#include "nodes/physics/geometry/wide.hpp"
#include "nodes/physics/mesh/bounds.hpp"

namespace tactor {

namespace {

using wide::F8;
using wide::I8;

constexpr float infinity = std::numeric_limits<float>::infinity();

double depth(const Contact& c) {
  return std::max(0.0, -c.distance);
}
/// N, at rest.
double pressure(const Contact& c) {
  return c.weight * c.stiffness * depth(c);
}

/// Contacts in columns of floats, whole eights of them.
struct Columns {
  const float* place[6];
  const float* importance;
  const std::int32_t* pair;
  float* apart;
  std::int32_t* nearest;
  std::size_t count;
};

/// Takes it into account that contact `picked` has been picked, and returns the next: the largest importance times
/// squared distance from those picked, the first of several.
TACTOR_WIDE std::size_t pick_next(const Columns& columns, std::size_t picked) {
  F8 best = wide::all(-infinity);
  I8 best_at = {};
  I8 at{0, 1, 2, 3, 4, 5, 6, 7};
  const auto number = static_cast<std::int32_t>(picked);
  // Read once, because what is written below might else have changed it.
  const float* place[6];
  F8 of_picked[6];
  for (std::size_t axis = 0; axis < 6; ++axis) {
    place[axis] = columns.place[axis];
    of_picked[axis] = wide::all(place[axis][picked]);
  }
  const std::int32_t pair_of_picked = columns.pair[picked];
  for (std::size_t i = 0; i < columns.count; i += 8) {
    F8 squared = wide::all(0);
#pragma GCC unroll 6
    for (std::size_t axis = 0; axis < 6; ++axis) {
      const F8 d = wide::load(place[axis] + i) - of_picked[axis];
      squared += d * d;
    }
    I8 pair, nearest;
    __builtin_memcpy(&pair, columns.pair + i, sizeof pair);
    __builtin_memcpy(&nearest, columns.nearest + i, sizeof nearest);
    F8 apart = wide::load(columns.apart + i);
    const I8 nearer = (pair == pair_of_picked) & (squared < apart);
    apart = nearer ? squared : apart;
    nearest = nearer ? nearest * 0 + number : nearest;
    wide::store(columns.apart + i, apart);
    __builtin_memcpy(columns.nearest + i, &nearest, sizeof nearest);
    // Of contacts at one place any will do, but none twice: what has been picked scores below zero.
    const F8 score = (apart + 1e-30F) * wide::load(columns.importance + i);
    const I8 better = score > best;
    best = better ? score : best;
    best_at = better ? at : best_at;
    at += 8;
  }
  std::size_t next = 0;
  float most = -infinity;
  for (int k = 0; k < 8; ++k) {
    const auto candidate = static_cast<std::size_t>(best_at[k]);
    if (best[k] > most || (best[k] == most && candidate < next)) most = best[k], next = candidate;
  }
  return next;
}

}  // namespace

void FoundContacts::clear() {
  contact.clear();
  pair.clear();
  key.clear();
}

void FoundContacts::shorten(std::size_t count) {
  contact.resize(count);
  pair.resize(count);
  key.resize(count);
}

void FoundContacts::reserve(std::size_t most) {
  contact.reserve(most);
  pair.reserve(most);
  key.reserve(most);
}

ContactReduction::ContactReduction(int max_contacts, std::size_t most)
    : max_contacts_(static_cast<std::size_t>(max_contacts)) {
  TACTOR_DEMAND(max_contacts >= 4 && max_contacts <= ContactSet::capacity);
  last_keys_.reserve(max_contacts_);
  reserve(most);
}

bool ContactReduction::was_kept(std::uint64_t key) const {
  return std::binary_search(last_keys_.begin(), last_keys_.end(), key);
}

/// Picks `count` of some contacts, all of which penetrate or none of which does, and says who stands for the others.
void ContactReduction::pick_spread(const FoundContacts& found, const std::vector<std::size_t>& of, std::size_t count) {
  const std::size_t n = of.size(), padded = (n + 7) / 8 * 8;
  Bounds patch;
  double farthest = 0;
  for (const std::size_t i : of) {
    patch.add(found.contact[i].p_WC);
    farthest = std::max(farthest, found.contact[i].distance);
  }
  // Where none penetrates, the force that each would have if all came nearer by the farthest's distance and a little.
  const auto worth = [&](const Contact& c) {
    return c.distance < 0 ? pressure(c) : c.weight * c.stiffness * (1.1 * farthest - c.distance);
  };
  // Opposite directions are as far apart as half the patch is long.
  const double turn = 0.25 * norm(patch.size());
  for (std::vector<float>& column : place_) column.assign(padded, 0);
  importance_.assign(padded, -1);
  apart_.assign(padded, 0);
  pair_of_.assign(padded, 0);
  nearest_.assign(padded, -1);
  double most = 0;
  for (const std::size_t i : of) most = std::max(most, worth(found.contact[i]));
  // Contacts without weight or exactly at touch are alike.
  if (!(most > 0)) most = 1;
  std::size_t first = 0;
  double first_score = -1;
  for (std::size_t j = 0; j < n; ++j) {
    const std::size_t i = of[j];
    const Contact& c = found.contact[i];
    for (int axis = 0; axis < 3; ++axis) {
      place_[axis][j] = static_cast<float>(c.p_WC[axis] - patch.low[axis]);
      place_[axis + 3][j] = static_cast<float>(turn * c.n_W[axis]);
    }
    const double score = (was_kept(found.key[i]) ? 4 : 1) * std::max(worth(c) / most, 1e-6);
    importance_[j] = static_cast<float>(score);
    // Large, and still ordered by importance once multiplied.
    apart_[j] = 1e20F;
    pair_of_[j] = static_cast<std::int32_t>(pair_number(found.key[i]));
    if (score > first_score) first_score = score, first = j;
  }
  Columns columns{
      {place_[0].data(), place_[1].data(), place_[2].data(), place_[3].data(), place_[4].data(), place_[5].data()},
      importance_.data(),
      pair_of_.data(),
      apart_.data(),
      nearest_.data(),
      padded};
  for (std::size_t k = 0, next = first; k < count; ++k) {
    kept_.push_back(of[next]);
    importance_[next] = -1;
    next = pick_next(columns, next);
  }
  for (std::size_t j = 0; j < n; ++j) {
    // It is its own, or no contact of its pair was kept.
    if (nearest_[j] < 0 || importance_[j] < 0) continue;
    gifts_.emplace_back(of[j], of[static_cast<std::size_t>(nearest_[j])]);
  }
}

/// Picks `count` of the contacts that do not touch.
void ContactReduction::pick_nearest(const FoundContacts& found, std::size_t count) {
  // Those kept last time stay until another is nearer by a tenth.
  const auto distance = [&](std::size_t i) { return (was_kept(found.key[i]) ? 0.9 : 1) * found.contact[i].distance; };
  std::nth_element(others_.begin(), others_.begin() + static_cast<std::ptrdiff_t>(count), others_.end(),
                   [&](std::size_t a, std::size_t b) {
                     const double da = distance(a), db = distance(b);
                     return da != db ? da < db : a < b;
                   });
  kept_.insert(kept_.end(), others_.begin(), others_.begin() + static_cast<std::ptrdiff_t>(count));
}

/// Adds what each one kept takes over to its weight.
void ContactReduction::give(const FoundContacts& found, ContactSet& set) const {
  for (const auto& [from, to] : gifts_) {
    const Contact& c = found.contact[from];
    const auto at = static_cast<std::size_t>(std::lower_bound(kept_.begin(), kept_.end(), to) - kept_.begin());
    Contact& taker = set.contact[at];
    if (c.distance < 0) {
      // A shallow contact that stood for a deep one would be stiff beyond measure.
      taker.weight += pressure(c) / (c.stiffness * std::max(depth(taker), 0.1 * depth(c)));
    } else {
      // One about to touch that stood for all that are farther would strike hard where it alone touches.
      taker.weight += c.distance > taker.distance ? taker.distance / c.distance * c.weight : c.weight;
    }
  }
}

/// Changes the weights of a pair's kept contacts towards the wrench that all of its contacts made. True where they make
/// it; else a weight would have had to change by more than half, and all have changed less.
bool ContactReduction::restore_wrench(const FoundContacts& found, std::uint64_t pair, ContactSet& set) {
  const auto of_pair = [&](std::size_t i) {
    return pair_number(found.key[i]) == pair && found.contact[i].distance < 0;
  };
  Vec3 centre;
  double sum = 0, spread = 0;
  for (std::size_t i = 0; i < kept_.size(); ++i) {
    if (!of_pair(kept_[i])) continue;
    centre += pressure(set.contact[i]) * set.contact[i].p_WC;
    sum += pressure(set.contact[i]);
  }
  if (!(sum > 0)) return true;
  centre *= 1 / sum;
  for (std::size_t i = 0; i < kept_.size(); ++i) {
    if (of_pair(kept_[i])) spread = std::max(spread, norm(set.contact[i].p_WC - centre));
  }
  if (!(spread > 0)) return true;
  using Wrench6 = Eigen::Matrix<double, 6, 1>;
  // Force and torque of pressure 1, the torque in units of the spread so that it compares with the force.
  const auto unit_wrench = [&](const Contact& c) {
    const Vec3 torque = cross(c.p_WC - centre, c.n_W) / spread;
    Wrench6 w;
    w << c.n_W.x, c.n_W.y, c.n_W.z, torque.x, torque.y, torque.z;
    return w;
  };
  Wrench6 missing = Wrench6::Zero();
  for (const std::size_t i : penetrating_) {
    if (of_pair(i)) missing += pressure(found.contact[i]) * unit_wrench(found.contact[i]);
  }
  Eigen::Matrix<double, 6, 6> A = 1e-9 * sum * Eigen::Matrix<double, 6, 6>::Identity();
  for (std::size_t i = 0; i < kept_.size(); ++i) {
    const Contact& c = set.contact[i];
    if (!of_pair(kept_[i])) continue;
    const Wrench6 w = unit_wrench(c);
    missing -= pressure(c) * w;
    A += pressure(c) * w * w.transpose();
  }
  // Minimises sum(pressure * change^2) where the changes of the weights, relative to them, make up what is missing.
  const Wrench6 multiplier = A.ldlt().solve(missing);
  double largest = 0;
  for (std::size_t i = 0; i < kept_.size(); ++i) {
    if (of_pair(kept_[i])) largest = std::max(largest, std::abs(unit_wrench(set.contact[i]).dot(multiplier)));
  }
  const double part = largest > 0.5 ? 0.5 / largest : 1;
  for (std::size_t i = 0; i < kept_.size(); ++i) {
    Contact& c = set.contact[i];
    if (of_pair(kept_[i])) c.weight *= 1 + part * unit_wrench(c).dot(multiplier);
  }
  return part == 1;
}

void ContactReduction::reserve(std::size_t most) {
  penetrating_.reserve(most);
  others_.reserve(most);
  kept_.reserve(most);
  gifts_.reserve(most);
  for (std::vector<float>& column : place_) column.reserve(most + 7);
  importance_.reserve(most + 7);
  apart_.reserve(most + 7);
  pair_of_.reserve(most + 7);
  nearest_.reserve(most + 7);
}

void ContactReduction::reduce(const FoundContacts& found, ContactSet& set) {
  reserve(found.contact.size());
  penetrating_.clear();
  others_.clear();
  kept_.clear();
  for (std::size_t i = 0; i < found.contact.size(); ++i) {
    (found.contact[i].distance < 0 ? penetrating_ : others_).push_back(i);
  }
  gifts_.clear();
  const std::size_t reserved = std::min(others_.size(), max_contacts_ / 4);
  const std::size_t touching = std::min(penetrating_.size(), max_contacts_ - reserved);
  const bool too_many = touching < penetrating_.size();
  if (too_many) {
    pick_spread(found, penetrating_, touching);
  } else {
    kept_ = penetrating_;
  }
  const std::size_t room = max_contacts_ - touching;
  if (others_.size() <= room) {
    kept_.insert(kept_.end(), others_.begin(), others_.end());
  } else if (too_many) {
    pick_spread(found, others_, room);
  } else {
    pick_nearest(found, room);
  }
  std::sort(kept_.begin(), kept_.end());
  set.count = static_cast<std::int32_t>(kept_.size());
  set.penetrating = static_cast<std::int32_t>(touching);
  set.truncated = static_cast<std::int32_t>(found.contact.size() - kept_.size());
  last_keys_.clear();
  for (std::size_t i = 0; i < kept_.size(); ++i) {
    set.contact[i] = found.contact[kept_[i]];
    set.pair[i] = found.pair[kept_[i]];
    last_keys_.push_back(found.key[kept_[i]]);
  }
  std::sort(last_keys_.begin(), last_keys_.end());
  if (!too_many) return;
  give(found, set);
  // Those of a pair stand together.
  for (std::size_t i = 0; i < kept_.size(); ++i) {
    const std::uint64_t pair = pair_number(found.key[kept_[i]]);
    if (i > 0 && pair == pair_number(found.key[kept_[i - 1]])) continue;
    for (int round = 0; round < 4 && !restore_wrench(found, pair, set); ++round) {
    }
  }
}

}  // namespace tactor
