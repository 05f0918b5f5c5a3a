#include "nodes/forcefield/god_object.hpp"

#include <algorithm>
#include <cmath>

#include "nodes/physics/contact/materials.hpp"

namespace tactor {

namespace {

constexpr int most_rounds = 32;
constexpr double at_rest_within = 1e-7;  // m, in a round
constexpr double no_way = 1e-13;         // m
/// Of overlapping bodies, each pushes the proxy out of itself in turn: so often in a move, and in all.
constexpr int pushes_a_move = 8, most_pushes_out = 200;
constexpr double outside_within = 1e-9;  // m
/// m; however many looks a way takes, shorter ones are not tried.
constexpr double least_reach = 1e-6;
/// What friction may hold beyond its limit, so that a proxy that has slid to the limit rests there.
constexpr double friction_rounding = 1e-9;

}  // namespace

GodObject::GodObject(const Scene& scene, const Options& options, Notes* notes) : options_(options) {
  options_.radius = std::max(options.radius, point_radius);
  const Body* tool = scene.tool();
  for (const Body& body : scene.bodies) {
    if (body.motion != Motion::fixed) continue;
    const double friction = tool != nullptr ? combine(tool->material, body.material).friction : body.material.friction;
    bodies_.push_back({body.X_WB, options.friction ? friction : 0, ball_surface(body, options.crease, notes)});
  }
}

/// A search that finds nothing goes on at the next move from where it is, and begins anew after a while.
void GodObject::place(const Vec3& goal) {
  if (pushes_out_ % most_pushes_out == 0) {
    tried_ = goal;
    pushes_out_ = 0;
  }
  for (int push = 0; push < pushes_a_move; ++push, ++pushes_out_) {
    bool outside = true;
    for (const FixedBody& body : bodies_) {
      const Nearest nearest = body.surface->nearest(transform(inverse(body.X_WB), tried_));
      ++queries_;
      if (nearest.distance >= options_.radius - outside_within) continue;
      tried_ = transform(body.X_WB, nearest.p + options_.radius * nearest.gradient);
      outside = false;
    }
    if (!outside) continue;
    p_ = tried_;
    placed_ = true;
    pushes_out_ = 0;
    return;
  }
}

/// True where a surface is met, or where `starved_`: nothing is known then.
bool GodObject::cast(const Vec3& way, BallHit& hit, double& friction) {
  ++casts_;
  hit = {};
  for (const FixedBody& body : bodies_) {
    const Pose X_BW = inverse(body.X_WB);
    const double before = hit.share;
    starved_ = !body.surface->cast(transform(X_BW, p_), rotate(X_BW.R, way), options_.radius, hit, looks_left_);
    if (starved_) return true;
    if (!hit.met || hit.share == before) continue;
    hit.n = rotate(body.X_WB.R, hit.n);
    hit.shaded = rotate(body.X_WB.R, hit.shaded);
    friction = body.friction;
  }
  return hit.met;
}

bool GodObject::keep_plane(const BallHit& hit, double friction) {
  const HalfSpace space{hit.n, dot(hit.n, p_)};
  const std::size_t at = spaces_.size();
  if (spaces_.add(space)) {
    planes_[at] = {hit.n, hit.shaded, friction};
    return true;
  }
  if (at < HalfSpaces::capacity) return false;  // it is there already
  for (std::size_t i = 0; i < at; ++i) {
    if (allowed_.push[i] > 0) continue;
    spaces_.replace(i, space);
    planes_[i] = {hit.n, hit.shaded, friction};
    return true;
  }
  return false;
}

/// One part of the way; false where the round is over.
bool GodObject::slide(const Vec3& goal) {
  allowed_ = spaces_.nearest(goal);
  if (!allowed_.found) return false;
  Vec3 way = allowed_.x - p_;
  double holds = 0;
  for (std::size_t i = 0; i < spaces_.size(); ++i) holds += planes_[i].friction * allowed_.push[i];
  const double length = norm(way);
  if (length <= holds * (1 + friction_rounding) + no_way) return false;
  way *= 1 - holds / length;
  const double whole = norm(way);
  const bool cut = whole > reach_;
  if (cut) way *= reach_ / whole;
  BallHit hit;
  double friction = 0;
  const bool met = cast(way, hit, friction);
  if (starved_) {
    // A shorter way takes fewer looks.
    reach_ = std::max(0.5 * norm(way), least_reach);
    return false;
  }
  if (!met) {
    p_ = holds > 0 || cut ? p_ + way : allowed_.x;
    return cut;
  }
  p_ += hit.share * way + hit.within * hit.n;
  return keep_plane(hit, friction);
}

/// What the planes of the last round say of the force.
void GodObject::settle(const Vec3& goal) {
  goal_ = goal;
  allowed_ = spaces_.nearest(goal);
  turned_ = normal_ = {};
  pushes_ = 0;
  contacts_ = 0;
  if (!allowed_.found) return;
  for (std::size_t i = 0; i < spaces_.size(); ++i) {
    const double push = allowed_.push[i];
    if (!(push > 0)) continue;
    ++contacts_;
    pushes_ += push;
    turned_ += push * (planes_[i].shaded - planes_[i].n);
    normal_ += push * planes_[i].n;
  }
  const double length = norm(normal_);
  normal_ = length > 0 ? normal_ / length : Vec3{};
}

void GodObject::move(const Vec3& goal) {
  casts_ = queries_ = 0;
  looks_left_ = options_.most_looks;
  starved_ = false;
  if (!placed_) place(goal);
  spaces_.clear();
  if (!placed_) {
    p_ = goal;  // no force
    return settle(goal);
  }
  for (int round = 0; round < most_rounds && casts_ < options_.most_casts && !starved_; ++round) {
    const Vec3 begin = p_;
    spaces_.clear();
    while (casts_ < options_.most_casts && slide(goal)) {
    }
    if (norm(p_ - begin) < at_rest_within) break;
  }
  if (!starved_) reach_ *= 2;
  settle(goal);
}

Vec3 GodObject::stretch(bool shaded) const {
  return p_ - goal_ + (shaded ? turned_ : Vec3{});
}

}  // namespace tactor
