#include "nodes/physics/mesh/crease.hpp"

#include <utility>

namespace tactor {

namespace {

/// The least share of the area that a part has.
constexpr double least_share = 0.01;

/// Both as one.
FacingArea together(const FacingArea& a, const FacingArea& b) {
  const double area = a.area + b.area;
  return {area, (a.area * a.normal + b.area * b.normal) / area};
}

double squared_distance(const Vec3& a, const Vec3& b) {
  return dot(a - b, a - b);
}

/// What chains of alike faces connect, each as one. Faces that nothing connects with one before are left over.
std::vector<FacingArea> connected(std::vector<FacingArea> left) {
  std::vector<FacingArea> parts, chain;
  while (!left.empty()) {
    chain.assign(1, left.back());
    left.pop_back();
    FacingArea part = chain.front();
    for (std::size_t i = 0; i < chain.size(); ++i) {
      const Vec3 normal = chain[i].normal;
      for (std::size_t k = left.size(); k-- > 0;) {
        if (dot(normal, left[k].normal) < same_part) continue;
        part = together(part, left[k]);
        chain.push_back(left[k]);
        left[k] = left.back();
        left.pop_back();
      }
    }
    parts.push_back(part);
  }
  return parts;
}

/// The one that faces most as part i does.
std::size_t nearest_to(std::size_t i, const std::vector<FacingArea>& parts) {
  std::size_t nearest = i == 0 ? 1 : 0;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    if (k != i &&
        squared_distance(parts[k].normal, parts[i].normal) < squared_distance(parts[nearest].normal, parts[i].normal)) {
      nearest = k;
    }
  }
  return nearest;
}

/// The one that is nearest to another.
std::size_t least_apart(const std::vector<FacingArea>& parts) {
  std::size_t best = 0;
  double least = 5;  // more than any two are apart
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const double apart = squared_distance(parts[i].normal, parts[nearest_to(i, parts)].normal);
    if (apart < least) best = i, least = apart;
  }
  return best;
}

}  // namespace

std::optional<Crease> find_crease(std::vector<FacingArea> faces) {
  std::erase_if(faces, [](const FacingArea& face) { return !(face.area > 0); });
  double area = 0;
  for (const FacingArea& face : faces) area += face.area;
  std::vector<FacingArea> parts = connected(std::move(faces));
  while (parts.size() > 1) {
    const auto smaller = [](const FacingArea& a, const FacingArea& b) { return a.area < b.area; };
    const auto smallest =
        static_cast<std::size_t>(std::min_element(parts.begin(), parts.end(), smaller) - parts.begin());
    const bool too_small = parts[smallest].area < least_share * area;
    if (!too_small && parts.size() <= Crease::capacity) break;
    const std::size_t from = too_small ? smallest : least_apart(parts);
    const std::size_t to = nearest_to(from, parts);
    parts[to] = together(parts[to], parts[from]);
    parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(from));
  }
  if (parts.size() < 2) return {};
  Crease crease;
  crease.parts = parts.size();
  std::copy(parts.begin(), parts.end(), crease.part.begin());
  return crease;
}

}  // namespace tactor
