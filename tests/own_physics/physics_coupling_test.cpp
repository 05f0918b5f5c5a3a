// The coupling as engines take it, against the implicit step that it stands for and the bound of an explicit one.
#include <boost/test/unit_test.hpp>

#include <cmath>
#include <limits>
#include <string>

#include "framework/core/check.hpp"
#include "framework/session/physics_coupling.hpp"

BOOST_AUTO_TEST_SUITE(physics_coupling_test)

using namespace tactor;
namespace tt = boost::test_tools;

namespace {

constexpr CouplingParameters spring{.k_t = 800, .b_t = 9, .k_r = 1.5, .b_r = 0.02};

/// The velocity after an implicit Euler step of a mass on the spring, whose handle is at `x_D` at the step's end.
double implicit_velocity(double x, double v, double x_D, double v_D, double m, double h) {
  const double k = spring.k_t, b = spring.b_t;
  return (m * v + h * k * (x_D - x) + h * b * v_D) / (m + h * b + h * h * k);
}

DeviceState handle_at(const Vec3& p, const Vec3& v = {}) {
  return {{p, {}}, {v, {}}, 0};
}

/// The message of the InputError that `work` throws; empty where it throws none.
template <class Work>
std::string refusal_of(const Work& work) {
  try {
    static_cast<void>(work());
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

/// Whether v' = v - h (k x + b v) / m, x' = x + h v' stays bounded.
bool stays_bounded(double k, double b, double m, double h) {
  double x = 1, v = 0;
  for (int i = 0; i < 20000; ++i) {
    v -= h * (k * x + b * v) / m;
    x += h * v;
  }
  return std::abs(x) < 1e3;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_damper_that_takes_the_step_in_makes_the_spring_implicit) {
  const double m = 0.05, h = 2e-3, x = 0.01, v = -0.3, x_D = 0.013, v_D = 0.4;
  const ImplicitSpring as_is = implicit_spring(spring);
  BOOST_TEST(as_is.k_t == spring.k_t);
  BOOST_TEST(as_is.b_r == spring.b_r);
  const ImplicitSpring held = implicit_spring(spring, h);
  // The engine: the spring where the step begins, the damper at its end.
  const double found = (m * v + h * held.k_t * (x_D - x) + h * held.b_t * v_D) / (m + h * held.b_t);
  BOOST_TEST(found == implicit_velocity(x, v, x_D + h * v_D, v_D, m, h), tt::tolerance(1e-12));
  BOOST_TEST(held.b_r == spring.b_r + h * spring.k_r, tt::tolerance(1e-15));
}

BOOST_AUTO_TEST_CASE(erp_and_cfm_make_the_same_step) {
  const double m = 0.05, h = 2e-3, x = 0.01, v = -0.3;
  const ErpCfm soft = erp_cfm(spring, h);
  // v' = v + h lambda / m and v' = -(erp / h) x - cfm lambda.
  const double lambda = (-soft.erp_t / h * x - v) / (h / m + soft.cfm_t);
  BOOST_TEST(v + h * lambda / m == implicit_velocity(x, v, 0, 0, m, h), tt::tolerance(1e-12));
  BOOST_TEST(soft.erp_r == h * 1.5 / (h * 1.5 + 0.02), tt::tolerance(1e-12));
  const ErpCfm none = erp_cfm({}, h);
  BOOST_TEST(none.erp_t == 0.0);
  BOOST_TEST(none.cfm_t == std::numeric_limits<double>::infinity());
  for (const double poor : {0.0, -1e-3, std::nan("")}) {
    BOOST_TEST(refusal_of([&] { return erp_cfm(spring, poor); }).starts_with("h: expected a number above 0 s"));
  }
  BOOST_TEST(refusal_of([] { return implicit_spring(spring, -1); }).starts_with("h: expected"));
}

BOOST_AUTO_TEST_CASE(the_explicit_wrench_pulls_the_tool_to_the_handle) {
  ExplicitTool tool{.X_WT = {{0.01, 0, 0}, from_rotation_vector({0, 0, 0.1})},
                    .V_WT = {{0, 0.2, 0}, {0, 0, 1}},
                    .mass = 0.1,
                    .inertia = 1e-4};
  const Wrench on_tool = explicit_wrench(spring, handle_at({0.012, 0, 0}, {0, 0.5, 0}), tool, 1e-3);
  BOOST_TEST(on_tool.force.x == 800 * 0.002, tt::tolerance(1e-12));
  BOOST_TEST(on_tool.force.y == 9 * 0.3, tt::tolerance(1e-12));
  BOOST_TEST(on_tool.torque.z == -1.5 * 0.1 - 0.02 * 1, tt::tolerance(1e-12));
  tool.inertia = 0;
  BOOST_TEST(norm(explicit_wrench(spring, handle_at({}), tool, 1e-3).torque) == 0.0);
  tool.X_WT.p.x = std::nan("");
  BOOST_TEST(refusal_of([&] { return explicit_wrench(spring, handle_at({}), tool, 1e-3); }).find("not finite") !=
             std::string::npos);
}

BOOST_AUTO_TEST_CASE(an_explicit_force_is_refused_exactly_where_it_is_not_stable) {
  // h^2 k/m is 4 without any rounding.
  const CouplingParameters stiff{.k_t = 4, .k_r = 4};
  ExplicitTool tool{.mass = 1, .inertia = 0};
  const auto refused = [&](double h) {
    return refusal_of([&] { return explicit_wrench(stiff, handle_at({}), tool, h); });
  };
  const std::string at_bound = refused(1);
  BOOST_TEST(at_bound.find("translation is too stiff") != std::string::npos, at_bound);
  BOOST_TEST(at_bound.find("is 4 and must be below 4") != std::string::npos, at_bound);
  BOOST_TEST(at_bound.find("steps shorter than 1 s") != std::string::npos, at_bound);
  BOOST_TEST(at_bound.find("implicit_spring") != std::string::npos, at_bound);
  BOOST_TEST(refused(std::nextafter(1.0, 0.0)).empty());
  tool.mass = 2;
  tool.inertia = 1;
  BOOST_TEST(refused(1).find("rotation is too stiff") != std::string::npos);
  BOOST_TEST(refused(std::nextafter(1.0, 0.0)).empty());
  for (const double poor : {-1.0, std::nan("")}) {
    tool.inertia = poor;
    BOOST_TEST(refused(0.1).starts_with("inertia: expected"));
  }
  tool.mass = 0;
  BOOST_TEST(refused(0.1).starts_with("mass: expected"));
}

BOOST_AUTO_TEST_CASE(the_longest_step_that_is_told_is_where_the_step_begins_to_diverge) {
  const double k = 3000, b = 12, m = 0.05;
  const std::string text = refusal_of(
      [&] { return explicit_wrench({.k_t = k, .b_t = b}, handle_at({}), {.X_WT = {}, .V_WT = {}, .mass = m}, 0.1); });
  const std::size_t at = text.find("shorter than ");
  BOOST_REQUIRE(at != std::string::npos);
  const double longest = std::stod(text.substr(at + 13));
  BOOST_TEST(stays_bounded(k, b, m, 0.99 * longest));
  BOOST_TEST(!stays_bounded(k, b, m, 1.01 * longest));
}

BOOST_AUTO_TEST_SUITE_END()
