// Rollouts of a tool on a patch: messages that cannot be, steps that fail, and the heap.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "framework/realtime/allocation_watch.hpp"
#include "nodes/physics/mechanics/local_model.hpp"
#include "nodes/physics/mechanics/local_rollout.hpp"
#include "tests/nodes/physics/mechanics/local_contacts.hpp"
#include "tests/nodes/physics/mechanics/one_body.hpp"
#include "tests/nodes/physics/mechanics/patches.hpp"
#include "tests/support/heap_is_counted.hpp"

BOOST_AUTO_TEST_SUITE(local_patch_test)

using namespace tactor;
using namespace tactor::test;
namespace tt = boost::test_tools;

namespace {

/// Pushes the tool up from the first node of faces, as many contacts as one likes.
class Cushion final : public SoftContactSource {
 public:
  [[nodiscard]] int deformable() const override { return 1; }
  bool find_on(const SoftFaces& faces, std::span<const Vec3> nodes_W, const Pose& X_WT,
               std::vector<SoftContact>& found) override {
    ++asked;
    found.clear();
    if (!enough) return false;
    for (int i = 0; i < contacts && !faces.node.empty(); ++i) {
      SoftContact c;
      c.body = 0;
      c.node = faces.node[static_cast<std::size_t>(i) % faces.node.size()];
      c.share = {0.5, 0.3, 0.2};
      Vec3 p;
      for (std::size_t k = 0; k < 3; ++k) p += c.share[k] * nodes_W[static_cast<std::size_t>(c.node[k])];
      c.contact = floor_at({}, X_WT.p.z - p.z - 0.02, 100, 0.1, 0.3);
      found.push_back(c);
    }
    return true;
  }
  int contacts = 48, asked = 0;
  bool enough = true;
};

SystemModel ball(Integrator integrator = Integrator::implicit_euler) {
  SystemModel model = block(0.05);
  model.integrator = integrator;
  return model;
}

/// Faces that name each of n nodes.
std::vector<PatchFace> faces_over(int n) {
  std::vector<PatchFace> faces;
  for (int i = 0; i < n; ++i) {
    faces.push_back({.node = {i, (i + 1) % n, (i + 2) % n}, .body = 0, .area = 1e-5});
  }
  return faces;
}

LocalModel on_patch(const LocalPatch& patch) {
  LocalModel model;
  model.bodies = one_body({0, 0, 0.018});
  model.device.X_WD.p = {0, 0, 0.015};
  model.coupling = {.k_t = 300, .b_t = 5, .force_max = 8, .torque_max = 1};
  model.patch = patch;
  return model;
}

Stamped<DeviceState> sample(int ms) {
  DeviceState device;
  device.X_WD.p = {0.0001 * ms, 0, 0.015};
  const Time t{ms * 1'000'000LL};
  return {{t, t, 0}, device};
}

/// The parts of a message, to be spoiled.
struct Parts {
  std::vector<PatchNode> nodes;
  std::vector<PatchFace> faces;
  std::vector<PatchMode> modes;
  Eigen::MatrixXd shapes;

  explicit Parts(const LocalPatch& patch)
      : nodes(patch.nodes.begin(), patch.nodes.end()),
        faces(patch.faces.begin(), patch.faces.end()),
        modes(patch.modes.begin(), patch.modes.end()),
        shapes(Eigen::Map<const Eigen::MatrixXd>(patch.shapes.data(), static_cast<Eigen::Index>(3 * nodes.size()),
                                                 static_cast<Eigen::Index>(modes.size()))) {}
  [[nodiscard]] LocalPatch made(PatchPool& pool) const { return pool.patch(nodes, faces, modes, shapes); }
};

}  // namespace

BOOST_AUTO_TEST_CASE(messages_that_cannot_be_are_refused_and_nothing_changes) {
  PatchPool pool;
  Cushion cushion;
  LocalRollout rollout(ball(), nullptr, &cushion);
  const LocalPatch good = RandomPatch(5, 3).make(pool, 1, 0.002, 1, faces_over(6));
  BOOST_REQUIRE(rollout.restart(on_patch(good)));
  for (int ms = 1; ms <= 5; ++ms) BOOST_REQUIRE(rollout.advance(sample(ms)));
  const BodyStates before = rollout.model().bodies;
  const std::vector<Vec3> nodes(rollout.patch()->nodes_W().begin(), rollout.patch()->nodes_W().end());

  const auto refused = [&](const std::string& what, const auto& spoil) {
    Parts parts(good);
    spoil(parts);
    const LocalModel model = on_patch(parts.made(pool));
    BOOST_TEST_CONTEXT(what) {
      BOOST_TEST((rollout.refusal(model) != RefusalReason::none));
      BOOST_TEST(!rollout.restart(model));
      BOOST_TEST(!rollout.learn(model));
      BOOST_TEST((rollout.model().bodies.X_WB[0].p == before.X_WB[0].p));
      BOOST_REQUIRE(rollout.patch() != nullptr);
      BOOST_TEST(
          std::equal(nodes.begin(), nodes.end(), rollout.patch()->nodes_W().begin(), rollout.patch()->nodes_W().end()));
    }
  };
  constexpr double inf = std::numeric_limits<double>::infinity();
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), inf, -inf, 1e300, -1e300}) {
    const std::string which = " " + std::to_string(bad);
    refused("a node at" + which, [&](Parts& p) { p.nodes[2].p_W.y = bad; });
    refused("a node's velocity of" + which, [&](Parts& p) { p.nodes[2].v_W.z = bad; });
    refused("an area of" + which, [&](Parts& p) { p.faces[1].area = bad; });
    refused("a stiffness of" + which, [&](Parts& p) { p.modes[3].stiffness = bad; });
    refused("a damping of" + which, [&](Parts& p) { p.modes[3].damping = bad; });
    refused("a force of" + which, [&](Parts& p) { p.modes[3].force = bad; });
    refused("a displacement of" + which, [&](Parts& p) { p.modes[3].z = bad; });
    refused("a rate of" + which, [&](Parts& p) { p.modes[3].rate = bad; });
    refused("a shape of" + which, [&](Parts& p) { p.shapes(4, 7) = bad; });
  }
  refused("negative stiffness", [](Parts& p) { p.modes[0].stiffness = -1e-9; });
  refused("negative damping", [](Parts& p) { p.modes[0].damping = -1e-9; });
  refused("negative area", [](Parts& p) { p.faces[0].area = -1e-9; });
  for (const std::int32_t node : {-1, 6, 1000, std::numeric_limits<std::int32_t>::max()}) {
    refused("node " + std::to_string(node), [&](Parts& p) { p.faces[4].node[2] = node; });
  }
  for (const std::int32_t body : {-1, 1, 1000}) {
    refused("body " + std::to_string(body), [&](Parts& p) { p.faces[4].body = body; });
  }
  refused("a mode too few in the shapes", [](Parts& p) { p.shapes.conservativeResize(18, 14); });
  refused("a row too few in the shapes", [](Parts& p) { p.shapes.conservativeResize(17, 15); });
  refused("no shapes", [](Parts& p) { p.shapes.resize(0, 0); });
  refused("too many modes", [](Parts& p) {
    p.modes.resize(LocalPatch::most_modes + 1);
    p.shapes = Eigen::MatrixXd::Ones(18, LocalPatch::most_modes + 1);
  });
  for (const bool fixed : {false, true}) {
    refused("too many nodes", [&](Parts& p) {
      const int most = fixed ? LocalPatch::most_nodes : LocalPatch::capacity;
      p.nodes.resize(static_cast<std::size_t>(most + 1));
      for (PatchNode& node : p.nodes) node.fixed = fixed ? 1 : 0;
      p.shapes = Eigen::MatrixXd::Ones(3 * (most + 1), 15);
    });
  }
  refused("too many faces", [](Parts& p) { p.faces.resize(LocalPatch::most_faces + 1, p.faces[0]); });
  // A tool without mass is nothing that the patch is stepped with.
  LocalModel massless = on_patch(good);
  massless.coupling.massless = 1;
  BOOST_TEST(!rollout.restart(massless));
  // A patch where nothing deforms.
  LocalRollout rigid(ball());
  BOOST_TEST(!rigid.restart(on_patch(good)));
  BOOST_TEST(rigid.restart(on_patch({})));
}

BOOST_AUTO_TEST_CASE(nodes_that_no_force_moves_make_a_step_that_failed) {
  PatchPool pool;
  Cushion cushion;
  LocalRollout rollout(ball(), nullptr, &cushion);
  Parts parts(RandomPatch(4, 3).make(pool, 1, 0.002, 0, faces_over(4)));
  parts.shapes.setZero();
  BOOST_REQUIRE(rollout.restart(on_patch(parts.made(pool))));
  for (int ms = 1; ms <= 5; ++ms) {
    BOOST_TEST(!rollout.advance(sample(ms)));
    BOOST_TEST(is_finite(rollout.model().bodies.X_WB[0].p));
    BOOST_TEST(norm(rollout.state().contact_T_W.force) == 0.0);
  }
}

BOOST_AUTO_TEST_CASE(where_contacts_take_too_much_work_the_step_has_failed_and_the_tool_stays) {
  PatchPool pool;
  Cushion cushion;
  LocalRollout rollout(ball(), nullptr, &cushion);
  BOOST_REQUIRE(rollout.restart(on_patch(RandomPatch(4, 3).make(pool, 1, 0.002, 0, faces_over(4)))));
  BOOST_TEST(rollout.advance(sample(1)));
  cushion.enough = false;
  const Vec3 p = rollout.model().bodies.X_WB[0].p;
  BOOST_TEST(!rollout.advance(sample(2)));
  BOOST_TEST((rollout.model().bodies.X_WB[0].p == p));
  cushion.enough = true;
  BOOST_TEST(rollout.advance(sample(3)));
}

BOOST_AUTO_TEST_CASE(the_tool_and_the_patch_push_each_other_to_where_springs_balance) {
  // The handle's spring and the patch's stiffness in series with the contacts, after the damping has done its part.
  PatchPool pool;
  for (const Integrator integrator : {Integrator::implicit_euler, Integrator::midpoint}) {
    Cushion cushion;
    cushion.contacts = 3;
    LocalRollout rollout(ball(integrator), nullptr, &cushion);
    RandomPatch random(3, 5);
    random.f.setZero();
    random.u.setZero();
    random.places.setZero();
    LocalModel model = on_patch(random.make(pool, 40, 0.02, 0, faces_over(3)));
    model.contacts.count = 0;
    for (std::size_t k = 0; k < 3; ++k) model.bodies.V_WB[0] = {};
    BOOST_REQUIRE(rollout.restart(model));
    for (int ms = 1; ms <= 4000; ++ms) {
      Stamped<DeviceState> still = sample(ms);
      still.value.X_WD.p = {0, 0, 0.015};
      BOOST_REQUIRE(rollout.advance(still));
    }
    // Unknown: z of the tool and of the three nodes' places; friction holds what is across, so it is left to the test
    // of forces: what the handle pulls with, the contacts push, and the patch's stiffness carries.
    const double z = rollout.model().bodies.X_WB[0].p.z;
    const double weight = 0.05 * 9.81, pulled = 300 * (0.015 - z) - weight;
    BOOST_TEST(rollout.state().contact_T_W.force.z == -pulled, tt::tolerance(1e-3));
    Eigen::VectorXd x(9);
    for (int i = 0; i < 3; ++i) {
      const Vec3 p = rollout.patch()->nodes_W()[static_cast<std::size_t>(i)];
      x.segment<3>(3 * i) = Eigen::Vector3d(p.x, p.y, p.z);
    }
    const Eigen::VectorXd carried = random.K * x;
    BOOST_TEST(carried[2] + carried[5] + carried[8] == pulled, tt::tolerance(1e-2));
  }
}

BOOST_AUTO_TEST_CASE(a_rollout_on_a_patch_of_any_size_allocates_nothing,
                     *boost::unit_test::precondition(heap_is_counted)) {
  PatchPool pool;
  for (const Integrator integrator : {Integrator::implicit_euler, Integrator::midpoint}) {
    for (const bool rotates : {false, true}) {
      for (const int nodes : {3, 12, 24, 40}) {
        Cushion cushion;
        SystemModel system = ball(integrator);
        system.body[0].rotates = rotates;
        LocalRollout rollout(system, nullptr, &cushion);
        const LocalModel model = on_patch(RandomPatch(nodes, nodes).make(pool, 1, 0.002, 0, faces_over(nodes)));
        const std::int64_t before = thread_heap_calls();
        const bool taken = rollout.restart(model);
        int failed = 0;
        for (int ms = 1; ms <= 20; ++ms) {
          cushion.contacts = ms % 5 == 0 ? 0 : 48;
          failed += rollout.advance(sample(ms)) ? 0 : 1;
        }
        const std::int64_t calls = thread_heap_calls() - before;
        BOOST_TEST(taken);
        BOOST_TEST(calls == 0);
        BOOST_TEST(failed == 0);
        BOOST_TEST(cushion.asked == 20);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(a_patch_is_known_around_the_tool_of_its_result) {
  PatchPool pool;
  Cushion cushion;
  LocalRollout rollout(ball(), nullptr, &cushion);
  LocalModel model = on_patch(RandomPatch(5, 3).make(pool, 1, 0.002, 1, faces_over(6)));
  // The result is older than the model: its tool was 4 mm beside.
  model.p_WT_result = {-0.004, 0, 0.018};
  BOOST_REQUIRE(rollout.restart(model));
  BOOST_TEST(rollout.distance_from_known() == 0.004, tt::tolerance(1e-12));
  for (int ms = 1; ms <= 50; ++ms) BOOST_REQUIRE(rollout.advance(sample(ms)));
  const Vec3 way = rollout.state().X_WT.p - model.p_WT_result;
  BOOST_TEST(norm(way) > 0.005);
  BOOST_TEST(rollout.distance_from_known() == norm(way), tt::tolerance(1e-12));
  // Where the tool is far from what deforms, results have no patch.
  model.patch = {};
  BOOST_REQUIRE(rollout.restart(model));
  BOOST_TEST(rollout.distance_from_known() == 0.0);
}

BOOST_AUTO_TEST_SUITE_END()
