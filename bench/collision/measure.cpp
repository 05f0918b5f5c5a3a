#include "bench/collision/measure.hpp"

#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "bench/collision/quantile.hpp"
#include "bench/collision/timed_loop.hpp"

namespace tactor::bench {

namespace {

using Json = nlohmann::ordered_json;

struct Running {
  const Entry* entry = nullptr;
  std::unique_ptr<Contender> contender;
  double build_ms = 0, memory_mb = 0;
  double first = 0;                // us, the first query
  std::vector<double> warm, cold;  // us, the others
};

Running build(const Entry& entry, const Pair& pair) {
  Running r;
  r.entry = &entry;
  const std::size_t before = heap_in_use();
  r.build_ms = 1e-3 * microseconds([&] { r.contender = entry.make(pair); });
  r.memory_mb = 1e-6 * (static_cast<double>(heap_in_use()) - static_cast<double>(before));
  return r;
}

/// The query before each block, and before a rest, is made again and not timed: others have had the caches since.
void run_warm(std::vector<Running>& all, const std::vector<Step>& steps, int block) {
  TimedLoop loop;
  for (Running& r : all) {
    r.first = microseconds([&] { r.contender->query(steps.front()); });
  }
  std::size_t round = 0;
  const auto length = static_cast<std::size_t>(block);
  for (std::size_t begin = 0; begin < steps.size(); begin += length, ++round) {
    for (std::size_t k = 0; k < all.size(); ++k) {
      // Each round begins with another, so that none always follows the same one.
      Running& r = all[(k + round) % all.size()];
      if (begin > 0) r.contender->query(steps[begin - 1]);
      for (std::size_t i = std::max<std::size_t>(begin, 1); i < std::min(begin + length, steps.size()); ++i) {
        if (loop.rest_if_due()) r.contender->query(steps[i - 1]);
        r.warm.push_back(microseconds([&] { r.contender->query(steps[i]); }));
      }
    }
  }
}

/// The first query of each block is made and not counted: a contender that goes on from its last query has been
/// elsewhere.
void run_cold(std::vector<Running>& all, const std::vector<Step>& steps, const MeasureOptions& options) {
  const auto length = static_cast<std::size_t>(options.cold_block);
  TimedLoop loop;
  for (int b = 0; b < options.cold_blocks; ++b) {
    const std::size_t begin =
        steps.size() * static_cast<std::size_t>(b) / static_cast<std::size_t>(options.cold_blocks);
    for (Running& r : all) {
      for (std::size_t i = begin; i <= begin + length && i < steps.size(); ++i) {
        loop.rest_if_due();
        sweep_caches();
        const double us = microseconds([&] { r.contender->query(steps[i]); });
        if (i > begin) r.cold.push_back(us);
      }
    }
  }
}

/// The exact contact nearest to a point, or none within `near`.
const Touch* nearest_of(const Touches& touches, const Vec3& p, double near) {
  const Touch* best = nullptr;
  for (const Touch& t : touches) {
    if (const double d = norm(t.p_A - p); d <= near) near = d, best = &t;
  }
  return best;
}

/// How many of the exact contacts' samples are among those found, each counted once.
std::size_t common_samples(const Touches& exact, const Touches& found) {
  std::set<std::pair<Side, int>> inside;
  for (const Touch& e : exact) inside.insert({e.side, e.sample});
  return static_cast<std::size_t>(std::count_if(found.begin(), found.end(), [&](const Touch& f) {
    return inside.erase({f.side, f.sample}) > 0;
  }));
}

Json compare(const Running& r, const std::vector<Step>& steps, const MeasureOptions& options) {
  std::vector<double> count, ratio, normal_error, depth_error;
  std::size_t deep = 0, missed = 0, unseen = 0, touching = 0, wrong_way = 0, unsampled = 0, finite = 0, matched = 0;
  std::size_t exact = 0, left_out = 0, made_up = 0;
  const bool same_samples = r.entry->gives == Gives::samples;
  for (const Step& step : steps) {
    r.contender->query(step);
    double deepest = 0;
    for (const Touch& e : step.exact) deepest = std::max(deepest, e.depth);
    touching += r.contender->touching();
    unseen += deepest > options.deep && !r.contender->touching();
    unsampled += step.exact.empty() && r.contender->touching();
    if (r.entry->gives == Gives::touching) continue;
    Touches found = r.contender->touches();
    // Those that report what is near, too, are judged by what penetrates.
    if (gives_depths(r.entry->gives)) std::erase_if(found, [](const Touch& t) { return t.depth <= 0; });
    count.push_back(static_cast<double>(found.size()));
    if (same_samples) {
      const std::size_t both = common_samples(step.exact, found);
      exact += step.exact.size();
      left_out += step.exact.size() - both;
      made_up += found.size() - both;
    }
    for (const Touch& e : step.exact) {
      if (e.depth <= options.deep) continue;
      ++deep;
      missed += nearest_of(found, e.p_A, options.near) == nullptr;
    }
    if (!gives_depths(r.entry->gives)) continue;
    double reported = 0;
    for (const Touch& f : found) {
      finite += is_finite(f.p_A) && is_finite(f.n_A) && std::isfinite(f.depth);
      reported = std::max(reported, f.depth);
      // A sample is compared with itself, another contact with the sample next to it.
      const bool is_sample = f.side != Side::none;
      const Touch* e = nearest_of(step.exact, f.p_A, is_sample ? 1e-9 : options.near);
      if (e == nullptr) continue;
      if (is_sample) depth_error.push_back(1e6 * std::abs(f.depth - e->depth));
      ++matched;
      const double cosine = std::clamp(dot(e->n_A, f.n_A), -1.0, 1.0);
      normal_error.push_back(180 / std::numbers::pi * std::acos(cosine));
      wrong_way += cosine < 0;
    }
    if (deepest > options.deep) ratio.push_back(reported / deepest);
  }
  Json json = {{"touching", touching}, {"touches_unseen", unseen}, {"touches_between_samples", unsampled}};
  if (r.entry->gives == Gives::touching) return json;
  json["contacts"] = {{"median", quantile(count, 0.5)}, {"max", quantile(count, 1)}};
  json["missed"] = {{"of", deep}, {"missed", missed}, {"share", deep > 0 ? double(missed) / double(deep) : 0}};
  if (same_samples) json["samples"] = {{"of", exact}, {"left_out", left_out}, {"made_up", made_up}};
  if (!gives_depths(r.entry->gives)) return json;
  double all = 0;
  for (const double n : count) all += n;
  json["not_finite"] = static_cast<std::size_t>(all) - finite;
  json["deepest_ratio"] = {
      {"p1", quantile(ratio, 0.01)}, {"median", quantile(ratio, 0.5)}, {"p99", quantile(ratio, 0.99)}};
  json["normal_error_deg"] = spread_of(normal_error);
  json["wrong_way_share"] = matched > 0 ? double(wrong_way) / double(matched) : 0;
  if (!depth_error.empty()) {
    json["depth_error_um"] = spread_of(depth_error);
  }
  return json;
}

/// 50 mm further out along z there is nothing to touch.
bool sees_nothing_apart(Contender& contender, const Step& step) {
  Step apart{step.X_AB, {}};
  apart.X_AB.p.z += 0.05;
  contender.query(apart);
  return !contender.touching();
}

}  // namespace

void sweep_caches() {
  constexpr std::size_t line = 64;
  static std::vector<unsigned char> memory(std::size_t{64} << 20);
  for (std::size_t i = 0; i < memory.size(); i += line) ++memory[i];
}

std::size_t heap_in_use() {
  const auto info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

Json spread_of(const std::vector<double>& values) {
  return {{"median", quantile(values, 0.5)}, {"p99", quantile(values, 0.99)}, {"max", quantile(values, 1)}};
}

Json measure(const std::vector<Entry>& entries, const Pair& pair, const std::vector<Step>& steps,
             const MeasureOptions& options) {
  std::vector<Running> all;
  for (const Entry& entry : entries) {
    all.push_back(build(entry, pair));
    all.back().warm.reserve(steps.size());
  }
  run_warm(all, steps, options.block);
  run_cold(all, steps, options);
  Json rows = Json::array();
  for (Running& r : all) {
    Json row = {{"name", r.entry->name}, {"all", r.entry->all}, {"us", spread_of(r.warm)}, {"first_us", r.first}};
    row["ratio_median"] = quantile(r.warm, 0.5) / quantile(all.front().warm, 0.5);
    row["ratio_p99"] = quantile(r.warm, 0.99) / quantile(all.front().warm, 0.99);
    if (!r.cold.empty()) {
      row["cold_us"] = spread_of(r.cold);
      row["cold_queries"] = r.cold.size();
    }
    if (options.compare) row.update(compare(r, steps, options));
    row["nothing_apart"] = sees_nothing_apart(*r.contender, steps.front());
    row["memory_MB"] = r.memory_mb;
    row["build_ms"] = r.build_ms;
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace tactor::bench
