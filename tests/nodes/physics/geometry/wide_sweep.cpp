// Prints a hash of everything that collision's vector functions find in a sweep, and for what processor they are.
#include <cstdio>

#include "nodes/physics/contact/contact_reduction.hpp"
#include "nodes/physics/geometry/cell_cache.hpp"
#include "nodes/physics/geometry/sample_tree.hpp"
#include "nodes/physics/geometry/wide.hpp"
#include "tests/support/dice.hpp"
#include "tests/support/shapes.hpp"

using namespace tactor;

namespace {

/// The bytes of numbers, one after the other.
class Bytes {
 public:
  template <class... Values>
  void add(const Values&... values) {
    (bytes_.append(reinterpret_cast<const char*>(&values), sizeof values), ...);
  }
  void add(const Vec3& v) { add(v.x, v.y, v.z); }
  void add(const Nearest& n) { add(n.distance), add(n.p), add(n.gradient), add(n.face, n.feature, n.of_face); }
  void print(const char* what, const char* solid) const {
    std::printf("%s %s %s\n", what, solid, content_key({bytes_}).c_str());
  }

 private:
  std::string bytes_;
};

#define TACTOR_TEXT(x) #x
#define TACTOR_TEXT_OF(x) TACTOR_TEXT(x)

/// What the resolvers of this program's clones go by.
const char* clones() {
  if (sizeof TACTOR_TEXT_OF(TACTOR_WIDE) == 1) return "none";
#ifdef __x86_64__
  __builtin_cpu_init();
  if (__builtin_cpu_supports("x86-64-v3")) return "x86-64-v3";
#endif
  return "default";
}

/// A ball with dents, so that no two faces are as near by symmetry.
TriangleMesh potato(test::Dice& dice) {
  TriangleMesh mesh = test::icosphere(0.05, 4);
  for (Vec3& v : mesh.vertices) v *= dice(0.96, 1.04);
  return mesh;
}

void sweep(const char* name, const TriangleMesh& mesh, test::Dice& dice) {
  const CellData data = build_cells(mesh, {.resolution = 48, .band = 0.004});
  std::printf("cells %s %s\n", name, content_key({to_bytes(data)}).c_str());
  const CellDistance cells(data);
  Bytes nearest, bounds, within;
  std::vector<std::uint32_t> found;
  for (int i = 0; i < 20'000; ++i) {
    const Vec3 x = i % 4 == 0 ? dice.in_cube(0.3) : dice.in_cube(0.06);
    nearest.add(cells.nearest(x));
    nearest.add(data.surface.signed_distance(data.tree.nearest(data.surface, x, -1), x));
    Points8 points{};
    for (std::size_t k = 0; k < 8; ++k) {
      points.x[k] = static_cast<float>(x.x + dice(-0.01, 0.01));
      points.y[k] = static_cast<float>(x.y + dice(-0.01, 0.01));
      points.z[k] = static_cast<float>(x.z + dice(-0.01, 0.01));
    }
    std::array<float, 8> bound{};
    cells.lower_bounds(points, 0xff, bound);
    bounds.add(bound);
    if (i % 20 != 0) continue;
    data.tree.within(x, dice(0, 0.1), found);
    for (const std::uint32_t record : found) within.add(record);
  }
  nearest.print("nearest", name);
  bounds.print("bounds", name);
  within.print("within", name);

  SampleTree tree(vertex_samples(mesh).points);
  ContactReduction reduction(64, 4096);
  Bytes near, kept;
  FoundContacts contacts;
  ContactSet set;
  Pose X{{0.05, 0.04, 0.055}, {}};
  for (int i = 0; i < 500; ++i) {
    X.p = X.p + dice.in_cube(0.0005);
    X.R = from_rotation_vector(dice.in_cube(0.01)) * X.R;
    contacts.clear();
    for (const NearSample& n : tree.find(cells, X, 0.004)) {
      near.add(n.sample, n.distance);
      near.add(n.nearest);
      Contact c{.p_WC = n.nearest.p, .n_W = n.nearest.gradient, .distance = n.distance - 0.003, .weight = 0.1};
      c.stiffness = 1000;
      contacts.contact.push_back(c);
      contacts.pair.push_back({});
      contacts.key.push_back(contact_key(0, false, static_cast<std::uint64_t>(n.sample)));
    }
    reduction.reduce(contacts, set);
    for (int k = 0; k < set.count; ++k) {
      const Contact& c = set.contact[static_cast<std::size_t>(k)];
      kept.add(c.p_WC);
      kept.add(c.weight);
    }
  }
  near.print("near", name);
  kept.print("kept", name);
}

}  // namespace

int main() {
  std::printf("%s\n", clones());
  test::Dice dice(5);
  sweep("box", test::box({0.1, 0.08, 0.06}), dice);
  sweep("ball", test::icosphere(0.05, 3), dice);
  sweep("potato", potato(dice), dice);
}
