// The law that is told of MuJoCo's contacts against MuJoCo's forces, and against what docs/explanation/physics.md says.
#include <boost/test/unit_test.hpp>

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "nodes/physics/mujoco/contact_report.hpp"
#include "tests/nodes/physics/mechanics/one_body.hpp"
#include "tests/support/dice.hpp"

BOOST_AUTO_TEST_SUITE(mujoco_contact_test)

using namespace tactor;
using namespace tactor::test;
namespace tt = boost::test_tools;

namespace {

constexpr double radius = 0.01;  // m

/// A ball without rotation on a plane.
struct Ball {
  double mass = 0.05, friction = 0.3, impratio = 1;
  double solref[2] = {0.02, 1};
  double solimp[5] = {0.9, 0.9, 0.001, 0.5, 2};
  double step = 1e-5;
  double gravity = 9.81;
  int condim = 3;
  const char* cone = "elliptic";
  double margin = 0, gap = 0;  // m
};

class Mujoco {
 public:
  explicit Mujoco(const Ball& ball) {
    std::ostringstream surface, xml;
    surface.precision(17), xml.precision(17);
    surface << " condim='" << ball.condim << "' margin='" << ball.margin << "' gap='" << ball.gap << "' friction='"
            << ball.friction << " 0.005 0.0001' solref='" << ball.solref[0] << ' ' << ball.solref[1] << "' solimp='";
    for (const double number : ball.solimp) surface << number << ' ';
    surface << "'/>";
    xml << "<mujoco><option gravity='0 0 " << -ball.gravity << "' cone='" << ball.cone
        << "' solver='Newton' iterations='200' "
        << "tolerance='1e-15' timestep='" << ball.step << "' impratio='" << ball.impratio
        << "'/><worldbody><geom type='plane' size='0 0 1'" << surface.str() << "<body>";
    for (const char* axis : {"1 0 0", "0 1 0", "0 0 1"}) xml << "<joint type='slide' axis='" << axis << "'/>";
    xml << "<inertial pos='0 0 0' mass='" << ball.mass << "' diaginertia='1e-5 1e-5 1e-5'/><geom type='sphere' size='"
        << radius << "'" << surface.str() << "</body></worldbody></mujoco>";
    const std::string text = xml.str();
    const auto vfs = std::make_unique<mjVFS>();
    mj_defaultVFS(vfs.get());
    mj_makeEmptyFileVFS(vfs.get(), "ball.xml", static_cast<int>(text.size()));
    std::copy(text.begin(), text.end(), static_cast<char*>(vfs->filedata[0]));
    char error[1000] = "";
    m.reset(mj_loadXML("ball.xml", vfs.get(), error, sizeof error));
    mj_deleteVFS(vfs.get());
    BOOST_REQUIRE_MESSAGE(m, error);
    d.reset(mj_makeData(m.get()));
  }
  /// N, in the contact's frame: normal first; zero without contact.
  [[nodiscard]] Vec3 force() const {
    if (d->ncon == 0) return {};
    mjtNum f[6];
    mj_contactForce(m.get(), d.get(), 0, f);
    return {f[0], f[1], f[2]};
  }
  /// The contacts as physics.mujoco tells them, with the ball as the tool.
  [[nodiscard]] ContactSet told() const {
    const std::vector<char> of_tool{0, 1};
    const int tool = 1;
    ContactSet found;
    list_contacts(*m, *d, of_tool.data(), &tool, 1, found);
    return found;
  }
  std::unique_ptr<mjModel, void (*)(mjModel*)> m{nullptr, mj_deleteModel};
  std::unique_ptr<mjData, void (*)(mjData*)> d{nullptr, mj_deleteData};
};

/// What is told of the ball's contact just below the surface, at the contact's point.
Contact told_law(const Ball& ball) {
  const Mujoco mujoco(ball);
  mujoco.d->qpos[2] = radius - 1e-9;
  mj_forward(mujoco.m.get(), mujoco.d.get());
  const ContactSet found = mujoco.told();
  BOOST_REQUIRE(found.count == 1);
  Contact law = found.contact[0];
  law.p_TC = law.p_WC = {};
  law.distance = 0;
  return law;
}

/// The law of a contact at that distance below the margin, by the rules of docs/explanation/physics.md.
Contact law_of(const Ball& ball, double invweight, double distance) {
  const double *r = ball.solref, *i = ball.solimp;
  const double x = std::min(1.0, std::abs(distance) / i[2]), middle = i[3], power = i[4];
  double y = x;
  if (power != 1) {
    y = x <= middle ? std::pow(x, power) / std::pow(middle, power - 1)
                    : 1 - std::pow(1 - x, power) / std::pow(1 - middle, power - 1);
  }
  const double d = i[0] + y * (i[1] - i[0]), d_max = i[1];
  const double time = std::max(r[0], 2 * ball.step);
  const double K = r[0] > 0 ? 1 / std::pow(d_max * time * r[1], 2) : -r[0] / (d_max * d_max);
  const double B = r[0] > 0 ? 2 / (d_max * time) : -r[1] / d_max;
  const double D = d / ((1 - d) * invweight);
  return {.n_W = {0, 0, 1},
          .weight = 1,
          .stiffness = D * d * K,
          .damping = D * B,
          .friction = ball.friction,
          .inertia = D,
          .creep = 1 / (ball.impratio * D * B),
          .lift = 1};
}

}  // namespace

BOOST_AUTO_TEST_CASE(any_state_has_the_force_of_the_law) {
  Dice dice(1);
  int sticking = 0, sliding = 0;
  for (int i = 0; i < 200; ++i) {
    Ball ball{.mass = dice(0.02, 0.3), .friction = dice(0.1, 1), .impratio = i % 3 == 0 ? 1 : dice(0.2, 5)};
    const double lowest = dice(0.3, 0.7);
    const double solimp[5] = {lowest, dice(lowest, 0.95), dice(5e-4, 2.5e-3), dice(0.2, 0.8), dice(1, 4)};
    std::copy(solimp, solimp + 5, ball.solimp);
    ball.solref[0] = i % 4 == 3 ? -dice(500, 3500) : dice(0.005, 0.055);
    ball.solref[1] = i % 4 == 3 ? -dice(20, 120) : dice(0.3, 1.5);
    Mujoco mujoco(ball);
    mjData& d = *mujoco.d;
    const double distance = -dice(1e-6, 2e-3);
    d.qpos[2] = radius + distance;
    d.qvel[0] = i % 2 == 0 ? dice(0, 0.3) : dice(0, 2e-3);
    d.qvel[2] = dice(-0.035, 0.015);
    for (int axis = 0; axis < 3; ++axis) d.qfrc_applied[axis] = dice(-1.5, 1.5);
    mj_forward(mujoco.m.get(), &d);
    BOOST_REQUIRE(d.ncon == 1);
    const ContactSet found = mujoco.told();
    BOOST_REQUIRE(found.count == 1);
    const Contact& c = found.contact[0];
    const Contact by_docs = law_of(ball, mujoco.m->body_invweight0[2], distance);
    for (const auto field : {&Contact::weight, &Contact::stiffness, &Contact::damping, &Contact::friction,
                             &Contact::inertia, &Contact::creep, &Contact::lift}) {
      const double told = c.*field, expected = by_docs.*field;
      BOOST_TEST(told == expected, tt::tolerance(1e-9));
    }
    BOOST_TEST(std::abs(c.distance - distance) < 1e-15);
    BOOST_TEST(norm(c.p_WC) < 1e-12);
    BOOST_TEST(norm(c.p_TC - Vec3{0, 0, -radius}) < 1e-12);
    const double alone = -c.stiffness * distance - c.damping * d.qvel[2] - c.inertia * d.qacc[2];
    // MuJoCo's friction feels the rate of sliding too; ours does not.
    const double time = c.inertia / c.damping;
    const double w = std::hypot(d.qvel[0] + time * d.qacc[0], d.qvel[1] + time * d.qacc[1]);
    const double mu = c.friction, give = c.creep * mu;
    const bool slides = w > give * alone;
    const double with_lift = (alone + mu * c.damping * w) / (1 + mu * c.damping * give);
    const double N = std::max(0.0, slides ? with_lift : alone);
    (slides ? sliding : sticking) += 1;
    const Vec3 f = mujoco.force();
    BOOST_TEST(std::abs(f.x - N) < 1e-9 * (1 + N));
    BOOST_TEST(std::abs(std::hypot(f.y, f.z) - std::min(w / c.creep, mu * N)) < 1e-9 * (1 + N));
    if (slides && N > 0)
      BOOST_TEST(std::abs(N - alone - c.lift * mu * c.damping * std::max(0.0, w - give * N)) < 1e-9 * (1 + N));
  }
  BOOST_TEST(sticking > 50);
  BOOST_TEST(sliding > 50);
}

BOOST_AUTO_TEST_CASE(the_law_told_is_the_slope_of_mujocos_normal_force_for_each_cone) {
  for (const char* cone : {"pyramidal", "elliptic"}) {
    for (const int condim : {1, 3, 4, 6}) {
      for (const double margin : {0.0, 0.002}) {
        Ball ball{.condim = condim, .cone = cone, .margin = margin, .gap = margin / 4};
        Mujoco mujoco(ball);
        mjData& d = *mujoco.d;
        struct At {
          double force = 0, acceleration = 0;
        };
        const auto at = [&](double distance, double speed, double push) {
          d.qpos[2] = radius + distance;
          d.qvel[2] = speed;
          d.qfrc_applied[2] = push;
          mj_forward(mujoco.m.get(), &d);
          return At{mujoco.force().x, d.qacc[2]};
        };
        const double distance = margin > 0 ? 5e-4 : -5e-4;
        const At pressed = at(distance, -0.01, -1.5), farther = at(distance + 1e-4, -0.01, -1),
                 slower = at(distance, -0.005, -1), here = at(distance, -0.01, -1);
        BOOST_REQUIRE(here.force > 0.1);
        const ContactSet found = mujoco.told();
        BOOST_REQUIRE(found.count == 1);
        const Contact& c = found.contact[0];
        const double inertia = -(pressed.force - here.force) / (pressed.acceleration - here.acceleration);
        const auto at_rest = [&](const At& a) { return a.force + inertia * a.acceleration; };
        const double damping = (at_rest(here) - at_rest(slower)) / 0.005;
        const double stiffness = (at_rest(here) - at_rest(farther)) / 1e-4;
        BOOST_TEST_CONTEXT(cone << ' ' << condim << ' ' << margin) {
          BOOST_TEST(c.inertia == inertia, tt::tolerance(1e-6));
          BOOST_TEST(c.damping == damping, tt::tolerance(1e-6));
          BOOST_TEST(c.stiffness == stiffness, tt::tolerance(1e-6));
          BOOST_TEST(c.friction == (condim == 1 ? 0 : ball.friction));
          // From where on it pushes, which no slope tells.
          BOOST_TEST(at_rest(here) == 0.01 * c.damping - c.stiffness * c.distance, tt::tolerance(1e-6));
          BOOST_TEST(found.penetrating == 1);
          const Vec3 gap = found.bodies.X_WB[0].p + c.p_TC - c.p_WC;
          BOOST_TEST(norm(gap - c.distance * c.n_W) < 1e-12);
        }
      }
    }
  }
}

namespace {

/// How far the ball of our step is from MuJoCo's at most, over 0.2 s of the same forces, m.
double farthest(const Ball& ball, double h, double drop) {
  Mujoco mujoco(ball);
  mjData& d = *mujoco.d;
  d.qpos[2] = radius + drop;
  SystemModel m = block(ball.mass);
  m.integrator = Integrator::midpoint;
  OneBody t(m);
  t.contacts = {told_law(ball)};
  t.X().p.z = drop;
  const auto steps = static_cast<int>(std::lround(h / ball.step));
  double most = 0;
  for (int i = 0; i < std::lround(0.2 / h); ++i) {
    for (int k = 0; k < steps; ++k) mj_step(mujoco.m.get(), &d);
    t.advance(h);
    most = std::max(most, std::abs(t.X().p.z - (d.qpos[2] - radius)));
  }
  return most;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_ball_that_is_pressed_moves_as_mujoco_moves_it) {
  // The impedance is the same at all depths, as one law for all of them wants it.
  const Ball ball;
  const double rest = ball.mass * ball.gravity / told_law(ball).stiffness;
  for (const double drop : {-1e-9, -2 * rest}) {
    const double coarse = farthest(ball, 1e-3, drop), fine = farthest(ball, 2.5e-4, drop);
    BOOST_TEST(coarse < 0.02 * rest);
    BOOST_TEST(fine < 0.01 * rest);
  }
}

BOOST_AUTO_TEST_CASE(a_ball_that_is_dragged_creeps_or_slides_and_rises_as_mujocos) {
  const double drag = 50;  // N s/m
  int slides = 0;
  for (const double speed : {0.02, 0.1, 0.3}) {
    for (const double friction : {0.3, 0.6}) {
      // Heavy enough not to be lifted off.
      Ball ball{.gravity = 200};
      ball.friction = friction;
      ball.step = 5e-5;
      Mujoco mujoco(ball);
      mjData& d = *mujoco.d;
      const Contact law = told_law(ball);
      const double depth = ball.mass * ball.gravity / law.stiffness;
      d.qpos[2] = radius - depth;
      SystemModel m = block(ball.mass);
      m.gravity_W.z = -ball.gravity;
      OneBody t(m);
      t.contacts = {law};
      t.coupling.b_t = drag;
      t.X().p.z = -depth;
      DeviceState hand;
      hand.V_WD.v.x = speed;
      const double end = 1, h = 1e-3;
      for (int i = 0; i < std::lround(end / ball.step); ++i) {
        for (int axis = 0; axis < 3; ++axis) d.qfrc_applied[axis] = drag * ((axis == 0 ? speed : 0) - d.qvel[axis]);
        mj_step(mujoco.m.get(), &d);
      }
      for (int i = 0; i < std::lround(end / h); ++i) t.advance(h, hand);
      BOOST_TEST(t.V().v.x == d.qvel[0], tt::tolerance(0.005));
      BOOST_TEST(std::abs(t.X().p.z - (d.qpos[2] - radius)) < 0.005 * depth);
      slides += t.X().p.z > -0.98 * depth ? 1 : 0;
    }
  }
  BOOST_TEST(slides >= 2);
}

BOOST_AUTO_TEST_SUITE_END()
