// Fewer contacts that push as all of them did, the same ones from query to query.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <functional>
#include <set>

#include "nodes/physics/contact/contact_reduction.hpp"

#include "nodes/physics/mesh/bounds.hpp"
#include "tests/support/dice.hpp"

BOOST_AUTO_TEST_SUITE(contact_reduction_test)

using namespace tactor;
namespace tt = boost::test_tools;

namespace {

void add(FoundContacts& found, const Vec3& p, const Vec3& n, double distance, double weight, std::uint64_t sample,
         ContactPair pair = {}, double stiffness = 1000, std::uint64_t pair_of = 0) {
  Contact c;
  c.p_WC = p;
  c.n_W = n / norm(n);
  c.p_TC = p + distance * c.n_W;
  c.distance = distance;
  c.weight = weight;
  c.stiffness = stiffness;
  found.contact.push_back(c);
  found.pair.push_back(pair);
  found.key.push_back(contact_key(pair_of + static_cast<std::uint64_t>(pair.body), false, sample));
}

/// Force (N) and torque (N m) about the origin at rest, of the contacts of a pair.
template <class Contacts, class Pairs>
Wrench wrench(const Contacts& contact, const Pairs& pair, std::size_t count, std::int32_t body = 0) {
  Wrench sum;
  for (std::size_t i = 0; i < count; ++i) {
    if (contact[i].distance >= 0 || pair[i].body != body) continue;
    const Vec3 f = -contact[i].weight * contact[i].stiffness * contact[i].distance * contact[i].n_W;
    sum = sum + Wrench{f, cross(contact[i].p_WC, f)};
  }
  return sum;
}
Wrench of_all(const FoundContacts& found, std::int32_t body = 0) {
  return wrench(found.contact, found.pair, found.contact.size(), body);
}
Wrench of_kept(const ContactSet& set, std::int32_t body = 0) {
  return wrench(set.contact, set.pair, static_cast<std::size_t>(set.count), body);
}

/// Points of a lattice 2 mm apart that have come into a bowl of radius 60 mm, whose lowest point is at `middle`, with
/// weights that differ.
FoundContacts in_bowl(const Vec3& middle, double sunk) {
  FoundContacts found;
  for (int i = -20; i <= 20; ++i) {
    for (int j = -20; j <= 20; ++j) {
      const Vec3 p{0.002 * i, 0.002 * j, 0};
      const Vec3 from = p - (middle + Vec3{0, 0, 0.06 - sunk});
      const double distance = norm(from) - 0.06;
      const int key = 41 * (i + 20) + j + 20;
      if (distance < 0.001) add(found, p, from, distance, 0.05 + 0.01 * (key % 7), static_cast<std::uint64_t>(key));
    }
  }
  return found;
}

std::set<std::pair<double, double>> places(const ContactSet& set) {
  std::set<std::pair<double, double>> kept;
  for (int i = 0; i < set.count; ++i) {
    const Contact& c = set.contact[static_cast<std::size_t>(i)];
    kept.insert({c.p_WC.x, c.p_WC.y});
  }
  return kept;
}

}  // namespace

BOOST_AUTO_TEST_CASE(as_many_as_fit_pass_unchanged) {
  FoundContacts found;
  test::Dice dice(5);
  for (std::uint64_t i = 0; i < 128; ++i) {
    add(found, {dice(-1, 1), dice(-1, 1), 0}, {0, 0, 1}, dice(-1e-3, 1e-3), dice(0.1, 2), i);
  }
  ContactReduction reduction(128, 200);
  ContactSet set;
  reduction.reduce(found, set);
  BOOST_TEST(set.count == 128);
  BOOST_TEST(set.truncated == 0);
  int penetrating = 0;
  for (std::size_t i = 0; i < 128; ++i) {
    BOOST_TEST(set.contact[i].weight == found.contact[i].weight);
    BOOST_TEST((set.contact[i].p_WC == found.contact[i].p_WC));
    penetrating += found.contact[i].distance < 0 ? 1 : 0;
  }
  BOOST_TEST(set.penetrating == penetrating);
}

BOOST_AUTO_TEST_CASE(a_flat_patch_keeps_its_force_its_centre_and_its_extent) {
  // Pressed deeper towards one side, finer at the other.
  FoundContacts found;
  test::Dice dice(5);
  for (std::uint64_t i = 0; i < 900; ++i) {
    const double x = dice(0, 1) * dice(0, 1) * 0.1, y = dice(-0.02, 0.02);
    add(found, {x, y, 0}, {0, 0, 1}, -1e-3 - 5e-3 * x, 0.02, i);
  }
  for (const int most : {8, 32, 128}) {
    BOOST_TEST_CONTEXT(most) {
      ContactReduction reduction(most, 900);
      ContactSet set;
      reduction.reduce(found, set);
      BOOST_TEST(set.count == most);
      BOOST_TEST(set.penetrating == most);
      BOOST_TEST(set.truncated == 900 - most);
      const Wrench all = of_all(found), kept = of_kept(set);
      BOOST_TEST(norm(all.force - kept.force) < 1e-6 * norm(all.force));
      BOOST_TEST(norm(all.torque - kept.torque) < 1e-6 * norm(all.torque));
      Bounds bounds;
      for (int i = 0; i < set.count; ++i) {
        const Contact& c = set.contact[static_cast<std::size_t>(i)];
        BOOST_TEST(c.weight > 0);
        bounds.add(c.p_WC);
      }
      BOOST_TEST(bounds.size().x > 0.08);
      BOOST_TEST(bounds.size().y > 0.03);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_wall_about_to_be_touched_keeps_its_stiffness_beside_one_that_is_pressed) {
  // Two walls that face each other, each of 900 points and 45 patches; the tool presses the one and is 1 mm from the
  // other.
  FoundContacts found;
  test::Dice dice(5);
  for (std::uint64_t i = 0; i < 900; ++i) {
    add(found, {dice(0, 0.05), dice(0, 0.03), 0}, {0, 0, 1}, dice(-1.1e-3, -0.9e-3), 0.05, i);
  }
  for (std::uint64_t i = 900; i < 1800; ++i) {
    add(found, {dice(0, 0.05), dice(0, 0.03), 0.02}, {0, 0, -1}, dice(0.9e-3, 1.1e-3), 0.05, i);
  }
  ContactReduction reduction(128, 1800);
  ContactSet set;
  reduction.reduce(found, set);
  BOOST_TEST(set.count == 128);
  BOOST_TEST(set.penetrating == 96);
  BOOST_TEST(set.truncated == 1800 - 128);
  BOOST_TEST(norm(of_all(found).force - of_kept(set).force) < 1e-6 * norm(of_all(found).force));
  double weight = 0;
  Bounds far_wall;
  Vec3 centre;
  for (int i = 0; i < set.count; ++i) {
    const Contact& c = set.contact[static_cast<std::size_t>(i)];
    if (c.distance < 0) continue;
    BOOST_TEST(c.n_W.z == -1);
    weight += c.weight;
    centre += c.weight * c.p_WC;
    far_wall.add(c.p_WC);
  }
  // Of 45; the nearest of each place stand for those a little farther.
  BOOST_TEST(weight > 0.85 * 45);
  BOOST_TEST(weight < 45);
  BOOST_TEST(std::abs(centre.x / weight - 0.025) < 0.002);
  BOOST_TEST(std::abs(centre.y / weight - 0.015) < 0.002);
  BOOST_TEST(far_wall.size().x > 0.04);
  BOOST_TEST(far_wall.size().y > 0.024);
}

BOOST_AUTO_TEST_CASE(contacts_about_to_touch_do_not_change_the_wrench) {
  // A small patch, pressed unevenly, in a wide ring that does not touch.
  FoundContacts found;
  test::Dice dice(6);
  for (std::uint64_t i = 0; i < 300; ++i) {
    const double x = dice(-1e-3, 1e-3), y = dice(-1e-3, 1e-3);
    add(found, {x, y, 0}, {x, y, 0.01}, -1e-4 - 0.05 * std::abs(x), 0.02, i);
  }
  for (std::uint64_t i = 300; i < 700; ++i) {
    const double angle = dice(0, 6.28);
    add(found, {0.1 * std::cos(angle), 0.1 * std::sin(angle), 0}, {0, 0, 1}, dice(1e-4, 2e-3), 0.02, i);
  }
  ContactReduction reduction(128, 700);
  ContactSet set;
  reduction.reduce(found, set);
  BOOST_TEST(set.penetrating == 96);
  const Wrench all = of_all(found), kept = of_kept(set);
  BOOST_TEST(norm(all.force - kept.force) < 1e-6 * norm(all.force));
  BOOST_TEST(norm(all.torque - kept.torque) < 1e-6 * 1e-3 * norm(all.force));
}

BOOST_AUTO_TEST_CASE(a_small_motion_changes_little) {
  ContactReduction reduction(64, 2000);
  ContactSet set;
  std::set<std::pair<double, double>> before;
  Wrench last;
  int swapped = 0, steps = 0;
  double largest_step = 0, largest_error = 0, largest = 0;
  for (int step = 0; step < 1000; ++step) {
    // 20 um a step sideways, and slowly up and down.
    const FoundContacts found = in_bowl({2e-5 * step - 0.01, 0.001, 0}, 0.002 + 5e-4 * std::sin(0.01 * step));
    BOOST_REQUIRE(found.contact.size() > 128U);
    reduction.reduce(found, set);
    BOOST_TEST(set.count == 64);
    const Wrench now = of_kept(set), all = of_all(found);
    largest = std::max(largest, norm(now.force));
    largest_error = std::max({largest_error, norm(now.force - all.force), norm(now.torque - all.torque) / 0.02});
    const std::set<std::pair<double, double>> kept = places(set);
    if (step > 0) {
      largest_step = std::max({largest_step, norm(now.force - last.force), norm(now.torque - last.torque) / 0.02});
      for (const auto& place : kept) swapped += before.contains(place) ? 0 : 1;
      ++steps;
    }
    before = kept;
    last = now;
  }
  BOOST_TEST(largest_error < 1e-6 * largest);
  // The full set itself changes by as much: 20 um to the side of a bowl, 5 um of 2 mm in depth.
  BOOST_TEST(largest_step < 0.02 * largest);
  // A lattice point goes by every 100 steps for each of the rim's contacts.
  BOOST_TEST(swapped < 0.02 * 64 * steps);
}

BOOST_AUTO_TEST_CASE(nothing_flickers_at_the_bound) {
  // One contact more than there is room for, its depth trembling about that of the others.
  ContactReduction reduction(16, 17);
  ContactSet set;
  std::set<std::pair<double, double>> first;
  test::Dice dice(5);
  for (int step = 0; step < 100; ++step) {
    FoundContacts found;
    for (int i = 0; i < 17; ++i) {
      add(found, {0.01 * (i % 5), 0.01 * static_cast<int>(i / 5), 0}, {0, 0, 1}, -1e-3 + dice(-1e-4, 1e-4), 0.1,
          static_cast<std::uint64_t>(i));
    }
    reduction.reduce(found, set);
    if (step == 0) first = places(set);
    BOOST_TEST((places(set) == first));
  }
}

BOOST_AUTO_TEST_CASE(opposite_walls_and_different_bodies_keep_their_own) {
  FoundContacts found;
  test::Dice dice(5);
  for (std::uint64_t i = 0; i < 600; ++i) {
    // A peg between two walls, the same again for another pair that pushes elsewhere.
    const double side = i % 2 == 0 ? 1 : -1;
    const ContactPair pair{i % 3 == 0 ? 1 : 0, ContactPair::fixed};
    add(found, {side * 0.005, dice(-0.01, 0.01), dice(-0.03, 0.03)}, {-side, dice(-0.1, 0.1), dice(-0.1, 0.1)},
        dice(-2e-4, -1e-5) * (side > 0 ? 1 : 2), 0.1, i, pair);
  }
  ContactReduction reduction(100, 600);
  ContactSet set;
  reduction.reduce(found, set);
  for (const std::int32_t body : {0, 1}) {
    const Wrench all = of_all(found, body), kept = of_kept(set, body);
    BOOST_TEST(norm(all.force) > 0);
    BOOST_TEST(norm(all.force - kept.force) < 1e-6 * norm(all.force));
    BOOST_TEST(norm(all.torque - kept.torque) < 1e-6 * norm(all.torque));
    // What presses from either side stays, too, nearly: the wrench alone is restored exactly.
    for (const double side : {1.0, -1.0}) {
      const auto pressing = [&](const auto& contact, const auto& pair, std::size_t count) {
        double sum = 0;
        for (std::size_t i = 0; i < count; ++i) {
          if (pair[i].body == body && side * contact[i].p_WC.x > 0) sum -= contact[i].weight * contact[i].distance;
        }
        return sum;
      };
      const double before = pressing(found.contact, found.pair, found.contact.size());
      BOOST_TEST(pressing(set.contact, set.pair, static_cast<std::size_t>(set.count)) == before, tt::tolerance(0.15));
    }
  }
}

BOOST_AUTO_TEST_CASE(contacts_that_do_not_touch_fill_the_rest_nearest_first_and_give_nothing) {
  FoundContacts found;
  test::Dice dice(5);
  std::vector<double> distances;
  for (std::uint64_t i = 0; i < 100; ++i) {
    const double distance = i < 10 ? -1e-4 : dice(0, 1e-3);
    add(found, {dice(-0.1, 0.1), dice(-0.1, 0.1), 0}, {0, 0, 1}, distance, 0.3, i);
    if (i >= 10) distances.push_back(distance);
  }
  std::sort(distances.begin(), distances.end());
  ContactReduction reduction(40, 100);
  ContactSet set;
  reduction.reduce(found, set);
  BOOST_TEST(set.count == 40);
  BOOST_TEST(set.penetrating == 10);
  BOOST_TEST(set.truncated == 60);
  for (int i = 0; i < set.count; ++i) {
    const Contact& c = set.contact[static_cast<std::size_t>(i)];
    BOOST_TEST(c.weight == 0.3);
    BOOST_TEST(c.distance <= distances[29]);
  }
}

BOOST_AUTO_TEST_CASE(contacts_at_one_place_are_kept_once_each) {
  FoundContacts found;
  for (std::uint64_t i = 0; i < 60; ++i)
    add(found, {0, 0, 0}, {0, 0, 1}, -1e-3, 0.1 + 0.001 * static_cast<double>(i), i);
  // Nothing reads this, so that it tells which is which.
  for (std::size_t i = 0; i < 60; ++i) found.contact[i].damping = static_cast<double>(i);
  ContactReduction reduction(20, 60);
  ContactSet set;
  reduction.reduce(found, set);
  BOOST_TEST(set.count == 20);
  BOOST_TEST(norm(of_kept(set).force) == norm(of_all(found).force), tt::tolerance(1e-9));
  std::set<double> sources;
  for (std::size_t i = 0; i < 20; ++i) sources.insert(set.contact[i].damping);
  BOOST_TEST(sources.size() == 20U);
}

BOOST_AUTO_TEST_CASE(fixed_bodies_of_unlike_stiffness_keep_their_forces) {
  // A hard disc in a soft ring, both fixed, as one patch of 900 points.
  for (const double disc : {0.004, 0.009}) {
    FoundContacts found;
    for (const bool hard : {true, false}) {
      for (std::uint64_t i = 0; i < 900; ++i) {
        const Vec3 p{1e-3 * (static_cast<double>(i % 30) - 14.5), 1e-3 * (static_cast<double>(i / 30) - 14.5), 0};
        if ((norm(p) < disc) != hard) continue;
        add(found, p, {0, 0, 1}, -1e-3, 0.01, i, {}, hard ? 5000 : 50, hard ? 0 : 1);
      }
    }
    for (const int most : {128, 64, 16}) {
      ContactReduction reduction(most, 900);
      ContactSet set;
      reduction.reduce(found, set);
      const Wrench all = of_all(found), kept = of_kept(set);
      BOOST_TEST(norm(kept.force - all.force) < 1e-6 * norm(all.force), "of " << most << " in a disc of " << disc);
      BOOST_TEST(norm(kept.torque - all.torque) < 1e-6 * 0.01 * norm(all.force));
    }
  }
}

BOOST_AUTO_TEST_CASE(the_same_history_gives_the_same_bytes) {
  ContactReduction a(50, 2000), b(50, 2000);
  ContactSet set_a, set_b;
  for (int step = 0; step < 20; ++step) {
    const FoundContacts found = in_bowl({1e-4 * step, 0, 0}, 0.002);
    a.reduce(found, set_a);
    b.reduce(found, set_b);
    BOOST_REQUIRE(set_a.count == set_b.count);
    for (std::size_t i = 0; i < static_cast<std::size_t>(set_a.count); ++i) {
      BOOST_TEST(set_a.contact[i].weight == set_b.contact[i].weight);
      BOOST_TEST((set_a.contact[i].p_WC == set_b.contact[i].p_WC));
    }
  }
}

BOOST_AUTO_TEST_SUITE_END()
