// effect.texture and its models: what is read and refused, what lies between models, and what is added when.
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "framework/core/temporary_folder.hpp"
#include "nodes/effect/texture.hpp"
#include "nodes/prediction/autoregression.hpp"
#include "tests/nodes/effect/stage_rig.hpp"
#include "tests/support/heap_is_counted.hpp"

BOOST_AUTO_TEST_SUITE(texture_test)

using namespace tactor;
using namespace tactor::test;

namespace {

const TemporaryFolder folder;

std::filesystem::path write(const std::string& name, const std::string& text) {
  const std::filesystem::path path = folder.path() / name;
  std::ofstream(path) << text;
  return path;
}

constexpr const char* two_by_two = R"(title: two speeds and two forces
rate: 1 kHz
models:
  - {speed: 20 mm/s, force: 0.5 N, variance: 0.01, coefficients: [1.6, -0.8]}
  - {speed: 100 mm/s, force: 0.5 N, variance: 0.5, coefficients: [0.4, -0.9]}
  - {speed: 20 mm/s, force: 2 N, variance: 0.02, coefficients: [1.2, -0.5, 0.1]}
  - {speed: 100 mm/s, force: 2 N, variance: 1, coefficients: [-0.2, -0.8]}
)";

std::string error_of(const std::string& text) {
  try {
    TextureModel::read(write("bad.yaml", text));
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

Texture::Params params() {
  Texture::Params p;
  for (const ParamInfo& info : Texture::declare().params) {
    if (info.default_value) info.assign(&p, *info.default_value);
  }
  p.file = write("model.yaml", two_by_two);
  p.mass = 0.2;
  return p;
}

}  // namespace

BOOST_AUTO_TEST_CASE(at_the_models_themselves_it_is_theirs) {
  const TextureModel model = TextureModel::read(write("model.yaml", two_by_two));
  BOOST_TEST(model.rate() == 1000.0);
  const TextureState state = model.at(0.1, 2);
  const Reflection expected = *Reflection::of(std::vector<double>{-0.2, -0.8});
  for (std::size_t m = 0; m < Reflection::most_order; ++m)
    BOOST_TEST(std::abs(state.reflection.k[m] - expected.k[m]) < 1e-12);
  BOOST_TEST(std::abs(state.deviation - std::sqrt(expected.gain())) < 1e-12);
  // Beyond the ends they hold, and towards rest they fade.
  BOOST_TEST(std::abs(model.at(5, 50).deviation - state.deviation) < 1e-12);
  const double slowest = model.at(0.02, 0.5).deviation;
  BOOST_TEST(std::abs(model.at(0.01, 0.25).deviation - slowest / 4) < 1e-12);
  BOOST_TEST(model.at(0, 1).deviation == 0.0);
  BOOST_TEST(std::abs(model.at(0.06, 0.5).deviation - 0.5 * (slowest + model.at(0.1, 0.5).deviation)) < 1e-12);
}

BOOST_AUTO_TEST_CASE(every_filter_between_models_is_stable) {
  std::vector<std::filesystem::path> files{write("model.yaml", two_by_two)};
  for (const auto& entry : std::filesystem::directory_iterator(TACTOR_SOURCE_DIR "/graphs/renderers/textures")) {
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  }
  BOOST_TEST(files.size() >= 3U);
  Dice draw(2);
  for (const auto& file : files) {
    const TextureModel model = TextureModel::read(file);
    for (int n = 0; n < 3000; ++n) {
      const TextureState state = model.at(draw(0, 1.3 * model.speeds().back()), draw(0, 1.3 * model.forces().back()));
      ArFit fit;
      for (std::size_t m = 0; m < 12; ++m) {
        step_up(fit, state.reflection.k[m]);
      }
      BOOST_REQUIRE(is_stable(fit.coefficients()));
      if (n < 100) BOOST_REQUIRE(spectral_radius(fit.coefficients(), 1) < 1.0);
    }
  }
}

BOOST_AUTO_TEST_CASE(files_that_are_no_model_are_refused_with_the_place) {
  const std::string text = two_by_two;
  BOOST_TEST(error_of(text).empty());
  BOOST_TEST(error_of(replaced(text, "[1.6, -0.8]", "[1.6, -0.6]")).find(":4:") != std::string::npos);
  BOOST_TEST(error_of(replaced(text, "[1.6, -0.8]", "[1.6, -0.6]")).find("stable") != std::string::npos);
  BOOST_TEST(error_of(replaced(text, "variance: 0.01", "variance: 0")).find("models[0].variance") != std::string::npos);
  BOOST_TEST(error_of(replaced(text, "force: 2 N", "force: 3 N")).find("found none for") != std::string::npos);
  BOOST_TEST(error_of(replaced(text, "speed: 100", "speed: 20")).find("found them again") != std::string::npos);
  BOOST_TEST(error_of(replaced(text, "rate: 1 kHz\n", "")).find("rate") != std::string::npos);
  BOOST_TEST(error_of(replaced(text, "variance", "varianc")).find("varianc") != std::string::npos);
  BOOST_TEST(error_of(replaced(text, "[1.6, -0.8]", "[0.9999999999999999]")).find("at most") != std::string::npos);
  BOOST_TEST(error_of("title: x\nrate: 1 kHz\nmodels: []\n").find("models") != std::string::npos);
  BOOST_TEST(!error_of("[1, 2]").empty());
  auto p = params();
  p.rate = 500;
  BOOST_CHECK_THROW(StageRig<Texture> rig(p), InputError);
}

BOOST_AUTO_TEST_CASE(it_vibrates_while_a_tool_slides_and_else_nothing_changes) {
  StageRig<Texture> rig(params());
  for (int ms = 0; ms < 50; ++ms) BOOST_TEST(norm(rig.tick(ms, {}, {0.1, 0, 0})) == 0.0);        // in the air
  for (int ms = 50; ms < 100; ++ms) BOOST_TEST(rig.tick(ms, {0, 0, 1}, {0, 0, -0.1}).z == 1.0);  // pressing
  double squares = 0;
  for (int ms = 100; ms < 4100; ++ms) {
    const Vec3 added = rig.tick(ms, {0, 0, 2}, {0.1, 0, -0.05}) - Vec3{0, 0, 2};
    BOOST_TEST(std::abs(added.x) + std::abs(added.y) == 0.0);
    squares += added.z * added.z;
  }
  // At a model of its own: the mass times the deviation that its variance makes.
  const double expected = 0.2 * std::sqrt(Reflection::of(std::vector<double>{-0.2, -0.8})->gain());
  BOOST_TEST(std::abs(std::sqrt(squares / 4000) / expected - 1) < 0.05);
  for (int ms = 4100; ms < 4150; ++ms) BOOST_TEST(norm(rig.tick(ms, {}, {0.1, 0, 0})) == 0.0);
}

BOOST_AUTO_TEST_CASE(the_weight_of_a_tool_is_no_contact_where_physics_tells_of_contact) {
  const Vec3 weight{0, 0, -2}, side{0.1, 0, 0};
  StageRig<Texture> by_force(params());
  double most = 0;
  for (int ms = 0; ms < 50; ++ms) most = std::max(most, norm(by_force.tick(ms, weight, side) - weight));
  BOOST_TEST(most > 0.01);

  StageRig<Texture> rig(params());
  rig.touch(0, {}, {});
  for (int ms = 0; ms < 50; ++ms) BOOST_TEST(norm(rig.tick(ms, weight, side) - weight) == 0.0);
  // Normal force and normal are those of the surface, whatever is displayed.
  const Vec3 n{0, 0.6, 0.8};
  rig.touch(50, 2.0 * n, {});
  double squares = 0;
  for (int ms = 50; ms < 4050; ++ms) {
    const Vec3 added = rig.tick(ms, weight, side + Vec3{0, 0.03, 0.04}) - weight;
    BOOST_TEST(norm(added - dot(added, n) * n) < 1e-12);
    squares += dot(added, added);
  }
  const double expected = 0.2 * std::sqrt(Reflection::of(std::vector<double>{-0.2, -0.8})->gain());
  BOOST_TEST(std::abs(std::sqrt(squares / 4000) / expected - 1) < 0.05);
  rig.touch(4050, {}, {});
  for (int ms = 4050; ms < 4100; ++ms) BOOST_TEST(norm(rig.tick(ms, weight, side) - weight) == 0.0);
}

BOOST_AUTO_TEST_CASE(it_acts_along_what_it_is_told_to) {
  const Vec3 n{0, 0, 1}, t{1, 0, 0}, b{0, 1, 0};
  for (const auto& [along, axis] :
       {std::pair{Texture::Along::normal, n}, {Texture::Along::motion, t}, {Texture::Along::across, b}}) {
    auto p = params();
    p.along = along;
    StageRig<Texture> rig(p);
    double most = 0;
    for (int ms = 0; ms < 200; ++ms) {
      const Vec3 added = rig.tick(ms, 1.0 * n, 0.05 * t) - n;
      BOOST_TEST(norm(added - dot(added, axis) * axis) < 1e-12);
      most = std::max(most, std::abs(dot(added, axis)));
    }
    BOOST_TEST(most > 0.01);
  }
}

BOOST_AUTO_TEST_CASE(the_seed_makes_the_noise) {
  StageRig<Texture> a(params(), 7), b(params(), 7), c(params(), 8);
  bool differs = false;
  for (int ms = 0; ms < 100; ++ms) {
    const Vec3 force{0, 0, 1}, v{0.05, 0, 0};
    const Vec3 first = a.tick(ms, force, v);
    BOOST_TEST(norm(first - b.tick(ms, force, v)) == 0.0);
    differs = differs || norm(first - c.tick(ms, force, v)) > 0;
  }
  BOOST_TEST(differs);
}

BOOST_AUTO_TEST_CASE(the_sum_stays_within_the_device) {
  auto p = params();
  p.gain = 100;
  p.force_max = 2;
  StageRig<Texture> rig(p);
  for (int ms = 0; ms < 500; ++ms) BOOST_TEST(norm(rig.tick(ms, {0, 0, 1.5}, {0.1, 0, 0})) <= 2 + 1e-9);
  BOOST_TEST(rig.metrics()["texture.limited_ticks"] > 100.0);
}

BOOST_AUTO_TEST_CASE(a_step_does_not_call_the_heap, *boost::unit_test::precondition(tactor::test::heap_is_counted)) {
  StageRig<Texture> rig(params());
  rig.tick(0, {}, {});
  const std::int64_t before = thread_heap_calls();
  for (int ms = 1; ms < 1000; ++ms) rig.tick(ms, {0, 0, 1}, {0.001 * ms, 0, 0});
  BOOST_TEST(thread_heap_calls() - before == 0);
}

BOOST_AUTO_TEST_SUITE_END()
