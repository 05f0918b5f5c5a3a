#include "nodes/physics/contact/soft_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "framework/core/value_error.hpp"
#include "nodes/physics/contact/materials.hpp"

namespace tactor {

namespace {

constexpr std::size_t usual_soft_contacts = 4096;
constexpr double most_parts = 64;  // of a face's side
constexpr double third = 1.0 / 3.0;

/// How far apart the surface's samples may be before a rigid body, m; 0: it does not matter.
double surface_spacing(const ContactBody& body, double given) {
  if (std::holds_alternative<PlaneShape>(body.shape)) return 0;
  if (given > 0) return given;
  if (const auto* sphere = std::get_if<SphereShape>(&body.shape)) return sphere->radius / 3;
  if (const auto* capsule = std::get_if<CapsuleShape>(&body.shape)) return capsule->radius / 3;
  return body.box.longest() / 16;
}

/// The rigid body with the samples that meet a deforming surface.
ContactBody soft_contact_body(const Body& body, const SoftContactOptions& options,
                              const MakeMeshDistance& make_distance, Notes* notes) {
  double spacing = options.soft_spacing;
  if (body.mesh() != nullptr && spacing == 0) spacing = bounds_of(load_body_mesh(body)).longest() / 16;
  return ContactBody(body, spacing, true, options.soft_margin, make_distance, notes);
}

bool has_balls(const ContactBody& body) {
  return !body.samples.radii.empty();
}

SoftContactOptions checked(const SoftContactOptions& options) {
  const auto refuse = [](const std::string& path, const std::string& expected, double found) {
    throw ValueError(path, "expected " + expected + ", found " + std::to_string(found));
  };
  if (!(options.soft_margin >= 0 && std::isfinite(options.soft_margin)))
    refuse("margin", "0 m or more", options.soft_margin);
  if (!(options.soft_spacing >= 0 && std::isfinite(options.soft_spacing)))
    refuse("spacing", "0 m or more", options.soft_spacing);
  if (options.soft_contacts < 4 || options.soft_contacts > ContactSet::capacity) {
    refuse("max_contacts", "4 to " + std::to_string(ContactSet::capacity), options.soft_contacts);
  }
  if (options.soft_work < 0) refuse("most_work", "0 or more", options.soft_work);
  return options;
}

Contact of_material(const Material& material) {
  return {.stiffness = material.stiffness, .damping = material.damping, .friction = material.friction};
}

/// m, how far normals of faces are averaged at most: about two of their edges.
double smoothing_of(std::span<const double> areas) {
  double sum = 0;
  for (const double area : areas) sum += std::isfinite(area) ? std::max(area, 0.0) : 0;
  return areas.empty() ? 0 : 3 * std::sqrt(sum / static_cast<double>(areas.size()));
}

/// The box about a box at that pose.
Bounds box_at(const Pose& X, const Bounds& box) {
  Bounds all;
  if (!std::isfinite(box.longest())) {
    constexpr double endless = std::numeric_limits<double>::infinity();
    all.add({-endless, -endless, -endless});
    all.add({endless, endless, endless});
    return all;
  }
  const Vec3 middle = transform(X, box.middle()), half = 0.5 * box.size();
  const Vec3 x = rotate(X.R, {half.x, 0, 0}), y = rotate(X.R, {0, half.y, 0}), z = rotate(X.R, {0, 0, half.z});
  const Vec3 reach{std::abs(x.x) + std::abs(y.x) + std::abs(z.x), std::abs(x.y) + std::abs(y.y) + std::abs(z.y),
                   std::abs(x.z) + std::abs(y.z) + std::abs(z.z)};
  all.add(middle - reach);
  all.add(middle + reach);
  return all;
}

void place(Points8& points, std::size_t k, const Vec3& p) {
  points.x[k] = static_cast<float>(p.x);
  points.y[k] = static_cast<float>(p.y);
  points.z[k] = static_cast<float>(p.z);
}
/// m, how far from a point in floats something may be that is within the root of `squared` from `middle`.
float reach_about(const Vec3& middle, double squared) {
  constexpr double rounding = 1e-6;  // of lengths
  return static_cast<float>((std::sqrt(squared) + norm(middle) * rounding) * (1 + rounding));
}

/// Where p + u e is in the box: the least and the greatest u, which are the wrong way round where it is nowhere.
std::pair<double, double> inside(const Bounds& box, const Vec3& p, const Vec3& e) {
  double low = 0, high = 1;
  for (int axis = 0; axis < 3; ++axis) {
    if (e[axis] == 0) {
      if (!(p[axis] >= box.low[axis] && p[axis] <= box.high[axis])) return {1, 0};
      continue;
    }
    const double a = (box.low[axis] - p[axis]) / e[axis], b = (box.high[axis] - p[axis]) / e[axis];
    low = std::max(low, std::min(a, b));
    high = std::min(high, std::max(a, b));
  }
  return {low, high};
}

}  // namespace

SoftContacts::Side::Side(const SoftContactOptions& options, std::size_t most) : reduction(options.soft_contacts, most) {
  contacts.reserve(most);
  spots.reserve(most);
}

SoftContacts::SoftContacts(const Scene& scene, const SoftContactOptions& options, const MakeMeshDistance& make_distance,
                           Notes* notes)
    : margin_(checked(options).soft_margin),
      most_work_(options.soft_work),
      deformable_(scene.deformable().size()),
      all_(options, usual_soft_contacts),
      patch_(options, static_cast<std::size_t>(options.soft_work) + 1),
      set_(std::make_unique<ContactSet>()) {
  const auto take = [&](const Body& body, std::int32_t index) {
    ContactBody made = soft_contact_body(body, options, make_distance, notes);
    const double spacing = surface_spacing(made, options.soft_spacing);
    std::vector<Material> material;
    for (const std::size_t k : scene.deformable()) material.push_back(combine(body.material, scene.bodies[k].material));
    SoftSampleTree samples(has_balls(made) ? std::vector<SurfaceSample>{} : made.samples.points);
    bodies_.push_back({std::move(made), index, spacing, index == ContactPair::fixed ? 2 : 1, std::move(material),
                       std::move(samples)});
  };
  std::int32_t index = 0;
  for (const std::size_t i : scene.moving()) take(scene.bodies[i], index++);
  for (const Body& body : scene.bodies) {
    if (body.motion == Motion::fixed) take(body, ContactPair::fixed);
  }
  for (Side* side : {&all_, &patch_}) {
    side->extents.resize(deformable_);
    for (const Rigid& rigid : bodies_) side->memory.push_back(rigid.samples.new_memory());
  }
  patch_.surface.reserve(most_patch_faces, most_patch_nodes);
  patch_.near.reserve(most_patch_faces);
  const auto most = static_cast<std::size_t>(most_work_) + 1;
  patch_.own.reserve(most);
  if (deformable_ > 1) {
    patch_.order.reserve(most);
    patch_.sorted.reserve(most);
    patch_.sorted_spots.reserve(most);
  }
}

void SoftContacts::set_surface(SoftSurface surface, std::span<const Vec3> nodes_at_rest) {
  TACTOR_DEMAND(surface.body.size() == surface.faces.size() && surface.area.size() == surface.faces.size());
  for (const std::int32_t k : surface.body) TACTOR_DEMAND(k >= 0 && static_cast<std::size_t>(k) < deformable_);
  whole_ = std::move(surface);
  all_.surface.set(whole_.faces, nodes_at_rest);
  all_.body = whole_.body;
  all_.area = whole_.area;
  all_.last_face = -1;
  all_.smoothing = smoothing_of(whole_.area);
}

void SoftContacts::find(std::span<const Vec3> nodes_W, const BodyStates& bodies, std::vector<SoftContact>& found) {
  all_.surface.move(nodes_W);
  all_.contacts.clear();
  all_.spots.clear();
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    Rigid& rigid = bodies_[i];
    TACTOR_ASSERT(rigid.index < bodies.count);
    look(rigid, i,
         rigid.index == ContactPair::fixed ? rigid.body.X_WB : bodies.X_WB[static_cast<std::size_t>(rigid.index)],
         all_);
  }
  keep(all_, found);
}

bool SoftContacts::find_on(std::span<const std::array<std::int32_t, 3>> faces, std::span<const std::int32_t> body,
                           std::span<const double> areas, std::span<const Vec3> nodes_W, const Pose& X_WT,
                           std::vector<SoftContact>& found) {
  TACTOR_DEMAND(faces.size() <= most_patch_faces && nodes_W.size() <= most_patch_nodes);
  TACTOR_DEMAND(body.size() == faces.size() && areas.size() == faces.size());
  found.clear();
  work_ = 0;
  if (bodies_.empty() || bodies_.front().index != 0 || faces.empty()) return true;
  for (const std::int32_t k : body) TACTOR_DEMAND(k >= 0 && static_cast<std::size_t>(k) < deformable_);
  const std::vector<FaceNodes>& known = patch_.surface.faces();
  if (patch_nodes_ == nodes_W.size() && std::equal(faces.begin(), faces.end(), known.begin(), known.end())) {
    patch_.surface.move(nodes_W);
  } else {
    patch_.surface.set(faces, nodes_W);
    patch_nodes_ = nodes_W.size();
    patch_.last_face = -1;
  }
  patch_.body = body;
  patch_.area = areas;
  patch_.smoothing = smoothing_of(areas);
  patch_.contacts.clear();
  patch_.spots.clear();
  int left = most_work_;
  patch_.left = &left;
  look(bodies_.front(), 0, X_WT, patch_);
  patch_.left = nullptr;
  work_ = most_work_ - left;
  if (left < 0) return false;
  keep(patch_, found);
  return true;
}

void SoftContacts::look(Rigid& rigid, std::size_t number, const Pose& X_WT, Side& side) {
  const double turn = X_WT.R.w + X_WT.R.x + X_WT.R.y + X_WT.R.z;
  if (!is_finite(X_WT.p) || !std::isfinite(turn)) return;
  const std::size_t first = side.contacts.contact.size();
  std::fill(side.extents.begin(), side.extents.end(), std::array<double, 2>{});
  const Pose X_TW = inverse(X_WT);
  const SignedDistance& distance = *rigid.body.distance;
  // Whether all of a box is too far from the rigid body.
  const auto is_far = [&](const Bounds& box) {
    side.work();
    const Vec3 middle = transform(X_TW, box.middle());
    const float reach = reach_about(middle, 0.25 * dot(box.size(), box.size()));
    Points8 points{};
    place(points, 0, middle);
    std::array<float, 8> bound;
    distance.lower_bounds(points, 1, bound);
    return bound[0] - reach >= margin_;
  };
  side.surface.faces_in(larger(box_at(X_WT, rigid.body.box), margin_), is_far, side.near);
  look_at_faces(rigid, number, X_WT, side);
  if (side.over()) return;
  if (has_balls(rigid.body)) return look_at_balls(rigid, number, X_WT, side);
  look_at_samples(rigid, number, X_WT, side);
  if (side.over()) return;
  share_out(first, side);
}

/// The samples of the faces that are near, eight faces at a time: where the middle of a face is too far, it has none.
void SoftContacts::look_at_faces(const Rigid& rigid, std::size_t number, const Pose& X_WT, Side& side) {
  const SignedDistance& distance = *rigid.body.distance;
  const Pose X_TW = inverse(X_WT);
  const Bounds box = larger(rigid.body.box, margin_);
  FaceSamples samples;
  std::array<TurnedFace, 8> eight;
  Points8 middles;
  std::array<float, 8> reach, bound;
  std::size_t count = 0;
  const auto look_at_eight = [&] {
    distance.lower_bounds(middles, (1U << count) - 1U, bound);
    for (std::size_t k = 0; k < count && !side.over(); ++k) {
      if (!(bound[k] - reach[k] < margin_)) continue;
      look_at_face(rigid, number, X_WT, box, eight[k], samples, side);
    }
    count = 0;
  };
  for (const std::int32_t face : side.near) {
    if (side.over()) return;
    side.work();
    const double area = side.area[static_cast<std::size_t>(face)];
    if (!(area > 0) || !std::isfinite(area)) continue;
    const Vec3 a = transform(X_TW, side.surface.corner(face, 0)), b = transform(X_TW, side.surface.corner(face, 1)),
               c = transform(X_TW, side.surface.corner(face, 2)), ab = b - a, ac = c - a;
    Bounds of_face;
    for (const Vec3& corner : {a, b, c}) of_face.add(corner);
    if (!boxes_meet(of_face, box)) continue;
    const Vec3 across = cross(ab, ac);
    const double doubled = norm(across);
    if (!(doubled > 0) || !std::isfinite(doubled)) continue;
    eight[count] = {face, a, ab, ac, across / doubled};
    const Vec3 middle = third * (a + b + c);
    place(middles, count, middle);
    const double squared =
        std::max({dot(a - middle, a - middle), dot(b - middle, b - middle), dot(c - middle, c - middle)});
    reach[count] = reach_about(middle, squared);
    if (++count == 8) look_at_eight();
  }
  if (count > 0) look_at_eight();
  if (samples.count > 0) look_at_face_samples(rigid, number, X_WT, samples, side);
}

/// Takes the samples of a face, which is in the frame of the rigid body; looks at eight of them at a time.
void SoftContacts::look_at_face(const Rigid& rigid, std::size_t number, const Pose& X_WT, const Bounds& box,
                                const TurnedFace& turned, FaceSamples& samples, Side& side) {
  const auto& [face, a, ab, ac, facing] = turned;
  const auto at = static_cast<std::size_t>(face);
  const double area = side.area[at];
  const Material& material = rigid.material[static_cast<std::size_t>(side.body[at])];
  const double wanted = rigid.spacing > 0 ? std::ceil(4 * third * std::sqrt(area) / rigid.spacing * (1 - 1e-12)) : 1;
  const int n = std::max(static_cast<int>(std::min(wanted, most_parts)), rigid.least_parts);
  const double weight = area / (static_cast<double>(n) * n) / material.patch_area;
  for (int row = 0; row < 2 * n - 1; ++row) {
    side.work();
    // Triangles that stand as the face does, and between them those that are turned by half a turn.
    const int j = row / 2;
    const double at_third = row % 2 == 0 ? third : 2 * third, v = (j + at_third) / n;
    const int count = n - j - row % 2;
    const auto [low, high] = inside(box, a + v * ac, ab);
    const double from = std::max(0.0, std::ceil(low * n - at_third - 1e-9)),
                 to = std::min(count - 1.0, std::floor(high * n - at_third + 1e-9));
    for (double i = from; i <= to; ++i) {
      if (side.over()) return;
      side.work();
      const double u = (i + at_third) / n;
      const auto sample = static_cast<std::uint64_t>(row * 64) + static_cast<std::uint64_t>(i);
      FaceSample& taken = samples.sample[samples.count];
      taken = {a + u * ab + v * ac,
               facing,
               {face, {1 - u - v, u, v}},
               weight,
               static_cast<std::uint64_t>(face) << 13U | sample};
      place(samples.points, samples.count, taken.p_T);
      if (++samples.count == 8) look_at_face_samples(rigid, number, X_WT, samples, side);
    }
  }
}

/// The contacts of samples of faces; forgets the samples.
void SoftContacts::look_at_face_samples(const Rigid& rigid, std::size_t number, const Pose& X_WT, FaceSamples& samples,
                                        Side& side) {
  const SignedDistance& distance = *rigid.body.distance;
  std::array<float, 8> bound;
  distance.lower_bounds(samples.points, (1U << samples.count) - 1U, bound);
  for (std::size_t k = 0; k < samples.count; ++k) {
    const auto& [p_T, facing, spot, weight, sample] = samples.sample[k];
    if (!(bound[k] - reach_about(p_T, 0) < margin_)) continue;
    const Nearest near = distance.nearest(p_T, samples.hint);
    samples.hint = near.face;
    if (!(near.distance < margin_)) continue;
    const double counts = std::clamp(-4 * dot(near.gradient, facing), 0.0, 1.0);
    if (!(counts > 0)) continue;
    const auto deformable = static_cast<std::size_t>(side.body[static_cast<std::size_t>(spot.face)]);
    Contact contact = of_material(rigid.material[deformable]);
    contact.p_TC = near.p;
    contact.n_W = -rotate(X_WT.R, near.gradient);
    contact.p_WC = spot.share[0] * side.surface.corner(spot.face, 0) +
                   spot.share[1] * side.surface.corner(spot.face, 1) +
                   spot.share[2] * side.surface.corner(spot.face, 2);
    contact.distance = near.distance;
    contact.weight = counts * weight;
    side.extents[deformable][0] += contact.weight * (margin_ - contact.distance);
    add(contact, rigid, number, false, sample, spot, side);
  }
  samples.count = 0;
}

/// The balls whose centres are deep.
void SoftContacts::look_at_balls(Rigid& rigid, std::size_t number, const Pose& X_WT, Side& side) {
  const ContactSamples& samples = rigid.body.samples;
  const Bounds box = side.surface.inner_box();
  for (std::size_t i = 0; i < samples.points.size(); ++i) {
    if (side.over()) return;
    side.work();
    const double r = samples.radii[i], reach = 0.25 * r;
    const Vec3 centre = transform(X_WT, samples.points[i].p);
    if (!(squared_to_box(box, centre) <= reach * reach)) continue;
    const SurfacePoint near = side.surface.nearest(centre, side.last_face, side.left);
    side.last_face = near.face;
    if (near.distance >= reach) {
      // The distance changes by no more than the way along the axis.
      const double clear = (near.distance - reach) * (1 - 1e-9);
      const Vec3& here = samples.points[i].p;
      while (i + 1 < samples.points.size() && norm(samples.points[i + 1].p - here) < clear) ++i;
      continue;
    }
    if (!near.judged) continue;
    const Material& material = rigid.material[static_cast<std::size_t>(side.body[static_cast<std::size_t>(near.face)])];
    Contact contact = of_material(material);
    contact.n_W = side.surface.mean_normal(near, std::min(r, side.smoothing), side.near, side.left);
    contact.p_WC = near.p;
    contact.p_TC = samples.points[i].p - r * rotate(inverse(X_WT.R), contact.n_W);
    contact.distance = dot(contact.n_W, centre - near.p) - r;
    contact.weight = samples.weights[i] * std::max(1.0, r * r / material.patch_area) *
                     std::clamp(1 - near.distance / reach, 0.0, 1.0);
    add(contact, rigid, number, true, i, {near.face, near.share}, side);
  }
}

/// The samples of the rigid body.
void SoftContacts::look_at_samples(Rigid& rigid, std::size_t number, const Pose& X_WT, Side& side) {
  if (!boxes_meet(box_at(X_WT, rigid.body.box), larger(side.surface.inner_box(), margin_))) return;
  rigid.samples.find(side.surface, X_WT, margin_, side.left, side.memory[number], side.own);
  if (side.over()) return;
  const ContactSamples& samples = rigid.body.samples;
  const double smoothing = std::min(rigid.body.box.longest() / 8, side.smoothing);
  for (const NearSoftSample& own : side.own) {
    const SurfaceSample& sample = samples.points[static_cast<std::size_t>(own.sample)];
    const auto deformable = static_cast<std::size_t>(side.body[static_cast<std::size_t>(own.at.face)]);
    const Material& material = rigid.material[deformable];
    Contact contact = of_material(material);
    contact.p_TC = sample.p;
    contact.p_WC = own.at.p;
    contact.n_W = side.surface.mean_normal(own.at, smoothing, side.near, side.left);
    if (side.over()) return;
    contact.distance = dot(contact.n_W, transform(X_WT, sample.p) - own.at.p);
    // The normal leads from the surface to the rigid body.
    const Vec3 towards = rotate(inverse(X_WT.R), -contact.n_W);
    contact.weight = area_facing(samples, static_cast<std::size_t>(own.sample), towards) / material.patch_area;
    side.extents[deformable][1] += contact.weight * (margin_ - own.at.distance);
    add(contact, rigid, number, true, static_cast<std::uint64_t>(own.sample), {own.at.face, own.at.share}, side);
  }
}

void SoftContacts::add(const Contact& contact, const Rigid& rigid, std::size_t number, bool of_rigid,
                       std::uint64_t sample, const Spot& spot, Side& side) const {
  const bool finite = is_finite(contact.p_TC) && is_finite(contact.p_WC) && is_finite(contact.n_W) &&
                      std::isfinite(contact.distance) && std::isfinite(contact.weight);
  if (!finite || !(contact.weight > 0)) return;
  const auto pair = static_cast<std::uint64_t>(number * deformable_) +
                    static_cast<std::uint64_t>(side.body[static_cast<std::size_t>(spot.face)]);
  side.contacts.contact.push_back(contact);
  side.contacts.pair.push_back({rigid.index, ContactPair::fixed});
  side.contacts.key.push_back(contact_key(pair, of_rigid, sample));
  side.spots.push_back(spot);
}

/// Both sides' samples together count once.
void SoftContacts::share_out(std::size_t first, Side& side) const {
  for (std::size_t i = first; i < side.contacts.contact.size(); ++i) {
    const std::uint64_t key = side.contacts.key[i];
    const auto& [of_surface, of_body] = side.extents[static_cast<std::size_t>(pair_number(key)) % deformable_];
    side.contacts.contact[i].weight *= (is_from_b(key) ? of_body : of_surface) / (of_surface + of_body);
  }
}

/// Keeps no more than there is room for.
void SoftContacts::keep(Side& side, std::vector<SoftContact>& found) {
  const auto pair_at = [&](std::size_t i) { return pair_number(side.contacts.key[i]); };
  bool together = true;
  for (std::size_t i = 1; i < side.spots.size(); ++i) together = together && pair_at(i - 1) <= pair_at(i);
  if (!together) {
    side.order.resize(side.spots.size());
    std::iota(side.order.begin(), side.order.end(), 0);
    std::sort(side.order.begin(), side.order.end(),
              [&](std::size_t a, std::size_t b) { return pair_at(a) != pair_at(b) ? pair_at(a) < pair_at(b) : a < b; });
    side.sorted.clear();
    side.sorted_spots.clear();
    for (const std::size_t i : side.order) {
      side.sorted.contact.push_back(side.contacts.contact[i]);
      side.sorted.pair.push_back(side.contacts.pair[i]);
      side.sorted.key.push_back(side.contacts.key[i]);
      side.sorted_spots.push_back(side.spots[i]);
    }
    std::swap(side.sorted, side.contacts);
    std::swap(side.sorted_spots, side.spots);
  }
  side.reduction.reduce(side.contacts, *set_);
  found.clear();
  const std::vector<std::size_t>& kept = side.reduction.kept();
  for (std::size_t j = 0; j < kept.size(); ++j) {
    const Spot& spot = side.spots[kept[j]];
    found.push_back(
        {set_->contact[j], set_->pair[j].body, side.surface.faces()[static_cast<std::size_t>(spot.face)], spot.share});
  }
}

}  // namespace tactor
