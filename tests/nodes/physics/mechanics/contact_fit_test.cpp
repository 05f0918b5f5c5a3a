// The fit of stiffness and friction against wrenches known in closed form.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <limits>

#include "framework/realtime/allocation_watch.hpp"
#include "nodes/physics/mechanics/contact_fit.hpp"
#include "tests/nodes/physics/mechanics/contact_fit_subject.hpp"
#include "tests/support/dice.hpp"

BOOST_AUTO_TEST_SUITE(contact_fit_test)

using namespace tactor;
using namespace tactor::test;
using namespace tactor::test::contact_fit;
namespace tt = boost::test_tools;

BOOST_AUTO_TEST_CASE(a_wall_of_another_stiffness_is_found_at_the_first_result_or_where_it_is_far_off_at_the_second) {
  for (const double scale : {0.2, 0.5, 1.0, 2.0, 5.0}) {
    Subject subject;
    const Wall wall{.v = {-0.05, 0, 0}};  // without friction: nothing slides
    if (scale == 5) BOOST_REQUIRE((subject.take(wall, wall.wrench(scale, 0)) == FitOutcome::awaiting));
    BOOST_REQUIRE((subject.take(wall, wall.wrench(scale, 0)) == FitOutcome::used));
    BOOST_TEST(subject.scale() == scale, tt::tolerance(0.02));
    for (int i = 0; i < 5; ++i) subject.take(wall, wall.wrench(scale, 0));
    BOOST_TEST(subject.scale() == scale, tt::tolerance(0.005));
    BOOST_TEST(subject.excess() == 0.0);
    BOOST_TEST(subject.fit.used_for_friction() == 0);
  }
}

BOOST_AUTO_TEST_CASE(friction_is_found_where_contacts_slide_whatever_the_model_has) {
  Dice dice(1);
  for (const bool rotates : {false, true}) {
    for (const double mu : {0.0, 0.3, 0.6}) {
      for (const double true_mu : {0.0, 0.15, 0.3, 0.6, 1.0}) {
        for (const double scale : {0.5, 1.0, 2.0}) {
          Subject subject(rotates);
          for (int i = 0; i < 3; ++i) {
            const double angle = dice(0, 6.28);
            const Wall wall{.mu = mu, .v = {-0.02, 0.05 * std::cos(angle), 0.05 * std::sin(angle)}};
            BOOST_REQUIRE((subject.take(wall, wall.wrench(scale, true_mu)) == FitOutcome::used));
          }
          BOOST_TEST(subject.scale() == scale, tt::tolerance(0.03));
          BOOST_TEST(std::abs(mu + subject.excess() - true_mu) < 0.02);
          BOOST_TEST(subject.fit.used_for_friction() == 3);
        }
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(what_was_found_is_written_into_the_contacts_of_the_tool_alone) {
  Subject subject;
  const Wall wall{.mu = 0.3, .v = {0, 0.05, 0}};
  for (int i = 0; i < 3; ++i) subject.take(wall, wall.wrench(2, 0));
  LocalContacts contacts = wall.contacts();
  contacts.count = 3;
  contacts.bodies = 3;
  contacts.pair[1] = {1, ContactPair::fixed};
  contacts.pair[2] = {2, 0};
  contacts.contact[2] = contacts.contact[1] = contacts.contact[0];
  correct(subject.fit.correction(), contacts);
  for (const std::size_t tool : {std::size_t{0}, std::size_t{2}}) {
    BOOST_TEST(contacts.contact[tool][0].stiffness == 2 * k, tt::tolerance(0.02));
    BOOST_TEST(contacts.contact[tool][0].damping == 2 * b, tt::tolerance(0.02));
    BOOST_TEST(contacts.contact[tool][0].friction >= 0.0);
    BOOST_TEST(contacts.contact[tool][0].friction < 0.01);
  }
  BOOST_TEST(contacts.contact[1][0].stiffness == k);
  BOOST_TEST(contacts.contact[1][0].damping == b);
  BOOST_TEST(contacts.contact[1][0].friction == 0.3);
  // Of two materials together the rougher keeps its difference, and the smoother has no negative friction.
  LocalContacts both = wall.contacts();
  both.count = 2;
  both.contact[1] = both.contact[0];
  both.contact[0][0].friction = 0.5;
  both.contact[1][0].friction = 0.1;
  for (int i = 0; i < 5; ++i) {
    subject.take(both, wall.bodies(), wall.wrench(2, 0.3) + wall.wrench(2, 0), 2);  // 0.2 less, as far as there is any
  }
  correct(subject.fit.correction(), both);
  BOOST_TEST(std::abs(both.contact[0][0].friction - 0.3) < 0.02);
  BOOST_TEST(both.contact[1][0].friction == 0.0);
}

BOOST_AUTO_TEST_CASE(a_contact_that_sticks_tells_of_the_stiffness_and_of_the_least_friction_only) {
  // Pushed sideways by less than friction could hold, at rest and creeping.
  for (const double creep : {0.0, 0.3 * stick, 0.99 * stick}) {
    for (const double scale : {0.5, 1.0, 2.0}) {
      for (const double held : {0.0, 0.05, 0.25}) {
        Subject subject;
        const Wall wall{.mu = 0.3, .v = {0, creep, 0}};
        const double N = scale * k * depth;
        for (int i = 0; i < 50; ++i) subject.take(wall, {{N, -held * N, 0}, {}});
        BOOST_TEST(subject.scale() == scale, tt::tolerance(0.02));
        BOOST_TEST(std::abs(subject.excess()) < 1e-6);
        BOOST_TEST(subject.fit.used_for_friction() == 0);
      }
    }
  }
  // What holds more than the model's friction has more of it.
  for (const double mu : {0.0, 0.3}) {
    for (const double scale : {0.5, 1.0, 2.0}) {
      Subject subject;
      const Wall wall{.mu = mu, .v = {0, 0.5 * stick, 0}};
      const double N = scale * k * depth;
      for (int i = 0; i < 5; ++i) subject.take(wall, {{N, -0.8 * N, 0}, {}});
      BOOST_TEST(subject.scale() == scale, tt::tolerance(0.03));
      BOOST_TEST(mu + subject.excess() > 0.7);
      BOOST_TEST(mu + subject.excess() < 0.82);
    }
  }
}

BOOST_AUTO_TEST_CASE(results_without_contact_neither_forget_nor_drift) {
  Subject hovering, touching;
  const Wall wall{.mu = 0.3, .v = {-0.02, 0.05, 0}}, above{.deep = -1e-3};
  for (Subject* s : {&hovering, &touching}) {
    for (int i = 0; i < 4; ++i) s->take(wall, wall.wrench(2, 0.1));
  }
  const ContactError known = hovering.fit.error();
  for (int i = 0; i < 20'000; ++i) {
    BOOST_REQUIRE((hovering.take(above, {}, 0) == FitOutcome::silent));
    // Physics that touches where the model does not, and the other way round.
    BOOST_REQUIRE((hovering.take(above, {{1, 0, 0}, {}}, 1) == FitOutcome::silent));
    BOOST_REQUIRE((hovering.take(wall, {}, 0) == FitOutcome::silent));
  }
  BOOST_TEST(same(hovering.fit.error(), known));
  // Nor has what it is certain of.
  for (Subject* s : {&hovering, &touching}) s->take(wall, wall.wrench(2.1, 0.12));
  BOOST_TEST(same(hovering.fit.error(), touching.fit.error()));
}

BOOST_AUTO_TEST_CASE(forces_too_small_to_be_known_tell_nothing) {
  Subject subject;
  const Wall grazing{.mu = 0.3, .v = {0, 0.05, 0}, .deep = 1e-6};  // 2 mN
  for (int i = 0; i < 1000; ++i) subject.take(grazing, grazing.wrench(8, 0.9));
  BOOST_TEST(subject.scale() == 1.0);
  BOOST_TEST(subject.excess() == 0.0);
  BOOST_TEST(subject.fit.used() == 0);
}

BOOST_AUTO_TEST_CASE(a_graze_where_physics_pushes_hard_is_no_stiffness) {
  Subject subject;
  const Wall wall{.mu = 0.3, .v = {0, 0.05, 0}}, grazing{.mu = 0.3, .v = {0, 0.05, 0}, .deep = 5e-7};  // 1 mN
  for (int i = 0; i < 10; ++i) subject.take(wall, wall.wrench(2, 0.3));
  const ContactError known = subject.fit.error();
  for (const double N : {0.1, 1.0, 3.0, 30.0}) {
    BOOST_TEST((subject.take(grazing, {{N, -0.3 * N, 0}, {}}) == FitOutcome::silent));
    BOOST_TEST(same(subject.fit.error(), known));
  }
  BOOST_TEST(subject.fit.surprises() == 0);
}

BOOST_AUTO_TEST_CASE(an_exact_model_stays_what_it_is_and_noise_is_averaged) {
  for (const bool rotates : {false, true}) {
    Subject exact(rotates), noisy(rotates);
    Dice dice(3);
    double square = 0;
    constexpr int count = 2000;
    for (int i = 0; i < count; ++i) {
      const double angle = dice(0, 6.28);
      const Wall wall{.mu = 0.3,
                      .v = {dice(-0.05, 0.05), 0.05 * std::cos(angle), 0.05 * std::sin(angle)},
                      .deep = dice(2e-4, 2e-3)};
      Wrench w = wall.wrench(1, 0.3);
      exact.take(wall, w);
      BOOST_REQUIRE(std::abs(exact.scale() - 1) < 1e-9);
      BOOST_REQUIRE(std::abs(exact.excess()) < 1e-9);
      // What the filter takes for the noise of a model: a few per cent of the force.
      const double off = 0.05 * norm(w.force);
      w.force += dice.in_cube(off);
      w.torque += radius * dice.in_cube(off);
      noisy.take(wall, w);
      square += (noisy.scale() - 1) * (noisy.scale() - 1);
      BOOST_REQUIRE(std::abs(noisy.scale() - 1) < 0.08);
      BOOST_REQUIRE(std::abs(noisy.excess()) < 0.08);
    }
    // The noise of one result is 0.05 / sqrt(3).
    BOOST_TEST(std::sqrt(square / count) < 0.6 * 0.05 / std::sqrt(3.0));
    BOOST_TEST(exact.fit.surprises() == 0);
  }
}

BOOST_AUTO_TEST_CASE(a_change_is_met_at_its_second_result_and_nothing_swings) {
  Subject subject;
  Dice dice(4);
  double before = 1;
  for (const double scale : {1.0, 2.0, 0.5, 4.0, 1.0, 1.0, 0.3}) {
    for (int i = 0; i < 30; ++i) {
      const Wall wall{.mu = 0.3, .v = {0, 0.05, dice(-0.05, 0.05)}};
      subject.take(wall, wall.wrench(scale, 0.3));
      BOOST_TEST(subject.scale() == (i == 0 ? before : scale), tt::tolerance(0.03));
      BOOST_TEST(std::abs(subject.excess()) < 0.02);
    }
    before = scale;
  }
  BOOST_TEST(subject.fit.surprises() == 5);
}

BOOST_AUTO_TEST_CASE(a_surprise_moves_nothing_until_the_next_result_agrees_and_a_small_change_is_met_at_once) {
  const Wall wall{.mu = 0.3, .v = {0, 0.05, 0}};
  Subject subject;
  for (int i = 0; i < 10; ++i) subject.take(wall, wall.wrench(1, 0.3));
  const ContactError known = subject.fit.error();
  // Neither of these has one that agrees beside it: what was expected, or another surprise.
  for (const double scale : {4.0, 0.3, 2.0, 0.5, 3.0}) {
    BOOST_TEST((subject.take(wall, wall.wrench(scale, 0.3)) == FitOutcome::awaiting));
    BOOST_TEST(same(subject.fit.error(), known));
  }
  for (const double scale : {1.0, 3.0}) subject.take(wall, wall.wrench(scale, 0.3));
  BOOST_TEST(subject.scale() == 1.0, tt::tolerance(0.001));
  // The same result again is no second one, and what says nothing does not come between.
  BOOST_TEST((subject.fit.take(subject.time(), wall.contacts(), wall.bodies(), false, wall.wrench(3, 0.3), 1) ==
              FitOutcome::repeated));
  BOOST_TEST((subject.take(wall, {}, 0) == FitOutcome::silent));
  BOOST_TEST((subject.take(wall, wall.wrench(3.1, 0.3)) == FitOutcome::used));
  BOOST_TEST(subject.scale() > 2.95);
  BOOST_TEST(subject.scale() < 3.15);
  BOOST_TEST(subject.fit.surprises() == 1);
  BOOST_TEST((subject.take(wall, wall.wrench(3.4, 0.3)) == FitOutcome::used));
  BOOST_TEST(subject.scale() > 3.1);
}

BOOST_AUTO_TEST_CASE(what_is_beyond_every_stiffness_and_friction_changes_nothing) {
  const Wall wall{.mu = 0.3, .v = {0, 0.05, 0}};  // 2 N and 0.6 N against the sliding
  const double N = k * depth;
  // Pulls, is stiffer or rougher than there is, or pushes along the sliding.
  const Vec3 beyond[] = {{-N, 0, 0},     {-N, -0.3 * N, 0}, {50 * N, -15 * N, 0},
                         {N, -5 * N, 0}, {N, 0.6 * N, 0},   {5 * N, 1.5 * N, 0}};
  for (const bool settled : {false, true}) {
    for (const Vec3& force : beyond) {
      Subject subject;
      for (int i = 0; settled && i < 10; ++i) subject.take(wall, wall.wrench(1, 0.3));
      const ContactError known = subject.fit.error();
      for (int i = 1; i <= 5; ++i) {
        BOOST_TEST((subject.take(wall, {force, {}}) == FitOutcome::unexplained));
        BOOST_TEST(same(subject.fit.error(), known));
        BOOST_TEST(subject.fit.unexplained() == i);
      }
      // It is no reason to stay with what is known.
      for (int i = 0; i < 2; ++i) subject.take(wall, wall.wrench(2, 0.1));
      BOOST_TEST(subject.scale() == 2.0, tt::tolerance(0.03));
      BOOST_TEST(std::abs(subject.excess() + 0.2) < 0.03);
    }
  }
  // Nor does a contact that sticks where no friction could hold it.
  Subject subject;
  const Wall sticking{.mu = 0.3, .v = {0, 0.5 * stick, 0}};
  BOOST_TEST((subject.take(sticking, {{N, -8 * N, 0}, {}}) == FitOutcome::unexplained));
  BOOST_TEST(same(subject.fit.error(), {}));
  // What is a little beyond the bounds is at them.
  for (int i = 0; i < 3; ++i) subject.take(wall, wall.wrench(10.3, 0));
  BOOST_TEST(subject.scale() == 10.0);
  BOOST_TEST(std::abs(subject.excess() + 0.3) < 1e-3);
}

BOOST_AUTO_TEST_CASE(what_is_used_is_the_best_that_there_is_within_the_bounds) {
  // The sum of squares that a first result has to make least, over a grid of all there is.
  Dice dice(11);
  int used = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const double mu = dice(0, 0.5), N = k * depth;
    const Wall wall{.mu = mu, .v = {0, 0.05, 0}};
    const Vec3 force{N * dice(0.03, 3), -N * dice(-0.1, 4), 0};
    Subject subject;
    if (subject.take(wall, {force, {}}) != FitOutcome::used) continue;
    ++used;
    const double share = 0.05 * std::max(norm(force), N * (1 + mu)), variance = 4e-4 + share * share + 4e-12 * k * k;
    const auto squares = [&](double a, double e) {
      const double x = force.x - a * N, y = force.y + a * N * (mu + e);
      return (x * x + y * y) / variance + (a - 1) * (a - 1) + e * e;
    };
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i <= 990; ++i) {
      for (int j = 0; j <= 250; ++j) least = std::min(least, squares(0.1 + 0.01 * i, -mu + 0.01 * j * (2 + mu) / 2.5));
    }
    BOOST_TEST(squares(subject.scale(), subject.excess()) < least + 0.01);
  }
  BOOST_TEST(used > 50);
}

BOOST_AUTO_TEST_CASE(a_friction_known_to_be_less_stays_so_while_what_is_touched_has_none) {
  const Wall rough{.mu = 0.3, .v = {0, 0.05, 0}}, smooth{.mu = 0, .v = {0, 0.05, 0}};
  LocalContacts both = rough.contacts();
  both.count = 2;
  both.contact[1] = smooth.contacts().contact[0];
  Subject subject;
  for (int i = 0; i < 10; ++i) subject.take(both, rough.bodies(), rough.wrench(2, 0.1) + smooth.wrench(2, 0), 2);
  const double known = subject.excess();
  for (int i = 0; i < 20; ++i) {
    BOOST_TEST((subject.take(smooth, smooth.wrench(2, 0)) == FitOutcome::used));
    BOOST_TEST((subject.excess() == known && known < -0.15));
  }
  // That it has some after all is learnt.
  for (int i = 0; i < 3; ++i) subject.take(smooth, smooth.wrench(2, 0.4));
  BOOST_TEST(std::abs(subject.excess() - 0.4) < 0.02);
}

BOOST_AUTO_TEST_CASE(what_no_stiffness_and_no_friction_explains_hardly_counts) {
  for (const double across : {2.0, 12.0}) {
    Subject subject;
    const Wall wall{.mu = 0.3, .v = {0, 0.05, 0}};
    for (int i = 0; i < 10; ++i) subject.take(wall, wall.wrench(2, 0.3));
    for (int i = 0; i < 5; ++i) {
      Wrench w = wall.wrench(3, 0.3);
      w.force.z = across;  // neither along the normal nor along the sliding
      subject.take(wall, w);
      BOOST_TEST(subject.scale() == 2.0, tt::tolerance(0.02));
      BOOST_TEST(std::abs(subject.excess()) < 0.02);
    }
    // The one counts less, the other not at all.
    BOOST_TEST(subject.fit.used() == (across < 5 ? 15 : 10));
  }
}

BOOST_AUTO_TEST_CASE(the_law_error_is_what_neither_stiffness_nor_friction_nor_sticking_explains) {
  const Wall sliding{.v = {-0.02, 0.05, 0}}, resting{.v = {0, 0.2 * stick, 0}};
  Subject subject;
  BOOST_TEST(subject.fit.law_error() == 0.0);
  for (int i = 0; i < 3; ++i) subject.take(sliding, sliding.wrench(1.5, 0.5));  // learnt
  BOOST_TEST(subject.fit.law_error() < 0.05);
  // Across the sliding: no friction does that.
  Wrench across = sliding.wrench(1, 0.3);
  across.force.z += 3;
  Subject foreign;
  for (int i = 0; i < 3; ++i) foreign.take(sliding, across);
  BOOST_TEST(foreign.fit.law_error() == 3.0, tt::tolerance(0.02));
  // A contact that sticks may hold as much.
  Wrench held = resting.wrench(1, 0);
  held.force.z += 0.3;
  Subject stuck;
  for (int i = 0; i < 3; ++i) stuck.take(resting, held);
  BOOST_TEST(stuck.fit.law_error() < 0.05);
  // Physics pushes where the model has nothing, and nothing touches.
  LocalContacts none = sliding.contacts();
  none.count = 0;
  foreign.take(none, sliding.bodies(), sliding.wrench(1, 0));
  BOOST_TEST(foreign.fit.law_error() == norm(sliding.wrench(1, 0).force), tt::tolerance(1e-9));
  foreign.take(none, sliding.bodies(), {}, 0);
  BOOST_TEST(foreign.fit.law_error() == 0.0);
  // The model pushes where physics has nothing.
  Subject alone;
  alone.take(sliding, {}, 0);
  BOOST_TEST(alone.fit.law_error() == norm(sliding.wrench(1, 0.3).force), tt::tolerance(1e-9));
}

BOOST_AUTO_TEST_CASE(results_of_the_past_and_repeated_ones_are_not_used) {
  const Wall wall{.mu = 0.3, .v = {0, 0.05, 0}};
  ContactFit fit(false, stick);
  const auto take = [&](std::int64_t ms, double scale) {
    return fit.take(Time{ms * 1'000'000}, wall.contacts(), wall.bodies(), false, wall.wrench(scale, 0.3), 1);
  };
  BOOST_TEST((take(100, 2) == FitOutcome::used));
  const ContactError known = fit.error();
  BOOST_TEST((take(100, 0.5) == FitOutcome::repeated));
  BOOST_TEST((take(80, 0.5) == FitOutcome::repeated));
  BOOST_TEST(same(fit.error(), known));
  BOOST_TEST(fit.used() == 1);
  BOOST_TEST((take(101, 2) == FitOutcome::used));
}

BOOST_AUTO_TEST_CASE(another_material_begins_anew_and_a_shared_one_does_not) {
  Subject subject;
  const Wall rubber{.mu = 0.3, .v = {0, 0.05, 0}};
  for (int i = 0; i < 20; ++i) subject.take(rubber, rubber.wrench(2, 0.1));
  // Steel too, then steel alone: what is known goes on.
  LocalContacts steel = rubber.contacts();
  steel.contact[0][0].stiffness = 3 * k;
  LocalContacts both = rubber.contacts();
  both.count = 2;
  both.contact[1] = steel.contact[0];
  Wrench w = rubber.wrench(2, 0.1);
  subject.take(both, rubber.bodies(), 4 * w, 2);
  BOOST_TEST(subject.fit.resets() == 0);
  subject.take(steel, rubber.bodies(), 3 * w);
  BOOST_TEST(subject.fit.resets() == 0);
  BOOST_TEST(subject.scale() == 2.0, tt::tolerance(0.02));
  // A touch of rubber that is too light to tell leaves what is known of steel, and rubber as it is.
  const Wall light{.mu = 0.3, .v = {0, 0.05, 0}, .deep = 1e-6};
  subject.take(light, light.wrench(1, 0.3));
  BOOST_TEST(subject.fit.resets() == 0);
  LocalContacts corrected = both;
  correct(subject.fit.correction(), corrected);
  BOOST_TEST(corrected.contact[0][0].stiffness == k);
  BOOST_TEST(corrected.contact[0][0].friction == 0.3);
  BOOST_TEST(corrected.contact[1][0].stiffness == 6 * k, tt::tolerance(0.02));
  // Rubber after steel alone: nothing is known.
  subject.take(rubber, rubber.wrench(1, 0.3));
  BOOST_TEST(subject.fit.resets() == 1);
  BOOST_TEST(std::abs(subject.scale() - 1) < 1e-9);
  BOOST_TEST(std::abs(subject.excess()) < 1e-9);
}

BOOST_AUTO_TEST_CASE(contacts_between_other_bodies_do_not_matter) {
  // The tool on the wall; beside it body 1 on the wall, absurdly deep. Then the tool as the other of a pair.
  Subject alone, beside, other;
  const Wall wall{.mu = 0.3, .v = {0, 0.05, 0}};
  LocalContacts contacts = wall.contacts();
  contacts.bodies = 2;
  contacts.count = 2;
  contacts.X_WB[0][1].p = {1, 1, 1};
  contacts.pair[1] = {1, ContactPair::fixed};
  contacts.contact[1][0] = contacts.contact[0][0];
  contacts.contact[1][0].stiffness = 1e6;
  contacts.contact[1][0].friction = 1.5;
  BodyStates bodies = wall.bodies();
  bodies.count = 2;
  bodies.X_WB[1].p = {1, 1, 1};
  // Body 1 stands still and the tool is what it hits: the normal points from the tool to it.
  LocalContacts turned;
  turned.anchors = 1;
  turned.bodies = 2;
  turned.count = 1;
  turned.X_WB[0] = bodies.X_WB;
  turned.pair[0] = {1, 0};
  Contact& c = turned.contact[0][0];
  c = {.n_W = {-1, 0, 0}, .distance = -depth, .weight = 1, .stiffness = k, .damping = b, .friction = 0.3};
  c.p_TC = Vec3{-depth, 0, 0} - bodies.X_WB[1].p;
  for (int i = 0; i < 4; ++i) {
    const Wrench w = wall.wrench(2, 0.1);
    alone.take(wall, w);
    beside.take(contacts, bodies, w);
    other.take(turned, bodies, w);
  }
  BOOST_TEST(same(alone.fit.error(), beside.fit.error()));
  BOOST_TEST(other.scale() == 2.0, tt::tolerance(0.02));
  BOOST_TEST(std::abs(other.excess() + 0.2) < 0.02);
}

BOOST_AUTO_TEST_CASE(dampers_of_a_massless_tool_are_left_out) {
  ContactFit fit(false, stick);
  const Wall wall{.mu = 0, .v = {-0.3, 0, 0}};  // the damper would give 0.9 N of 2.9 N
  for (int i = 1; i < 5; ++i) {
    fit.take(Time{i * 10'000'000LL}, wall.contacts(), wall.bodies(), true, {{1.5 * k * depth, 0, 0}, {}}, 1);
  }
  BOOST_TEST(fit.error().stiffness_scale == 1.5, tt::tolerance(0.02));
}

BOOST_AUTO_TEST_CASE(whatever_comes_the_estimate_is_finite_and_bounded_and_good_results_mend_it) {
  Dice dice(9);
  const double poison[] = {not_a_number, std::numeric_limits<double>::infinity(), -1e308, 1e200, 1e150, 1e30, -1, 0};
  const Wall good{.mu = 0.3, .v = {0.01, 0.05, 0.02}};
  for (int trial = 0; trial < 300; ++trial) {
    Subject subject(trial % 2 == 0);
    const double bad = poison[trial % 8];
    for (int i = 0; i < 30; ++i) {
      LocalContacts contacts = wall_around({{0.009, 0, 0}, {0.0091, 0, 0}}, k, b, 0.3);
      BodyStates bodies = good.bodies();
      Wrench wrench = good.wrench(dice(0, 3), dice(0, 1));
      const auto spoil = [&](auto& message, std::size_t bytes) {
        const auto words = reinterpret_cast<double*>(&message);
        words[static_cast<std::size_t>(dice(0, static_cast<double>(bytes / sizeof(double))))] = bad;
      };
      const int where = static_cast<int>(dice(0, 8));
      if (where == 0) spoil(wrench, sizeof wrench);
      if (where == 1) spoil(contacts.contact[0], 2 * sizeof(Contact));
      if (where == 2) spoil(bodies.X_WB[0], sizeof(Pose));
      if (where == 3) spoil(bodies.V_WB[0], sizeof(Twist));
      if (where == 4) spoil(contacts.X_WB[1][0], sizeof(Pose));
      if (where == 5) wrench.force = bad * wrench.force;
      if (where == 6) contacts.count = static_cast<int>(dice(-2, 60));
      if (where == 7) contacts.pair[0] = {static_cast<int>(dice(-2, 9)), static_cast<int>(dice(-3, 9))};
      const auto heap = thread_heap_calls();
      subject.take(contacts, bodies, wrench, static_cast<int>(dice(-1, 3)));
      const auto calls = thread_heap_calls() - heap;
      BOOST_REQUIRE(calls == 0);
      BOOST_REQUIRE(std::isfinite(subject.scale()));
      BOOST_REQUIRE((subject.scale() >= 0.1 && subject.scale() <= 10));
      BOOST_REQUIRE(std::isfinite(subject.excess()));
      BOOST_REQUIRE(std::abs(subject.excess()) <= 2);
    }
    for (int i = 0; i < 40; ++i) subject.take(good, good.wrench(2, 0.2));
    BOOST_TEST(subject.scale() == 2.0, tt::tolerance(0.03));
    BOOST_TEST(std::abs(subject.excess() + 0.1) < 0.03);
  }
}

BOOST_AUTO_TEST_CASE(a_result_that_is_not_finite_changes_nothing) {
  Subject subject;
  const Wall wall{.mu = 0.3, .v = {0, 0.05, 0}};
  subject.take(wall, wall.wrench(2, 0.3));
  const ContactError known = subject.fit.error();
  for (const double bad : {not_a_number, std::numeric_limits<double>::infinity(), 1e300}) {
    BOOST_TEST((subject.take(wall, {{bad, 0, 0}, {}}) == FitOutcome::unusable));
    BodyStates bodies = wall.bodies();
    bodies.V_WB[0].v.y = bad;
    if (bad != 1e300) BOOST_TEST((subject.take(wall.contacts(), bodies, wall.wrench(1, 0)) == FitOutcome::unusable));
  }
  BOOST_TEST(same(subject.fit.error(), known));
}

BOOST_AUTO_TEST_SUITE_END()
