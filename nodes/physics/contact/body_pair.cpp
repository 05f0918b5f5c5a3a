#include "nodes/physics/contact/body_pair.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "nodes/physics/contact/materials.hpp"

namespace tactor {

namespace {

/// A body whose surface is all points at a radius from the few that it is sampled at.
bool is_round(const ContactBody& body) {
  return !body.samples.radii.empty();
}
bool is_ball(const ContactBody& body) {
  return std::holds_alternative<SphereShape>(body.shape);
}

double sample_radius(const ContactBody& body, std::size_t i) {
  return is_round(body) ? body.samples.radii[i] : 0;
}

/// R H R^T as Contact::H_W has it.
std::array<double, 6> turned(const Quat& R, const Eigen::Matrix3d& H) {
  if (H.isZero(0)) return {};
  const Vec3 x = rotate(R, {1, 0, 0}), y = rotate(R, {0, 1, 0}), z = rotate(R, {0, 0, 1});
  Eigen::Matrix3d M;
  M << x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z;
  const Eigen::Matrix3d W = M * H * M.transpose();
  return {W(0, 0), W(0, 1), W(0, 2), W(1, 1), W(1, 2), W(2, 2)};
}

/// Sums over a side's samples of weight * (margin - distance), in m.
struct Extent {
  double all = 0;
  double rim = 0;      // of those at edges and corners
  double coarse = 0;   // each times its weight
  double nearest = 0;  // m, the largest margin - distance
  void add(double weight, double within, bool at_rim) {
    const double extent = weight * within;
    all += extent;
    coarse += weight * extent;
    if (at_rim) rim += extent;
    nearest = std::max(nearest, within);
  }
};

double cube(double x) {
  return x * x * x;
}

/// How many times finer a is sampled than b, by the mean weight of a sample. Both have some.
double fineness_of(const Extent& a, const Extent& b) {
  return b.coarse / b.all / (a.coarse / a.all);
}

/// How much a is preferred because it is sampled more finely, from -1 to 1, as far as the finer side is as deep as the
/// other: a spike between the samples of a fine face is felt by its own. `finer`: the cube of fineness_of.
double preference_of(const Extent& a, const Extent& b, double finer, double margin) {
  constexpr double slack = 2.5e-5;  // m, near touch
  const double preference = (finer - 1) / (finer + 1);
  const Extent &fine = preference > 0 ? a : b, &coarse = preference > 0 ? b : a;
  const double missed = coarse.nearest - fine.nearest, deep = std::max(0.0, coarse.nearest - margin);
  return preference * std::clamp(1.5 - missed / (0.5 * deep + 2 * slack), 0.0, 1.0);
}

/// What one side's contacts push with at rest, in units of stiffness; those that do not touch count a little, so that
/// it changes continuously where the first one touches.
struct Push {
  double sum = 0;     // m
  double rim = 0;     // m, of those at edges and corners that touch
  Vec3 force;         // m
  Vec3 torque;        // m^2, about the reference point
  Vec3 first;         // m^2, sum of push times place, from the reference point
  double second = 0;  // m^3, of push times squared distance from it

  void add(const Contact& c, bool at_rim, double margin, const Vec3& reference) {
    const double push = c.weight * (std::max(0.0, -c.distance) + 1e-3 * (margin - c.distance));
    // Halfway from the one body's point to the other's, so that both bodies are alike.
    const Vec3 p = c.p_WC + 0.5 * c.distance * c.n_W - reference, f = push * c.n_W;
    sum += push;
    if (at_rim) rim += c.weight * std::max(0.0, -c.distance);
    force += f;
    torque += cross(p, f);
    first += push * p;
    second += push * dot(p, p);
  }
};

/// 1 where all that `other` pushes is in what `leading` pushes, 0 where it is not: by the differences of force and
/// torque, these in units of how far the contacts spread, over the sum of both. As far as its rim touches, what leads
/// may push more: there the samples of the other end too soon, because a side is nearer to them than the face.
double likeness(const Push& leading, const Push& other) {
  constexpr double alike = 0.3, unlike = 0.5, rim = 0.02;
  const double sum = leading.sum + other.sum;
  if (!(sum > 0)) return 0;
  const double more = other.sum < leading.sum ? std::min(1.0, leading.rim / (rim * leading.sum)) : 0;
  const double scale = more > 0 ? 1 - more * (1 - other.sum / leading.sum) : 1;
  const Vec3 centre = (leading.first + other.first) / sum, force = scale * leading.force - other.force;
  const Vec3 torque = scale * leading.torque - other.torque - cross(centre, force);
  const double spread = std::sqrt(std::max(0.0, (leading.second + other.second) / sum - dot(centre, centre)));
  const double difference = norm(force) / sum + (spread > 0 ? norm(torque) / (spread * sum) : 0);
  return std::clamp((unlike - difference) / (unlike - alike), 0.0, 1.0);
}

/// The contacts of a side.
struct SideContacts {
  std::span<const Contact> contact;
  std::span<const std::uint64_t> key;
  const std::vector<SurfaceSample>& samples;
  [[nodiscard]] Push push(double margin, const Vec3& reference) const {
    Push push;
    for (std::size_t i = 0; i < contact.size(); ++i) {
      push.add(contact[i], samples[sample_of(key[i])].crease >= 0, margin, reference);
    }
    return push;
  }
};

/// How much more of the rim is a's, from -1 to 1, as far as that side pushes all that the other one does. `finer`: the
/// cube of fineness_of.
double lean_of(const Extent& a, const Extent& b, double finer, const SideContacts& by_a, const SideContacts& by_b,
               double margin) {
  constexpr double little = 0.005;  // of all, where the rim begins to count
  const double rim_a = cube(a.rim), rim_b = cube(b.rim), rest = cube(little * (a.all + b.all));
  const double of_a = rim_a > 0 ? rim_a / (rim_a + rim_b / finer + rest) : 0;
  const double of_b = rim_b > 0 ? rim_b / (rim_b + rim_a * finer + rest) : 0;
  const double lean = of_a - of_b;
  if (lean == 0) return 0;
  const Vec3 reference = by_a.contact.front().p_WC;
  const Push a_pushes = by_a.push(margin, reference), b_pushes = by_b.push(margin, reference);
  return lean * (lean > 0 ? likeness(a_pushes, b_pushes) : likeness(b_pushes, a_pushes));
}

}  // namespace

BodyPair::BodyPair(const ContactBody& a, const ContactBody& b, ContactPair indices, std::uint32_t number, double margin)
    : a_(a), b_(b), indices_(indices), number_(number), margin_(margin), material_(combine(a.material, b.material)) {
  if (a.motion != Motion::rigid && b.motion != Motion::rigid) R_BA_ = inverse(b.X_WB.R) * a.X_WB.R;
  if (b.motion == Motion::fixed) p_WM_of_b_ = transform(b.X_WB, b.p_BM);
  if (is_ball(a) || is_ball(b)) {
    ball_is_a_ = is_ball(a);
    ball_ = Ball{.radius = ball_is_a_ ? a.radius : b.radius};
    return;
  }
  const bool one_is_round = is_round(a) != is_round(b);
  if (!a.samples.points.empty() && !(one_is_round && is_round(b))) side_a_.emplace(a.samples.points, a.samples.radii);
  if (!b.samples.points.empty() && !(one_is_round && is_round(a))) side_b_.emplace(b.samples.points, b.samples.radii);
}

bool BodyPair::may_meet(const Pose& X_WA, const Pose& X_WB) const {
  const Vec3 apart = transform(X_WA, a_.p_BM) - (p_WM_of_b_ ? *p_WM_of_b_ : transform(X_WB, b_.p_BM));
  const double reach = a_.radius + b_.radius + margin_;
  return dot(apart, apart) <= reach * reach;
}

/// The contact of a point of a, or of a ball about it, with b's surface, `n` being what b's distance gave there; all of
/// it but weight and curvature.
Contact BodyPair::of_a(const Pose& X_WA, const Pose& X_WB, const Vec3& p_A, double radius, const Nearest& n) const {
  Contact c{.stiffness = material_.stiffness, .damping = material_.damping, .friction = material_.friction};
  c.n_W = rotate(X_WB.R, n.gradient);
  c.p_TC = radius == 0 ? p_A : p_A - radius * rotate(inverse(X_WA.R), c.n_W);
  c.p_WC = transform(X_WB, n.p);
  c.distance = n.distance - radius;
  return c;
}

/// The same of a point of b with a's surface.
Contact BodyPair::of_b(const Pose& X_WA, const Pose& X_WB, const Vec3& p_B, double radius, const Nearest& n) const {
  Contact c{.stiffness = material_.stiffness, .damping = material_.damping, .friction = material_.friction};
  c.n_W = -rotate(X_WA.R, n.gradient);
  c.p_TC = n.p;
  c.p_WC = transform(X_WB, p_B) + radius * c.n_W;
  c.distance = n.distance - radius;
  return c;
}

/// Contact::H_W where a point of a, or of b, is at x in the frame of the other body, whose distance gave n there. The
/// distance is as curved seen from the one body as from the other.
std::array<double, 6> BodyPair::curvature(bool from_b, const Pose& X_WA, const Pose& X_WB, const Nearest& n,
                                          const Vec3& x) const {
  return from_b ? turned(X_WA.R, a_.distance->hessian(n, x)) : turned(X_WB.R, b_.distance->hessian(n, x));
}

/// Of the sample in that contact, all of which is known but the weight; in patches.
double BodyPair::weight(const Contact& contact, bool from_b, std::size_t sample, const Quat& R_WK) const {
  const ContactSamples& samples = from_b ? b_.samples : a_.samples;
  if (!samples.weights.empty()) return samples.weights[sample];
  // The normal leads from b to a.
  const Vec3 towards = rotate(inverse(R_WK), from_b ? contact.n_W : -contact.n_W);
  return area_facing(samples, sample, towards) / material_.patch_area;
}

/// A sample that faces away from what it meets makes no contact.
void BodyPair::add(Contact contact, double weight, bool from_b, std::size_t sample, FoundContacts& found) const {
  contact.weight = weight;
  found.contact.push_back(contact);
  found.pair.push_back(indices_);
  found.key.push_back(contact_key(number_, from_b, sample));
}

void BodyPair::find_ball(const Pose& X_WA, const Pose& X_WB, FoundContacts& found) {
  const ContactBody& other = ball_is_a_ ? b_ : a_;
  const Pose &X_WO = ball_is_a_ ? X_WB : X_WA, &X_WK = ball_is_a_ ? X_WA : X_WB;
  const Vec3 x = rotate(inverse(X_WO.R), X_WK.p - X_WO.p);
  const double reach = ball_->radius + margin_;
  // The distance changes by no more than the way moved.
  constexpr double rounding = 1e-12;
  if (ball_->asked && ball_->last.distance - norm(x - ball_->asked_at) > reach + rounding) return;
  ball_->last = other.distance->nearest(x, ball_->last.face);
  ball_->asked_at = x;
  ball_->asked = true;
  if (ball_->last.distance >= reach) return;
  Contact contact =
      ball_is_a_ ? of_a(X_WA, X_WB, {}, ball_->radius, ball_->last) : of_b(X_WA, X_WB, {}, ball_->radius, ball_->last);
  contact.H_W = curvature(!ball_is_a_, X_WA, X_WB, ball_->last, x);
  add(contact, 1, !ball_is_a_, 0, found);
}

void BodyPair::find(const Pose& X_WA, const Pose& X_WB, FoundContacts& found, int* left) {
  shares_ = {};
  if (!may_meet(X_WA, X_WB)) return;
  if (ball_) return find_ball(X_WA, X_WB, found);
  const Quat to_B = inverse(X_WB.R);
  const Pose X_BA{rotate(to_B, X_WA.p - X_WB.p), R_BA_ ? *R_BA_ : to_B * X_WA.R};
  const Pose X_AB = inverse(X_BA);
  static const std::vector<NearSample> none;
  const std::vector<NearSample>& of_side_a = side_a_ ? side_a_->find(*b_.distance, X_BA, margin_, left) : none;
  const std::vector<NearSample>& of_side_b = side_b_ ? side_b_->find(*a_.distance, X_AB, margin_, left) : none;
  // Not all are known, and nobody asks for some.
  if (left != nullptr && *left < 0) return;

  const auto add_side = [&](const std::vector<NearSample>& near, bool from_b) {
    Extent extent;
    const ContactBody& body = from_b ? b_ : a_;
    for (const NearSample& n : near) {
      const auto i = static_cast<std::size_t>(n.sample);
      const SurfaceSample& sample = body.samples.points[i];
      const double radius = sample_radius(body, i);
      Contact c =
          from_b ? of_b(X_WA, X_WB, sample.p, radius, n.nearest) : of_a(X_WA, X_WB, sample.p, radius, n.nearest);
      const double w = weight(c, from_b, i, from_b ? X_WB.R : X_WA.R);
      if (!(w > 0)) continue;
      c.H_W = curvature(from_b, X_WA, X_WB, n.nearest, transform(from_b ? X_AB : X_BA, sample.p));
      extent.add(w, margin_ - n.distance, sample.crease >= 0);
      add(c, w, from_b, i, found);
    }
    return extent;
  };
  const std::size_t first = found.contact.size();
  const Extent of_a_side = add_side(of_side_a, false);
  const std::size_t first_of_b = found.contact.size();
  const Extent of_b_side = add_side(of_side_b, true);
  if (of_a_side.all + of_b_side.all <= 0) return found.shorten(first);
  const std::span<Contact> by_a = std::span(found.contact).subspan(first, first_of_b - first),
                           by_b = std::span(found.contact).subspan(first_of_b);
  double part_a = of_a_side.all, part_b = of_b_side.all;
  // Only where both sides have some is there a choice. What capsules weigh is no area.
  if (part_a > 0 && part_b > 0 && a_.samples.weights.empty()) {
    const std::span<const std::uint64_t> keys(found.key);
    const double finer = cube(fineness_of(of_a_side, of_b_side));
    const double lean =
        lean_of(of_a_side, of_b_side, finer, {by_a, keys.subspan(first, by_a.size()), a_.samples.points},
                {by_b, keys.subspan(first_of_b), b_.samples.points}, margin_);
    const double chosen = lean + (1 - std::abs(lean)) * preference_of(of_a_side, of_b_side, finer, margin_);
    part_a *= 1 + chosen;
    part_b *= 1 - chosen;
  }
  shares_ = {part_a / (part_a + part_b), part_b / (part_a + part_b)};
  for (Contact& c : by_a) c.weight *= shares_.a;
  for (Contact& c : by_b) c.weight *= shares_.b;
}

std::size_t BodyPair::reserve_within(int work) {
  if (ball_) return 1;
  return (side_a_ ? side_a_->reserve_within(work) : 0) + (side_b_ ? side_b_->reserve_within(work) : 0);
}

Contact BodyPair::at(std::uint64_t key, const Pose& X_WA, const Pose& X_WB, const Shares& shares) const {
  const bool from_b = is_from_b(key);
  const Pose &X_WK = from_b ? X_WB : X_WA, &X_WO = from_b ? X_WA : X_WB;
  const ContactBody &body = from_b ? b_ : a_, &other = from_b ? a_ : b_;
  const std::size_t i = sample_of(key);
  const Vec3 p = ball_ ? Vec3{} : body.samples.points[i].p;
  const double radius = ball_ ? ball_->radius : sample_radius(body, i);
  const Vec3 x = transform(inverse(X_WO), transform(X_WK, p));
  const Nearest nearest = other.distance->nearest(x);
  Contact contact = from_b ? of_b(X_WA, X_WB, p, radius, nearest) : of_a(X_WA, X_WB, p, radius, nearest);
  contact.H_W = curvature(from_b, X_WA, X_WB, nearest, x);
  contact.weight = ball_ ? 1 : (from_b ? shares.b : shares.a) * weight(contact, from_b, i, X_WK.R);
  return contact;
}

}  // namespace tactor
