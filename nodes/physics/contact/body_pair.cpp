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
  double rim = 0;  // of those at edges and corners
  void add(double extent, bool at_rim) {
    all += extent;
    if (at_rim) rim += extent;
  }
};

/// What one side's contacts push with at rest, in units of stiffness; those that do not touch count a little, so that
/// it changes continuously where the first one touches.
struct Push {
  double sum = 0;     // m
  Vec3 force;         // m
  Vec3 torque;        // m^2, about the reference point
  Vec3 first;         // m^2, sum of push times place, from the reference point
  double second = 0;  // m^3, of push times squared distance from it

  void add(const Contact& c, double margin, const Vec3& reference) {
    const double push = c.weight * (std::max(0.0, -c.distance) + 1e-3 * (margin - c.distance));
    // Halfway from the one body's point to the other's, so that both bodies are alike.
    const Vec3 p = c.p_WC + 0.5 * c.distance * c.n_W - reference, f = push * c.n_W;
    sum += push;
    force += f;
    torque += cross(p, f);
    first += push * p;
    second += push * dot(p, p);
  }
};

/// 1 where two sides push alike, 0 where they do not: by the differences of force and torque, these in units of how far
/// the contacts spread, over the sum of both.
double likeness(const Push& a, const Push& b) {
  constexpr double alike = 0.25, unlike = 0.5;
  const double sum = a.sum + b.sum;
  if (!(sum > 0)) return 0;
  const Vec3 centre = (a.first + b.first) / sum, force = a.force - b.force;
  const Vec3 torque = a.torque - b.torque - cross(centre, force);
  const double spread = std::sqrt(std::max(0.0, (a.second + b.second) / sum - dot(centre, centre)));
  const double difference = norm(force) / sum + (spread > 0 ? norm(torque) / (spread * sum) : 0);
  return std::clamp((unlike - difference) / (unlike - alike), 0.0, 1.0);
}

Push push_of(std::span<const Contact> contacts, double margin, const Vec3& reference) {
  Push push;
  for (const Contact& c : contacts) push.add(c, margin, reference);
  return push;
}

/// How much more of the rim is a's, from -1 to 1, as far as both push alike.
double lean_of(const Extent& a, const Extent& b, std::span<const Contact> by_a, std::span<const Contact> by_b,
               double margin) {
  constexpr double little = 0.01;  // of all, where the rim begins to count
  const double lean = (a.rim - b.rim) / (a.rim + b.rim + little * (a.all + b.all));
  if (lean == 0) return 0;
  const Vec3 reference = by_a.front().p_WC;
  return lean * likeness(push_of(by_a, margin, reference), push_of(by_b, margin, reference));
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
  if (!a.samples.points.empty() && !(one_is_round && is_round(b))) side_a_ = make_side(a);
  if (!b.samples.points.empty() && !(one_is_round && is_round(a))) side_b_ = make_side(b);
}

BodyPair::Side BodyPair::make_side(const ContactBody& body) const {
  std::vector<double> weights = body.samples.weights;
  if (weights.empty()) {
    for (const SurfaceSample& s : body.samples.points) weights.push_back(s.area / material_.patch_area);
  }
  return {SampleTree(body.samples.points, body.samples.radii), std::move(weights)};
}

bool BodyPair::may_meet(const Pose& X_WA, const Pose& X_WB) const {
  const Vec3 apart = transform(X_WA, a_.p_BM) - (p_WM_of_b_ ? *p_WM_of_b_ : transform(X_WB, b_.p_BM));
  const double reach = a_.radius + b_.radius + margin_;
  return dot(apart, apart) <= reach * reach;
}

/// The contact of a point of a, or of a ball about it, with b's surface, `n` being what b's distance gave at x_B.
Contact BodyPair::of_a(const Pose& X_WA, const Pose& X_WB, const Vec3& p_A, double radius, const Nearest& n,
                       const Vec3& x_B) const {
  Contact c{.stiffness = material_.stiffness, .damping = material_.damping, .friction = material_.friction};
  c.n_W = rotate(X_WB.R, n.gradient);
  c.p_TC = radius == 0 ? p_A : p_A - radius * rotate(inverse(X_WA.R), c.n_W);
  c.p_WC = transform(X_WB, n.p);
  c.distance = n.distance - radius;
  c.H_W = turned(X_WB.R, b_.distance->hessian(n, x_B));
  return c;
}

/// The contact of a point of b, or of a ball about it, with a's surface, `n` being what a's distance gave at x_A.
Contact BodyPair::of_b(const Pose& X_WA, const Pose& X_WB, const Vec3& p_B, double radius, const Nearest& n,
                       const Vec3& x_A) const {
  Contact c{.stiffness = material_.stiffness, .damping = material_.damping, .friction = material_.friction};
  c.n_W = -rotate(X_WA.R, n.gradient);
  c.p_TC = n.p;
  c.p_WC = transform(X_WB, p_B) + radius * c.n_W;
  c.distance = n.distance - radius;
  // The distance is as curved seen from the one body as from the other.
  c.H_W = turned(X_WA.R, a_.distance->hessian(n, x_A));
  return c;
}

/// Of the sample in that contact, all of which is known but the weight; in patches.
double BodyPair::weight(const Contact& contact, bool from_b, std::size_t sample, const Quat& R_WK) const {
  const ContactSamples& samples = from_b ? b_.samples : a_.samples;
  const std::int32_t crease = samples.points[sample].crease;
  if (crease < 0) return (from_b ? side_b_ : side_a_)->weights[sample];
  // The normal leads from b to a.
  const Vec3 towards = rotate(inverse(R_WK), from_b ? contact.n_W : -contact.n_W);
  return area_towards(samples.creases[static_cast<std::size_t>(crease)], towards) / material_.patch_area;
}

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
  add(ball_is_a_ ? of_a(X_WA, X_WB, {}, ball_->radius, ball_->last, x)
                 : of_b(X_WA, X_WB, {}, ball_->radius, ball_->last, x),
      1, !ball_is_a_, 0, found);
}

void BodyPair::find(const Pose& X_WA, const Pose& X_WB, FoundContacts& found, int* left) {
  shares_ = {};
  if (!may_meet(X_WA, X_WB)) return;
  if (ball_) return find_ball(X_WA, X_WB, found);
  const Quat to_B = inverse(X_WB.R);
  const Pose X_BA{rotate(to_B, X_WA.p - X_WB.p), R_BA_ ? *R_BA_ : to_B * X_WA.R};
  const Pose X_AB = inverse(X_BA);
  static const std::vector<NearSample> none;
  const std::vector<NearSample>& of_side_a = side_a_ ? side_a_->tree.find(*b_.distance, X_BA, margin_, left) : none;
  const std::vector<NearSample>& of_side_b = side_b_ ? side_b_->tree.find(*a_.distance, X_AB, margin_, left) : none;
  // Not all are known, and nobody asks for some.
  if (left != nullptr && *left < 0) return;

  const std::size_t first = found.contact.size();
  Extent of_a_side, of_b_side;
  for (const NearSample& n : of_side_a) {
    const auto i = static_cast<std::size_t>(n.sample);
    const Vec3& p_A = a_.samples.points[i].p;
    const Contact c = of_a(X_WA, X_WB, p_A, sample_radius(a_, i), n.nearest, transform(X_BA, p_A));
    const double w = weight(c, false, i, X_WA.R);
    of_a_side.add(w * (margin_ - n.distance), a_.samples.points[i].crease >= 0);
    add(c, w, false, i, found);
  }
  const std::size_t first_of_b = found.contact.size();
  for (const NearSample& n : of_side_b) {
    const auto i = static_cast<std::size_t>(n.sample);
    const Vec3& p_B = b_.samples.points[i].p;
    const Contact c = of_b(X_WA, X_WB, p_B, sample_radius(b_, i), n.nearest, transform(X_AB, p_B));
    const double w = weight(c, true, i, X_WB.R);
    of_b_side.add(w * (margin_ - n.distance), b_.samples.points[i].crease >= 0);
    add(c, w, true, i, found);
  }
  if (of_a_side.all + of_b_side.all <= 0) return found.shorten(first);
  const std::span<Contact> by_a = std::span(found.contact).subspan(first, first_of_b - first),
                           by_b = std::span(found.contact).subspan(first_of_b);
  // Only where both sides have some is there a choice.
  const double lean = by_a.empty() || by_b.empty() ? 0 : lean_of(of_a_side, of_b_side, by_a, by_b, margin_);
  const double part_a = (1 + lean) * of_a_side.all, part_b = (1 - lean) * of_b_side.all;
  shares_ = {part_a / (part_a + part_b), part_b / (part_a + part_b)};
  for (Contact& c : by_a) c.weight *= shares_.a;
  for (Contact& c : by_b) c.weight *= shares_.b;
}

std::size_t BodyPair::reserve_within(int work) {
  if (ball_) return 1;
  return (side_a_ ? side_a_->tree.reserve_within(work) : 0) + (side_b_ ? side_b_->tree.reserve_within(work) : 0);
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
  Contact contact = from_b ? of_b(X_WA, X_WB, p, radius, nearest, x) : of_a(X_WA, X_WB, p, radius, nearest, x);
  contact.weight = ball_ ? 1 : (from_b ? shares.b : shares.a) * weight(contact, from_b, i, X_WK.R);
  return contact;
}

}  // namespace tactor
