// Collision and dynamics together: the hole holds the peg where its clearance ends.
#include <boost/test/unit_test.hpp>

#include "nodes/collision/sdf.hpp"
#include "nodes/dynamics/rigid.hpp"
#include "tests/support/nodes.hpp"

BOOST_AUTO_TEST_SUITE(peg_in_hole_test)

using namespace tactor;
namespace tt = boost::test_tools;

namespace {

class Rig {
 public:
  explicit Rig(double query_period_ms) : scene_(peg_in_plate()), period_ms_(query_period_ms) {
    SdfCollision::Params c = test::default_params<SdfCollision>();
    c.spacing = 0.005;
    c.margin = 0.001;
    collision_ = std::make_unique<SdfCollision>(c, test::context_for(scene_));
    dynamics_ = std::make_unique<RigidDynamics>(test::default_params<RigidDynamics>(), test::context_for(scene_));
    collision_->device.configure({});
    collision_->state.configure({});
    dynamics_->contacts.configure({});
    dynamics_->device.configure({QueuePolicy::drop_oldest, 4096});
    dynamics_->coupling.configure({});
    dynamics_->coupling.push({}, &coupling);
  }

  /// Moves the handle steadily from its pose to p and turn in half a second, waits as long, and returns the end.
  PhysicsState move_to(const Vec3& p, const Vec3& turn) {
    PhysicsState last;
    const Vec3 p0 = p_, turn0 = turn_;
    for (int i = 1; i <= 1000; ++i) {
      const double s = std::min(1.0, i / 500.0);
      p_ = p0 + s * (p - p0);
      turn_ = turn0 + s * (turn - turn0);
      DeviceState d;
      d.X_WD = {p_, from_rotation_vector(turn_)};
      if (i < 500) d.V_WD = {2 * (p - p0), {}};
      now_ = now_ + Duration{1'000'000};
      dynamics_->device.push({now_, now_, 0}, &d);
      if (i % static_cast<int>(period_ms_) == 0) last = step();
      largest = std::max(largest, norm(last.X_WT.p));
    }
    return last;
  }

  CouplingParameters coupling{.k_t = 500, .b_t = 14, .k_r = 1, .b_r = 0.01, .force_max = 8, .torque_max = 0.3};
  double largest = 0;

 private:
  static Scene peg_in_plate() {
    Scene scene;
    scene.gravity_W = {};
    for (const char* name : {"plate", "peg"}) {
      Body body;
      body.name = name;
      body.shape = MeshShape{std::string(TACTOR_BINARY_DIR) + "/meshes/" + name + ".off"};
      body.material = {.stiffness = 2e5, .damping = 20, .friction = 0.2, .patch_area = 1e-4};
      scene.bodies.push_back(body);
    }
    scene.bodies[1].motion = Motion::rigid;
    return scene;
  }

  PhysicsState step() {
    StepContext context(now_);
    collision_->step(context);
    const ContactSet set = test::sent(collision_->contacts);
    collision_->contacts.clear_pending();
    dynamics_->contacts.push({now_, now_, 0}, &set);
    dynamics_->step(context);
    BOOST_REQUIRE(dynamics_->state.pending() == 1U);
    const PhysicsState state = test::sent(dynamics_->state);
    dynamics_->state.clear_pending();
    collision_->state.push({now_, now_, 0}, &state);
    return state;
  }

  Scene scene_;
  double period_ms_;
  std::unique_ptr<SdfCollision> collision_;
  std::unique_ptr<RigidDynamics> dynamics_;
  Vec3 p_, turn_;
  Time now_;
};

}  // namespace

BOOST_AUTO_TEST_CASE(a_peg_pushed_aside_is_held_at_the_end_of_its_clearance) {
  for (const double period_ms : {2.0, 10.0}) {
    Rig rig(period_ms);
    const PhysicsState s = rig.move_to({0.004, 0, 0}, {});
    BOOST_TEST(s.X_WT.p.x > 0.00045);
    BOOST_TEST(s.X_WT.p.x < 0.0009);
    BOOST_TEST(std::abs(s.X_WT.p.y) < 0.0003);
    BOOST_TEST(s.contact_T_W.force.x == -500 * (0.004 - s.X_WT.p.x), tt::tolerance(0.02));
    BOOST_TEST(rig.largest < 0.002);
  }
}

BOOST_AUTO_TEST_CASE(a_peg_turned_in_the_hole_jams_after_a_few_degrees) {
  Rig rig(5);
  const PhysicsState s = rig.move_to({0, 0, 0}, {0, 0.12, 0});
  const double angle = to_rotation_vector(s.X_WT.R).y;
  // Geometry: a clearance of 0.5 mm to each side over a depth of 20 mm lets it turn by about 0.05 rad.
  BOOST_TEST(angle > 0.035);
  BOOST_TEST(angle < 0.07);
  BOOST_TEST(s.contact_T_W.torque.y == -(0.12 - angle), tt::tolerance(0.03));
}

BOOST_AUTO_TEST_CASE(a_peg_slides_along_the_hole_without_force) {
  Rig rig(5);
  const PhysicsState s = rig.move_to({0, 0, 0.008}, {});
  BOOST_TEST(s.contacts == 0);
  BOOST_TEST(s.X_WT.p.z == 0.008, tt::tolerance(1e-3));
}

BOOST_AUTO_TEST_SUITE_END()
