// The energy of a line against sums of its own, and its bound against handles that do anything within an acceleration.
#include "framework/realtime/line_energy.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <random>
#include <vector>

BOOST_AUTO_TEST_SUITE(line_energy_test)

using namespace tactor;

namespace {

constexpr std::int64_t ms = 1'000'000;

LineEnergyOptions options_of(int delay_out_ms, double step = 0) {
  return {.axes = 3,
          .step = every_axis(step),
          .period = Duration{ms},
          .delay_out = Duration{delay_out_ms * ms},
          .held = Duration{2 * ms},
          .lets_go = true};
}

double path(int n) {
  return 0.01 * std::sin(0.05 * n);
}

}  // namespace

BOOST_AUTO_TEST_CASE(an_effort_counts_over_the_way_on_which_it_acted_whatever_the_delays) {
  // The encoders of tick n - in are read at n; what is given at n acts from n + out on.
  for (const int in : {0, 1, 2}) {
    for (const int out : {0, 1, 3}) {
      LineEnergy energy(options_of(out));
      const auto effort = [](int n) { return n < 0 ? 0.0 : 3 + 2 * std::cos(0.31 * n); };
      double given = 0, most = 0, largest = 0;
      for (int n = 0; n < 400; ++n) {
        if (n >= in) energy.take(Time{(n - in) * ms}, {0, path(n - in)});
        if (n > in) {
          const double in_tick = effort(n - in - 1 - out) * (path(n - in) - path(n - in - 1));
          given += in_tick;
          most = std::max(most, given);
          largest = std::max(largest, std::abs(in_tick));
        }
        BOOST_TEST(std::abs(energy.totals().generated_J - most) < 1e-12);
        BOOST_TEST(std::abs(energy.totals().allowed_J - largest) < 1e-12);
        BOOST_TEST(energy.give(Time{n * ms}, {0, effort(n)}, {}) == (AxisValues{0, effort(n)}));
      }
      BOOST_TEST(most > 0.01);
    }
  }
}

BOOST_AUTO_TEST_CASE(the_weight_of_the_tool_is_not_counted) {
  LineEnergy energy(options_of(0));
  for (int n = 0; n < 100; ++n) {
    energy.take(Time{n * ms}, {0, 0, -1e-4 * n});
    energy.give(Time{n * ms}, {0, 0, -1}, {0, 0, -1});
  }
  BOOST_TEST(energy.totals().generated_J == 0.0);
}

BOOST_AUTO_TEST_CASE(motors_that_let_go_give_for_the_time_that_they_held) {
  LineEnergy energy(options_of(1));
  energy.take(Time{0}, {0});
  energy.give(Time{0}, {5}, {});  // acts from 1 ms on
  energy.take(Time{1 * ms}, {0.001});
  energy.give(Time{1 * ms}, {7}, {});  // would act from 2 ms on
  energy.take(Time{2 * ms}, {0.002});
  BOOST_TEST(std::abs(energy.totals().generated_J - 0.005) < 1e-15);
  energy.let_go(Time{3 * ms});
  // Where it is 9 ms later says nothing of the millisecond in which the 7 N acted, at 1 m/s.
  energy.take(Time{12 * ms}, {-0.022});
  BOOST_TEST(std::abs(energy.totals().generated_J - (0.005 + 7 * 0.001)) < 1e-15);
}

BOOST_AUTO_TEST_CASE(a_line_that_was_closed_counts_no_way_from_before) {
  LineEnergy energy(options_of(0));
  energy.take(Time{0}, {0});
  energy.give(Time{0}, {5}, {});
  energy.reopen();
  energy.take(Time{500 * ms}, {0.3});
  energy.give(Time{500 * ms}, {5}, {});
  energy.take(Time{501 * ms}, {0.301});
  BOOST_TEST(std::abs(energy.totals().generated_J - 0.005) < 1e-15);
}

BOOST_AUTO_TEST_CASE(a_bound_gives_no_more_than_was_wanted_and_not_the_other_way_whatever_the_weight) {
  LineEnergyOptions options = options_of(0);
  options.bounds = true;
  LineEnergy energy(options);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  int changed = 0;
  for (int n = 0; n < 5000; ++n) {
    energy.take(Time{n * ms}, {path(n), 0, path(3 * n)});
    const AxisValues wanted{8 * unit(random), 0, 8 * unit(random)};
    const AxisValues given = energy.give(Time{n * ms}, wanted, {0, 0, -5});
    for (std::size_t a = 0; a < 3; ++a) {
      BOOST_TEST(given[a] * wanted[a] >= 0.0);
      BOOST_TEST(std::abs(given[a]) <= std::abs(wanted[a]));
      changed += given[a] != wanted[a] ? 1 : 0;
    }
  }
  BOOST_TEST(changed > 100);
}

BOOST_AUTO_TEST_CASE(a_damper_is_never_touched_by_the_bound) {
  LineEnergyOptions options = options_of(1);
  options.bounds = true;
  LineEnergy energy(options);
  for (int n = 0; n < 3000; ++n) {
    const double x = path(n), v = 1e3 * (path(n) - path(n - 1));
    energy.take(Time{n * ms}, {x});
    energy.give(Time{n * ms}, {-4 * v}, {});
  }
  BOOST_TEST(energy.totals().changed_share < 0.02);
  BOOST_TEST(energy.totals().generated_J <= energy.totals().allowed_J);
}

BOOST_AUTO_TEST_CASE(no_handle_within_the_acceleration_gets_more_than_the_bound_and_without_it_most_do) {
  int active = 0, runs = 0;
  double worst = 0;
  for (const bool bounds : {true, false}) {
    for (const int in : {0, 1, 2}) {
      for (const int out : {0, 1, 2}) {
        for (unsigned seed = 1; seed <= 40; ++seed) {
          std::mt19937 random(seed * 97 + 7 * static_cast<unsigned>(in) + static_cast<unsigned>(out));
          std::uniform_real_distribution<double> unit(-1, 1);
          const double step = seed % 2 == 0 ? 1e-5 : 0;
          LineEnergyOptions options = options_of(out, step);
          options.bounds = bounds;
          LineEnergy energy(options);
          // A handle in one dimension; its hand changes its mind now and then. It is on a wall of any stiffness, late,
          // or on a damper that drives.
          const double stiffness = std::pow(10, 2.5 + 1.5 * std::abs(unit(random)));
          const double drives = seed % 5 == 0 ? 20 : 0;  // N s/m
          constexpr int sub_steps = 10;
          constexpr double h = 1e-3 / sub_steps;
          double x = 0.002, v = 0, acceleration = 0, given = 0, most = 0;
          std::vector<double> places, efforts;
          for (int n = 0; n < 1500; ++n) {
            places.push_back(step > 0 ? step * std::round(x / step) : x);
            const auto at = [&](int k) { return places[static_cast<std::size_t>(std::max(0, k))]; };
            if (n >= in) energy.take(Time{(n - in) * ms}, {at(n - in)});
            const double late = at(n - in - 3), speed = 1e3 * (at(n - in) - at(n - in - 1));
            const double wanted = std::clamp(drives > 0 ? drives * speed : -stiffness * late, -8.0, 8.0);
            efforts.push_back(energy.give(Time{n * ms}, {wanted}, {})[0]);
            const double force = n >= out ? efforts[static_cast<std::size_t>(n - out)] : 0;
            if (unit(random) > 0.9) acceleration = 60 * unit(random);
            // The hand does what is worst of what it may: it goes with the motors for a while.
            const double with = seed % 3 == 0 && force != 0 ? std::copysign(60, force) : acceleration;
            for (int s = 0; s < sub_steps; ++s) {
              const double a = std::abs(x) > 0.02 ? -std::copysign(60, x) : with;
              const double before = x;
              x += h * (v + 0.5 * h * a);
              v += h * a;
              v = std::clamp(v, -0.5, 0.5);
              given += force * (x - before);
              most = std::max(most, given);
            }
          }
          const double share = most / (energy.totals().allowed_J + options.start);
          ++runs;
          if (bounds) {
            worst = std::max(worst, share);
            BOOST_TEST(share <= 1, "in " << in << " out " << out << " seed " << seed << ": " << share);
          } else if (share > 1) {
            ++active;
          }
        }
      }
    }
  }
  BOOST_TEST(active > runs / 4);
  BOOST_TEST_MESSAGE("the largest share of the bound: " << worst);
}

BOOST_AUTO_TEST_SUITE_END()
