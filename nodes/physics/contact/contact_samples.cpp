#include "nodes/physics/contact/contact_samples.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

constexpr double most_samples = 1e6;

/// Parts of `length` that are no longer than `spacing`; the allowance keeps n times the spacing at n.
double parts(double length, double spacing) {
  return std::max(1.0, std::ceil(length / spacing * (1 - 1e-12)));
}

void check_count(double count, double spacing) {
  if (count <= most_samples) return;
  throw InputError("a spacing of " + std::to_string(1e3 * spacing) +
                   " mm gives this shape more than a million contact samples; give a larger one");
}

ContactSamples capsule_samples(const CapsuleShape& capsule, double spacing) {
  const double n = std::max(2.0, parts(capsule.length, spacing));
  check_count(n + 1, spacing);
  ContactSamples samples;
  const double between = capsule.length / (2 * capsule.radius) / (n - 1);
  for (double i = 0; i <= n; ++i) {
    samples.points.push_back({.p = {0, 0, capsule.length * (i / n - 0.5)}});
    samples.radii.push_back(capsule.radius);
    samples.weights.push_back(i == 0 || i == n ? 1 : between);
  }
  return samples;
}

ContactSamples box_samples(const BoxShape& box, double spacing) {
  const Vec3 n{parts(box.size.x, spacing), parts(box.size.y, spacing), parts(box.size.z, spacing)};
  check_count(2 * ((n.x + 1) * (n.y + 1) + (n.y + 1) * (n.z + 1) + (n.z + 1) * (n.x + 1)), spacing);
  ContactSamples samples;
  Vec3 i;
  for (i.z = 0; i.z <= n.z; ++i.z) {
    for (i.y = 0; i.y <= n.y; ++i.y) {
      for (i.x = 0; i.x <= n.x; ++i.x) {
        Vec3 p, part;
        for (int axis = 0; axis < 3; ++axis) {
          const bool at_end = i[axis] == 0 || i[axis] == n[axis];
          p[axis] = box.size[axis] * (i[axis] / n[axis] - 0.5);
          part[axis] = box.size[axis] / n[axis] * (at_end ? 0.5 : 1.0);
        }
        double area = 0;
        Vec3 sum;  // m^2
        std::vector<FacingArea> faces;
        for (int axis = 0; axis < 3; ++axis) {
          if (i[axis] != 0 && i[axis] != n[axis]) continue;
          Vec3 normal;
          normal[axis] = i[axis] == 0 ? -1 : 1;
          faces.push_back({part[(axis + 1) % 3] * part[(axis + 2) % 3], normal});
          area += faces.back().area;
          sum += faces.back().area * normal;
        }
        if (faces.empty()) continue;
        samples.points.push_back({p, area, sum / norm(sum)});
        if (const std::optional<Crease> crease = find_crease(faces)) {
          samples.points.back().crease = static_cast<std::int32_t>(samples.creases.size());
          samples.creases.push_back(*crease);
        }
      }
    }
  }
  return samples;
}

}  // namespace

double default_spacing(const Shape& shape) {
  if (const auto* capsule = std::get_if<CapsuleShape>(&shape)) return std::sqrt(0.08) * capsule->radius;
  if (const auto* box = std::get_if<BoxShape>(&shape)) return std::max({box->size.x, box->size.y, box->size.z}) / 8;
  return 0;
}

double area_facing(const ContactSamples& samples, std::size_t i, const Vec3& towards) {
  const SurfaceSample& sample = samples.points[i];
  if (sample.crease < 0) {
    return sample.normal == Vec3{} ? sample.area : sample.area * std::max(0.0, dot(sample.normal, towards));
  }
  const Crease& crease = samples.creases[static_cast<std::size_t>(sample.crease)];
  double most = dot(sample.normal, towards);
  for (std::size_t k = 0; k < crease.parts; ++k) most = std::max(most, dot(crease.part[k].normal, towards));
  return area_towards(crease, towards) * std::clamp(2 * most, 0.0, 1.0);
}

ContactSamples shape_samples(const Shape& shape, double spacing) {
  const double most = spacing > 0 ? spacing : default_spacing(shape);
  if (const auto* sphere = std::get_if<SphereShape>(&shape)) return {{SurfaceSample{}}, {sphere->radius}, {1}, {}};
  if (const auto* capsule = std::get_if<CapsuleShape>(&shape)) return capsule_samples(*capsule, most);
  if (const auto* box = std::get_if<BoxShape>(&shape)) return box_samples(*box, most);
  if (std::holds_alternative<PlaneShape>(shape)) return {};
  throw InputError("the samples of a mesh are those of its faces");
}

}  // namespace tactor
