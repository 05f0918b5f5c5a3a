#include "app/new/scene_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace tactor {

namespace {

struct WayPoint {
  double t;  // s
  Vec3 p;    // m
  std::string note;
};

/// Comes down outside, presses, slides to the end and back, and leaves.
std::vector<WayPoint> way_points(const NewScene& scene) {
  // The coupling pulls with 354 N/m and the contact pushes with 1800: 3 mm are 1 N, and the ball gives way by a fifth.
  // What deforms is pressed by as much as the ball's radius.
  const double depth = scene.young ? scene.radius : std::min(3e-3, 3 * scene.radius), above = 2.5 * scene.radius + 5e-3;
  const TouchPoint& first = scene.path.front();
  const auto inside = [&](const TouchPoint& at, double d) { return at.p - d * at.normal; };
  std::vector<WayPoint> points{{0, inside(first, -above), ""},
                               {0.4, inside(first, -above), ""},
                               {0.9, inside(first, 0), "touches"},
                               {1.3, inside(first, depth), "presses"},
                               {1.8, inside(first, depth), ""}};
  double t = 1.8;
  if (scene.path.size() > 1) {
    const double step = 1.5 / static_cast<double>(scene.path.size() - 1);
    for (std::size_t k = 1; k < scene.path.size(); ++k) {
      points.push_back({t += step, inside(scene.path[k], depth), k == 1 ? "slides" : ""});
    }
    for (std::size_t k = scene.path.size() - 1; k-- > 0;) {
      points.push_back({t += step, inside(scene.path[k], depth), k + 2 == scene.path.size() ? "and back" : ""});
    }
  } else {
    points.push_back({t += 0.5, inside(first, depth / 2), "lightly"});
    points.push_back({t += 0.5, inside(first, depth), ""});
  }
  points.push_back({t += 0.4, inside(first, depth), "still"});
  points.push_back({t += 0.5, inside(first, -above), "leaves"});
  return points;
}

/// To a micrometre, however far from the origin: 15 digits.
std::string millimetres(double metres) {
  const double mm = std::round(1e6 * metres) / 1e3;
  return fmt::format("{:.15g} mm", mm == 0 ? 0.0 : mm);
}

std::string vector_text(const Vec3& v) {
  return fmt::format("[{}, {}, {}]", millimetres(v.x), millimetres(v.y), millimetres(v.z));
}

/// The keys of a body that deforms.
std::string deformable_text(const NewScene& scene) {
  const Vec3& n = scene.held.n;
  return fmt::format(
      "      motion: deformable\n"
      "      young: {:g} kPa\n"
      "      poisson: 0.45\n"
      "      density: 1000 kg/m^3\n"
      "      damping: 5 ms        # stress per rate of strain, over the stiffness\n"
      "      tetrahedra: 1000     # more show finer shapes and take longer\n"
      "      fixed: {{behind: {{p: {}, n: [{:.4g}, {:.4g}, {:.4g}]}}}}   # in the body's frame: it is held there\n",
      *scene.young / 1e3, vector_text(scene.held.p - scene.p_WB), n.x, n.y, n.z);
}

/// Who computes contact and motion, and how slow that is.
std::string physics_text(const NewScene& scene) {
  if (scene.young) {
    return "  collision:\n"
           "    type: collision.auto   # left out: dynamics.deformable finds the contacts itself\n"
           "  dynamics:\n"
           "    type: dynamics.deformable\n"
           "    # How slow physics is under the virtual clock: 60 results a second. Without it a step takes no time.\n"
           "    cost: {constant: 16.7 ms}\n";
  }
  return "  collision:\n"
         "    type: collision.auto   # what suits the scene: `tactor check --explain` says which and why\n"
         "    # How slow physics is under the virtual clock: 50 to 150 results a second. Without it a step takes no "
         "time.\n"
         "    cost: {base: 6.7 ms, per_contact: 5 ms, jitter: 10 %, min: 6.7 ms, max: 20 ms}\n"
         "  dynamics:\n"
         "    type: dynamics.translation\n";
}

}  // namespace

std::string scene_text(const NewScene& scene) {
  const std::vector<WayPoint> points = way_points(scene);
  const double period = points.back().t + 0.3;
  std::string text = fmt::format(
      "# A ball touches {0}: it presses, slides and leaves. Made by `tactor new graph`; all of it may be changed.\n"
      "format: 2\n"
      "title: a ball on {0}, physics force held (prediction off)\n"
      "clock: virtual             # or `real`, to run it live\n"
      "duration: {1:.3g} s           # the motion twice, as long as a refit needs to be warm\n"
      "seed: 1\n\n"
      "scene:\n"
      "  gravity: [0, 0, 0]       # the device carries the tool's weight\n"
      "  bodies:\n"
      "    body:                  # {2} long\n",
      scene.name, 2 * period, millimetres(scene.longest));
  if (scene.mesh.empty()) {
    text += fmt::format("      box: {{size: {}}}\n", vector_text(scene.box));
  } else {
    text += fmt::format("      mesh: {}{}\n", scene.mesh, scene.mesh_note.empty() ? "" : "   # " + scene.mesh_note);
    if (scene.scale)
      text += fmt::format("      scale: {:.6g}         # what one unit of the file is, in m\n", *scene.scale);
    text += fmt::format("      pose: {{p: {}}}   # its middle at the origin\n", vector_text(scene.p_WB));
  }
  if (scene.young) text += deformable_text(scene);
  text += fmt::format(
      "      material: {{stiffness: 2 N/mm, damping: 2 N s/m, friction: 0.3}}\n"
      "    tool:\n"
      "      sphere: {{radius: {0}}}\n"
      "      motion: translation  # a ball needs no rotation\n"
      "      mass: 50 g\n"
      "      pose: {{p: {1}}}\n"
      "      material: {{stiffness: 20 N/mm, damping: 2 N s/m, friction: 0.3}}\n\n"
      "nodes:\n"
      "  trajectory:              # where the hand goes; it touches where the ball's middle is a radius from the "
      "surface\n"
      "    type: source.trajectory\n"
      "    interpolation: cubic\n"
      "    tremor_amplitude: 0.05 mm\n"
      "    repeat_after: {2:.3g} s\n"
      "    points:\n",
      millimetres(scene.radius), vector_text(points.front().p), period);
  for (const WayPoint& point : points) {
    text += fmt::format("      - {{t: {:.4g} s, x: {}, y: {}, z: {}}}{}\n", point.t, millimetres(point.p.x),
                        millimetres(point.p.y), millimetres(point.p.z), point.note.empty() ? "" : "   # " + point.note);
  }
  text +=
      "  device:\n"
      "    type: device.simulated # or a real one: docs/howto/devices.md\n"
      "    encoder_step: 10 um\n";
  text += physics_text(scene);
  text +=
      "  coupling:\n"
      "    type: coupling.adaptive\n"
      "  prediction:\n"
      "    type: prediction.hold\n"
      "  interpolation:\n"
      "    type: interpolation.none\n"
      "  metrics:\n"
      "    type: sink.metrics\n\n"
      "edges:\n"
      "  - trajectory.target -> device.target\n"
      "  - device.state -> collision.device\n"
      "  - device.state -> dynamics.device\n"
      "  - collision.contacts -> dynamics.contacts\n"
      "  - dynamics.state -> collision.state\n"
      "  - coupling.parameters -> dynamics.coupling\n"
      "  - dynamics.state -> coupling.state\n"
      "  - coupling.force -> prediction.force\n"
      "  - prediction.forecast -> interpolation.forecast\n"
      "  - interpolation.segment -> device.segment\n"
      "  - device.commanded -> metrics.commanded\n"
      "  - coupling.force -> metrics.force\n"
      "  - prediction.forecast -> metrics.forecast\n"
      "  - dynamics.state -> metrics.state\n"
      "  - device.state -> metrics.device\n\n"
      "record: [device.state, device.commanded, coupling.force";
  text += scene.young ? "]   # recording.h5\n" : ", collision.contacts]   # recording.h5\n";
  return text;
}

std::string method_text(const std::string& name, const std::string& method) {
  return fmt::format(
      "format: 2\n"
      "title: \"a ball on {}, by the method {}\"\n"
      "extends: [scene.yaml, methods/{}.yaml]   # the method comes with Tactor: graphs/methods\n",
      name, method, method);
}

}  // namespace tactor
