#include "nodes/passivity/wave_end.hpp"

#include <algorithm>
#include <cmath>

namespace tactor {

namespace {
/// What of the energy is kept for a result that comes late, as a share of a period.
constexpr double reserve = 0.25;
}  // namespace

double WaveEnd::energy_of(const Vec3& way, double dt) const {
  return 0.25 * impedance_ * dot(way, way) / dt;
}

void WaveEnd::start(Time at, const Vec3& p_WD) {
  at_ = at;
  outgoing_ = incoming_ = p_WD;
  result_ = {at, p_WD, p_WD};
}

void WaveEnd::advance(Time at, const Vec3& way, const Vec3& force) {
  const double dt = (at - at_).seconds();
  at_ = at;
  const Vec3 damped = (dt / impedance_) * force;
  const Vec3 out = way - damped, in = way + damped;
  outgoing_ += out;
  incoming_ += in;
  energy_out_ += energy_of(out, dt);
  energy_played_ += energy_of(in, dt);
  left_[(left_begin_ + left_count_) % ticks_kept] = {at, energy_out_};
  if (left_count_ < ticks_kept) {
    ++left_count_;
  } else {
    left_begin_ = (left_begin_ + 1) % ticks_kept;
  }
}

/// J that had left by then. It drops the entries up to that time, so the next call must not be for an earlier time.
double WaveEnd::energy_out_by(Time at) {
  for (; left_count_ > 0 && left_[left_begin_].at <= at; --left_count_) {
    energy_out_there_ = left_[left_begin_].energy;
    left_begin_ = (left_begin_ + 1) % ticks_kept;
  }
  return energy_out_there_;
}

Vec3 WaveEnd::arrive(const Result& result, Time now) {
  const double period = (result.at - result_.at).seconds();
  const Vec3 out = result.handle - result_.handle, tool = result.tool - result_.tool;
  const Vec3 pull = (impedance_ / period) * (out - tool);  // of the damper, on the tool
  const double before = energy_out_there_;
  const double there = energy_out_by(result.at);
  energy_brought_ = std::min(energy_brought_ + (there - before) - dot(pull, tool), there);
  rate_ = (1 / period) * (2 * tool - out);
  period_ = period;
  from_ = now;
  result_ = result;
  return -1 * pull;
}

Vec3 WaveEnd::force(std::span<const Vec3> acting, const Vec3& velocity) {
  // Where the ticks until then lead.
  Vec3 place = incoming_;
  double left = energy_brought_ - energy_played_;
  for (const Vec3& held : acting) {
    const Vec3 way = tick_ * velocity + (tick_ / impedance_) * held;
    place += way;
    left -= energy_of(way, tick_);
  }

  const double since = (at_ - from_).seconds() + tick_ * (static_cast<double>(acting.size()) - 1);
  const Vec3 rate = since < 2 * period_ ? rate_ : Vec3{};
  const Vec3 due = arrived() - std::max(0.0, period_ - since - tick_) * rate_;
  Vec3 wanted = rate + (1 / catch_up_) * (due - place - tick_ * rate);
  const double lasts = std::max(std::max(0.0, period_ - since) + reserve * period_, tick_);
  const double most = left > 0 ? std::sqrt(4 * left / (impedance_ * lasts)) : 0;
  const double size = norm(wanted);
  was_cut_ = size > most;
  if (was_cut_) wanted = (most / size) * wanted;
  return impedance_ * (wanted - velocity);
}

}  // namespace tactor
