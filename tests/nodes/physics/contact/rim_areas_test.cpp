// Edges and corners push by the area that lies on the other body, whatever the spacing: against closed forms.
#include <boost/test/unit_test.hpp>

#include <memory>

#include "nodes/collision/primitive.hpp"
#include "nodes/collision/sdf.hpp"
#include "nodes/physics/contact/body_pair.hpp"
#include "nodes/physics/contact/local_contacts.hpp"
#include "nodes/physics/geometry/mesh_distance.hpp"
#include "nodes/physics/mesh/refine.hpp"
#include "tests/nodes/physics/contact/scenes.hpp"

BOOST_AUTO_TEST_SUITE(rim_areas_test)

using namespace tactor;
namespace tt = boost::test_tools;

namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr double patch = 1e-4;  // m^2
constexpr double k = 2000;      // N/m a patch, of two alike in series
const Vec3 block_size{0.04, 0.03, 0.02};

SdfCollision::Params params_of(double spacing) {
  auto params = test::default_params<SdfCollision>();
  params.resolution = 24;
  params.spacing = spacing;
  return params;
}

std::unique_ptr<SdfCollision> made(Scene scene, double spacing = 0) {
  for (Body& b : scene.bodies) b.material = {.stiffness = 2 * k, .damping = 2, .friction = 0.3, .patch_area = patch};
  return std::make_unique<SdfCollision>(params_of(spacing), test::context_for(scene));
}

Scene on_floor(const Body& tool) {
  Scene scene;
  scene.bodies = {test::shaped("floor", PlaneShape{}), tool};
  return scene;
}

/// How the body lies where its face along `axis`, on the side `side`, is down.
Quat lying_on(int axis, int side) {
  if (axis == 0) return from_rotation_vector({0, side * std::numbers::pi / 2, 0});
  if (axis == 1) return from_rotation_vector({-side * std::numbers::pi / 2, 0, 0});
  return from_rotation_vector({side > 0 ? std::numbers::pi : 0, 0, 0});
}

double face_area(const Vec3& size, int axis) {
  return size[(axis + 1) % 3] * size[(axis + 2) % 3];
}

/// How deep the tool rests under `weight` (N) on what is below height 0, its lowest face `half` below its middle.
double resting_depth(SdfCollision& node, const Vec3& above, const Quat& R, double half, double weight) {
  double depth = 1e-4;
  for (int i = 0; i < 8; ++i) {
    ContactSet set;
    node.query({{above.x, above.y, above.z + half - depth}, R}, set);
    const double force = test::spring_wrench(set).force.z;
    BOOST_REQUIRE(force > 0);
    depth *= weight / force;
  }
  return depth;
}

/// A pair of bodies without a node about it, and all that it finds.
struct Alone {
  Alone(const Body& a, const Body& b, double margin, double spacing = 0)
      : options{.resolution = 24, .band = 0.002},
        body_a(a, spacing, true, margin, cell_distances(options, nullptr), nullptr),
        body_b(b, spacing, true, margin, cell_distances(options, nullptr), nullptr),
        pair(body_a, body_b, {0, ContactPair::fixed}, 0, margin) {}
  const FoundContacts& find(const Pose& X_WA, const Pose& X_WB = {}) {
    found.clear();
    pair.find(X_WA, X_WB, found);
    return found;
  }
  CellOptions options;
  ContactBody body_a, body_b;
  BodyPair pair;
  FoundContacts found;
};

Body rigid(const std::string& name, const Shape& shape) {
  Body body = test::shaped(name, shape, Motion::rigid);
  body.material.patch_area = patch;
  return body;
}
Body fixed(const std::string& name, const Shape& shape) {
  Body body = test::shaped(name, shape);
  body.material.patch_area = patch;
  return body;
}

/// A pyramid of `sides` sides with its tip at the origin, pointing down.
TriangleMesh needle(int sides, double radius, double length) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {0, 0, length}};
  for (int i = 0; i < sides; ++i) {
    const double turn = 2 * std::numbers::pi * i / sides;
    mesh.vertices.push_back({radius * std::cos(turn), radius * std::sin(turn), length});
    const int a = 2 + i, b = 2 + (i + 1) % sides;
    mesh.faces.push_back({0, b, a});
    mesh.faces.push_back({1, a, b});
  }
  return mesh;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_block_rests_on_each_face_as_deep_as_the_area_of_the_face_asks_at_every_spacing) {
  for (const bool is_mesh : {false, true}) {
    const Body tool = is_mesh ? test::mesh_body("block", test::box(block_size), Motion::rigid)
                              : test::shaped("block", BoxShape{block_size}, Motion::rigid);
    for (const double spacing : {0.0, 0.01, 0.004, 0.002, 0.001}) {
      const auto node = made(on_floor(tool), spacing);
      for (int axis = 0; axis < 3; ++axis) {
        for (const int side : {-1, 1}) {
          BOOST_TEST_CONTEXT((is_mesh ? "mesh" : "box") << ", spacing " << spacing << ", axis " << axis << side) {
            const double weight = 9.81 * 0.15, asked = weight / (k * face_area(block_size, axis) / patch);
            const double depth =
                resting_depth(*node, {0.1, 0.2, 0}, lying_on(axis, side), block_size[axis] / 2, weight);
            BOOST_TEST(depth == asked, tt::tolerance(0.002));
          }
        }
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(a_block_on_a_table_without_samples_below_it_rests_as_on_a_plane_and_so_does_a_slab_on_a_pedestal) {
  // Samples of the large mesh are 70 mm apart, and none is where the two lie on each other.
  const TriangleMesh large = test::box({0.8, 0.8, 0.1});
  const double weight = 2, asked = weight / (k * face_area(block_size, 2) / patch);
  Scene table;
  table.bodies = {test::mesh_body("table", large), test::shaped("block", BoxShape{block_size}, Motion::rigid)};
  table.bodies[0].X_WB.p = {0, 0, -0.05};
  BOOST_TEST(resting_depth(*made(table), {0.05, 0, 0}, {}, block_size.z / 2, weight) == asked, tt::tolerance(0.002));
  // The samples that touch are those of the second body of the pair.
  Scene pedestal;
  pedestal.bodies = {test::mesh_body("slab", large, Motion::rigid), test::shaped("pedestal", BoxShape{block_size})};
  pedestal.bodies[1].X_WB.p = {0.05, 0, -block_size.z / 2};
  BOOST_TEST(resting_depth(*made(pedestal), {}, {}, 0.05, weight) == asked, tt::tolerance(0.002));
  // A block that moves, of its own frame and tilted with all the rest, is the second as well.
  const Pose X_VW{{0.3, -0.2, 0.15}, from_rotation_vector({0.7, -1.1, 0.4})};
  Scene both = pedestal;
  both.bodies[1].motion = Motion::rigid;
  both.tool_name = "slab";
  const auto node = made(both);
  BodyStates at;
  at.count = 2;
  at.X_WB[0] = X_VW * Pose{{0, 0, 0.05 - asked}, {}};
  at.X_WB[1] = X_VW * both.bodies[1].X_WB;
  ContactSet set;
  node->query(at, set);
  BOOST_TEST(norm(test::spring_wrench(set).force - weight * rotate(X_VW.R, {0, 0, 1})) < 0.005 * weight);
}

BOOST_AUTO_TEST_CASE(a_block_on_a_larger_box_rests_as_deep_as_the_area_asks_wherever_it_lies) {
  // Both are sampled. The lattice of the table has more or fewer points below the block as that lies here or there.
  const Vec3 size{0.024, 0.016, 0.012};
  Scene scene;
  scene.bodies = {test::shaped("table", BoxShape{{0.3, 0.3, 0.02}}),
                  test::shaped("block", BoxShape{size}, Motion::rigid)};
  scene.bodies[0].X_WB.p = {0, 0, -0.01};
  const double asked = 5e-5, weight = k * size.x * size.y / patch * asked;
  for (const double spacing : {0.0, 0.003, 0.0015, 0.001}) {
    BOOST_TEST_CONTEXT("spacing " << spacing) {
      const auto node = made(scene, spacing);
      double sum = 0;
      const int places = 100;
      for (int i = 0; i < places; ++i) {
        // The first is where the lattice's points lie below the rim.
        const double depth = resting_depth(*node, {0.35e-3 * i, 0.137e-3 * i, 0}, {}, size.z / 2, weight);
        BOOST_TEST(depth == asked, tt::tolerance(0.02));
        sum += depth;
      }
      BOOST_TEST(sum / places == asked, tt::tolerance(0.01));
    }
  }
}

BOOST_AUTO_TEST_CASE(the_shares_lean_to_the_side_of_the_rim_where_both_push_alike) {
  const double margin = 1e-3;
  const BoxShape small{{0.02, 0.02, 0.02}}, large{{0.1, 0.1, 0.02}};
  Alone on_table(rigid("block", small), fixed("table", large), margin);
  on_table.find({{0.013, 0.007, 0.02 - 1e-4}, {}});
  BOOST_TEST(on_table.pair.shares().a > 0.95);
  Alone on_block(rigid("slab", large), fixed("block", small), margin, 0.0025);
  on_block.find({{0.013, 0.007, 0.02 - 1e-4}, {}});
  BOOST_TEST(on_block.pair.shares().b > 0.95);
  // Of alike blocks each has half of the rim.
  Alone alike(rigid("one", small), fixed("two", small), margin);
  alike.find({{0, 0, 0.02 - 1e-4}, {}});
  BOOST_TEST(alike.pair.shares().a == 0.5, tt::tolerance(1e-9));
  // What bulges into a face beside its rim is felt by its own samples, as if there were no rim.
  Alone bulge(rigid("block", small), test::mesh_body("ball", test::icosphere(0.003, 3)), margin);
  bulge.find({{0.0077, 0, 0.0128}, {}});
  BOOST_TEST(bulge.pair.shares().a < 0.01);
}

BOOST_AUTO_TEST_CASE(the_finer_side_counts_unless_the_other_one_is_deeper) {
  const double margin = 1e-3, depth = 3e-4;
  // Above a sample of the wall, which stands for as much as the whole block.
  const Body wall = test::mesh_body("wall", test::box({0.16, 0.16, 0.02})),
             block = rigid("block", BoxShape{{0.02, 0.02, 0.02}});
  for (const double x : {0.0, 0.004, 0.009}) {
    Alone alone(block, wall, margin);
    alone.find({{x, 0.001, 0.02 - depth}, {}});
    double pushed = 0;
    for (const Contact& c : alone.found.contact) pushed += c.weight * std::max(0.0, -c.distance);
    BOOST_TEST(pushed == 4e-4 / patch * depth, tt::tolerance(0.001));
  }
  // The tip of a blunt pyramid of few samples stands between those of a fine face, none of which is as deep at first.
  TriangleMesh pyramid{
      {{0.02, 0.02, 0.004}, {-0.02, 0.02, 0.004}, {-0.02, -0.02, 0.004}, {0.02, -0.02, 0.004}, {0, 0, 0}},
      {{0, 1, 2}, {0, 2, 3}, {1, 0, 4}, {2, 1, 4}, {3, 2, 4}, {0, 3, 4}}};
  Alone spike(test::mesh_body("spike", pyramid, Motion::rigid), fixed("plate", BoxShape{{0.01, 0.01, 0.01}}), margin);
  const auto share = [&spike](double deep) {
    spike.find({{0.000625, 0.000625, 0.005 - deep + 0.003}, {}});
    return spike.pair.shares().a;
  };
  // In the middle of four samples that are 1.25 mm apart, whose distance from its faces is above zero.
  const double deep = 6e-4;
  BOOST_TEST(share(1e-4) > 0.2);
  BOOST_TEST(share(deep) < 0.01);
  double pushed = 0;
  for (const Contact& c : spike.found.contact) pushed += c.weight * std::max(0.0, -c.distance);
  // A fifth as steep as a face is long: the part below the plate is a pyramid of so much.
  BOOST_TEST(pushed == std::pow(2 * deep / 0.2, 2) * deep / 3 / patch, tt::tolerance(0.3));
}

BOOST_AUTO_TEST_CASE(forces_change_little_by_little_while_a_block_rocks_and_slides_over_a_table) {
  Alone alone(rigid("block", BoxShape{{0.02, 0.016, 0.012}}), fixed("table", BoxShape{{0.1, 0.1, 0.02}}), 1e-3, 0.0025);
  double largest = 0, most = 0;
  Vec3 last;
  for (int i = 0; i <= 20'000; ++i) {
    const double u = i / 20'000.0;
    const Vec3 turn{0.06 * std::sin(40 * u), 0.05 * std::sin(31 * u), 0.5 * u};
    const FoundContacts& found =
        alone.find({{0.035 * u, 0.002, 0.0159 + 2e-4 * std::sin(23 * u)}, from_rotation_vector(turn)});
    Vec3 now;
    for (const Contact& c : found.contact) now += c.weight * c.stiffness * std::max(0.0, -c.distance) * c.n_W;
    if (i > 0) largest = std::max(largest, norm(now - last));
    most = std::max(most, norm(now));
    last = now;
  }
  BOOST_TEST(most > 0.5);
  // A sample of the table that comes nearer to a side of the block than to its bottom is pushed elsewhere at once.
  BOOST_TEST(largest < 0.015 * most);
}

BOOST_AUTO_TEST_CASE(a_thin_plate_on_its_narrow_side_is_pushed_by_that_side_alone) {
  const Vec3 size{0.04, 0.04, 0.0005};
  for (const bool is_mesh : {false, true}) {
    const Body tool = is_mesh ? test::mesh_body("plate", test::box(size), Motion::rigid)
                              : test::shaped("plate", BoxShape{size}, Motion::rigid);
    const double asked = 1e-4, weight = k * face_area(size, 0) / patch * asked;
    // Ten times as much as lies on the floor belongs to the same samples.
    BOOST_TEST(resting_depth(*made(on_floor(tool)), {}, lying_on(0, 1), size.x / 2, weight) == asked,
               tt::tolerance(0.02));
  }
}

BOOST_AUTO_TEST_CASE(on_an_edge_both_faces_count) {
  const BoxShape box{{0.04, 0.02, 0.02}};
  const ContactSamples samples = shape_samples(box, 0);
  Alone alone(rigid("block", box), fixed("floor", PlaneShape{}), 1e-4);
  // About each of the four edges along x.
  for (int quarter = 0; quarter < 4; ++quarter) {
    const Quat R = from_rotation_vector({(45 + 90 * quarter) * degree, 0, 0});
    const FoundContacts& found = alone.find({{0, 0, std::sqrt(2.0) * 0.01 - 1e-4}, R});
    BOOST_TEST(found.contact.size() == 9U);
    for (std::size_t i = 0; i < found.contact.size(); ++i) {
      const SurfaceSample& s = samples.points[sample_of(found.key[i])];
      const bool is_corner = std::abs(s.p.x) > 0.0199;
      // At a corner the end faces sideways.
      const double third = is_corner ? 0.00125 * 0.00125 * 4 : 0;
      BOOST_TEST(found.contact[i].weight == (s.area - third * (1 - 0.001 / 0.501)) / patch, tt::tolerance(1e-9));
    }
  }
}

BOOST_AUTO_TEST_CASE(weights_change_continuously_while_a_block_turns_all_the_way_round) {
  Alone alone(rigid("block", BoxShape{block_size}), fixed("floor", PlaneShape{}), 0.1);
  const ContactSamples samples = shape_samples(BoxShape{block_size}, 0);
  const auto largest_change = [&](const Vec3& axis, double step) {
    std::vector<double> last(samples.points.size());
    double largest = 0, most = 0;
    for (int i = 0; i <= static_cast<int>(360 / step); ++i) {
      const Pose X{{0, 0, 0.03}, from_rotation_vector(i * step * degree / norm(axis) * axis)};
      const FoundContacts& found = alone.find(X);
      // A sample that faces away from the floor makes no contact.
      std::vector<double> weight(samples.points.size());
      for (std::size_t c = 0; c < found.contact.size(); ++c) weight[sample_of(found.key[c])] = found.contact[c].weight;
      for (std::size_t s = 0; s < weight.size(); ++s) {
        const double now = weight[s] / (samples.points[s].area / patch);
        most = std::max(most, now);
        if (i > 0) largest = std::max(largest, std::abs(now - last[s]));
        last[s] = now;
      }
    }
    BOOST_TEST(most > 0.99);
    BOOST_TEST(most < 1 + 1e-12);
    return largest;
  };
  // Of all the area at a sample, by tenths of a degree.
  BOOST_TEST(largest_change({1, 0, 0}, 0.1) < 0.03);
  BOOST_TEST(largest_change({0, 1, 0}, 0.1) < 0.03);
  BOOST_TEST(largest_change({1, 2, 3}, 0.1) < 0.11);
  // Nothing jumps: half the step, half the change.
  BOOST_TEST(largest_change({1, 2, 3}, 0.05) < 0.055);
}

BOOST_AUTO_TEST_CASE(the_tip_of_a_needle_keeps_its_weight) {
  for (const int sides : {3, 4, 8, 24}) {
    const TriangleMesh mesh = needle(sides, 0.002, 0.04);
    const SurfaceSamples samples = vertex_samples(refine(mesh, 0.04 / 8).mesh);
    for (const bool first : {true, false}) {
      // Against a plane, and from below against the face of a block that moves.
      Body tool = first ? test::mesh_body("needle", mesh, Motion::rigid) : rigid("block", BoxShape{{0.02, 0.02, 0.02}});
      Body other = first ? fixed("floor", PlaneShape{}) : test::mesh_body("needle", mesh);
      tool.material.patch_area = other.material.patch_area = patch;
      Alone alone(tool, other, 1e-4);
      const Pose up{{0.0013, 0.0007, 0}, from_rotation_vector({std::numbers::pi, 0, 0})};
      const FoundContacts& found = first ? alone.find({{0, 0, -5e-5}, {}}) : alone.find({{0, 0, 0.01 - 5e-5}, {}}, up);
      double weight = 0;
      int tips = 0;
      for (std::size_t i = 0; i < found.contact.size(); ++i) {
        if (is_from_b(found.key[i]) == first || sample_of(found.key[i]) != 0) continue;
        weight = found.contact[i].weight;
        ++tips;
      }
      BOOST_REQUIRE(tips == 1);
      const double share = first ? alone.pair.shares().a : alone.pair.shares().b;
      BOOST_TEST(share > 0);
      BOOST_TEST(weight == share * samples.points[0].area / patch, tt::tolerance(1e-6));
    }
  }
}

BOOST_AUTO_TEST_CASE(samples_of_a_round_mesh_weigh_their_area_as_seen_from_the_floor) {
  const TriangleMesh mesh = test::icosphere(0.05, 4);
  const SurfaceSamples samples = vertex_samples(refine(mesh, 0.1 / 8).mesh);
  Body ball = test::mesh_body("ball", mesh, Motion::rigid);
  ball.material.patch_area = patch;
  Alone alone(ball, fixed("floor", PlaneShape{}), 0.002);
  const Quat R = from_rotation_vector({1, 2, 3});
  const FoundContacts& found = alone.find({{0, 0, 0.049}, R});
  BOOST_TEST(found.contact.size() > 20U);
  for (std::size_t i = 0; i < found.contact.size(); ++i) {
    const SurfaceSample& s = samples.points[sample_of(found.key[i])];
    // A ball's normal is the way from its middle; that of the triangles about a vertex is a little off.
    const double down = -rotate(R, s.p).z / norm(s.p);
    BOOST_TEST(down > 0.94);
    BOOST_TEST(found.contact[i].weight == down * s.area / patch, tt::tolerance(0.005));
  }
}

BOOST_AUTO_TEST_CASE(a_contact_looked_up_by_its_key_weighs_what_a_query_gives_it) {
  Alone alone(rigid("block", BoxShape{{0.02, 0.016, 0.012}}), fixed("table", BoxShape{{0.1, 0.1, 0.02}}), 1e-3, 0.004);
  const Pose X_WB{{0, 0.01, -0.01}, from_rotation_vector({0.03, 0, 0.2})};
  std::size_t compared = 0;
  for (int i = 0; i < 40; ++i) {
    const Pose X_WA{{0.04 + 1e-3 * i, 0.003, 0.0058}, from_rotation_vector({0.02 * i, 0.01 * i, 0.3})};
    const FoundContacts& found = alone.find(X_WA, X_WB);
    for (std::size_t c = 0; c < found.contact.size(); ++c, ++compared) {
      const Contact again = alone.pair.at(found.key[c], X_WA, X_WB, alone.pair.shares());
      BOOST_TEST(again.weight == found.contact[c].weight, tt::tolerance(1e-9));
    }
  }
  BOOST_TEST(compared > 200U);
}

BOOST_AUTO_TEST_CASE(ahead_a_rim_weighs_at_each_anchor_what_it_does_there) {
  // Rolling over its edge by 0.15 rad from anchor to anchor.
  const BoxShape box{{0.02, 0.02, 0.02}};
  const Scene scene = on_floor(test::shaped("block", box, Motion::rigid));
  auto params = params_of(0.005);
  params.local_contacts = LocalContacts::capacity;
  SdfCollision node(params, test::context_for(scene)), fresh(params, test::context_for(scene));
  BodyStates bodies;
  bodies.count = 1;
  bodies.X_WB[0] = {{0, 0, 0.0102}, from_rotation_vector({0.25, 0, 0})};
  bodies.V_WB[0] = {{0, 0, 0.02}, {10, 0, 0}};
  LocalContacts local;
  node.query_ahead(bodies, 0, local);
  BOOST_REQUIRE(local.anchors == 3);
  BOOST_REQUIRE(local.count > 0);
  int compared = 0;
  double changed = 0;
  for (std::size_t j = 0; j < 3; ++j) {
    ContactSet set;
    fresh.query(local.X_WB[j][0], set);
    for (const Contact& c : test::contacts_of(set)) {
      for (std::size_t i = 0; i < static_cast<std::size_t>(local.count); ++i) {
        if (norm(local.contact[i][j].p_TC - c.p_TC) > 1e-9) continue;
        BOOST_TEST(local.contact[i][j].weight == c.weight, tt::tolerance(1e-9));
        changed = std::max(changed, std::abs(local.contact[i][2].weight / local.contact[i][0].weight - 1));
        ++compared;
      }
    }
  }
  BOOST_TEST(compared > 10);
  BOOST_TEST(changed > 0.1);
}

BOOST_AUTO_TEST_SUITE_END()
