// What it costs to find the contacts of a rigid body with a deforming surface: all of it as physics asks, and a patch
// of it as a display asks at each tick. The body is led over the surface, in and out; the nodes move at each call.
//
//   soft_contact_bench build/release/meshes/bunny.off
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "nodes/physics/contact/soft_contacts.hpp"
#include "nodes/physics/mesh/body_mesh.hpp"

using namespace tactor;

namespace {

constexpr double side_length = 0.12;  // m, of the surface

struct Patch {
  SoftSurface surface;
  std::vector<Vec3> nodes;  // m
};

/// A square of `count` x `count` squares of two faces.
Patch patch_of(double length, int count) {
  Patch f;
  for (int j = 0; j <= count; ++j) {
    for (int i = 0; i <= count; ++i) {
      f.nodes.push_back({length * (double(i) / count - 0.5), length * (double(j) / count - 0.5), 0});
    }
  }
  const auto at = [&](int i, int j) { return j * (count + 1) + i; };
  for (int j = 0; j < count; ++j) {
    for (int i = 0; i < count; ++i) {
      f.surface.faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      f.surface.faces.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  f.surface.body.assign(f.surface.faces.size(), 0);
  f.surface.area.assign(f.surface.faces.size(), length * length / static_cast<double>(f.surface.faces.size()));
  return f;
}

/// Where the nodes are at call k: waves of 1 mm.
void wave(const std::vector<Vec3>& rest, int k, std::vector<Vec3>& nodes) {
  nodes.resize(rest.size());
  for (std::size_t i = 0; i < rest.size(); ++i) {
    nodes[i] = rest[i];
    nodes[i].z += 0.001 * std::sin(80 * rest[i].x + 0.01 * k) * std::cos(60 * rest[i].y);
  }
}

Scene scene_of(const Shape& tool) {
  Scene scene;
  Body soft, rigid;
  soft.name = "soft";
  soft.shape = BoxShape{{0.1, 0.1, 0.1}};
  soft.motion = Motion::deformable;
  rigid.name = "tool";
  rigid.shape = tool;
  rigid.motion = Motion::rigid;
  scene.bodies = {soft, rigid};
  return scene;
}

struct Times {
  double median, p99, contacts;
};

template <class Call>
Times measure(int calls, const Call& call) {
  std::vector<double> us;
  double contacts = 0;
  for (int k = 0; k < calls; ++k) {
    std::vector<SoftContact>* found = nullptr;
    const auto prepared = call.prepare(k);
    const auto begin = std::chrono::steady_clock::now();
    found = call.ask(prepared);
    const auto end = std::chrono::steady_clock::now();
    if (k < calls / 10) continue;
    us.push_back(std::chrono::duration<double, std::micro>(end - begin).count());
    contacts += static_cast<double>(found->size());
  }
  const auto at = [&](double share) {
    const auto k = static_cast<std::ptrdiff_t>(share * static_cast<double>(us.size()));
    std::nth_element(us.begin(), us.begin() + k, us.end());
    return us[static_cast<std::size_t>(k)];
  };
  return {at(0.5), at(0.99), contacts / static_cast<double>(us.size())};
}

template <class Prepare, class Ask>
struct Call {
  Prepare prepare;
  Ask ask;
};
template <class Prepare, class Ask>
Call(Prepare, Ask) -> Call<Prepare, Ask>;

void print(const std::string& name, const Times& t) {
  std::printf("%-58s %9.1f %9.1f us %6.1f contacts\n", name.c_str(), t.median, t.p99, t.contacts);
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) {
    std::fprintf(stderr, "usage: soft_contact_bench BUNNY.off\n");
    return 2;
  }
  struct Tool {
    const char* name;
    Shape shape;
    double lift;  // m, of its origin where it touches
  };
  const std::vector<Tool> tools = {{"ball of 6 mm", SphereShape{0.006}, 0.006},
                                   {"lying capsule of 4 x 30 mm", CapsuleShape{0.002, 0.03}, 0.002},
                                   {"needle of 2 x 60 mm", CapsuleShape{0.001, 0.06}, 0.031},
                                   {"box of 20 x 14 x 10 mm", BoxShape{{0.02, 0.014, 0.01}}, 0.005},
                                   {"bunny", MeshShape{arguments[1]}, 0.04}};
  std::printf("%-58s %9s %9s\n", "a call", "median", "p99");
  for (const Tool& tool : tools) {
    const bool lies = std::string(tool.name).starts_with("lying");
    const Quat turn = from_rotation_vector({lies ? 1.5707963 : 0.0, 0, 0});
    const auto pose = [&](int k) {
      const double t = 0.002 * k;
      return Pose{{0.02 * std::cos(t), 0.02 * std::sin(1.3 * t), tool.lift - 0.001 + 0.001 * std::sin(5 * t)}, turn};
    };
    const Scene scene = scene_of(tool.shape);
    std::vector<SoftContact> found;
    found.reserve(ContactSet::capacity);
    std::vector<Vec3> nodes;
    for (const int squares : {22, 50, 100}) {
      SoftContacts contacts(scene, {}, cell_distances({}, nullptr));
      const Patch all = patch_of(side_length, squares);
      contacts.set_surface(all.surface, all.nodes);
      BodyStates bodies;
      bodies.count = 1;
      print(std::string(tool.name) + " on " + std::to_string(all.surface.faces.size()) + " faces",
            measure(1000, Call{[&](int k) {
                                 wave(all.nodes, k, nodes);
                                 bodies.X_WB[0] = pose(k);
                                 return k;
                               },
                               [&](int) {
                                 contacts.find(nodes, bodies, found);
                                 return &found;
                               }}));
    }
    // 60 faces over 42 nodes.
    for (const double edge : {0.002, 0.005}) {
      SoftContactOptions options;
      options.soft_contacts = 48;
      SoftContacts contacts(scene, options, cell_distances({}, nullptr));
      Patch patch = patch_of(6 * edge, 6);
      patch.surface.faces.resize(60);
      patch.nodes.resize(42);
      int refused = 0;
      std::vector<Vec3> all_nodes;
      const Times times = measure(20'000, Call{[&](int k) {
                                                 wave(patch.nodes, k, nodes);
                                                 Pose X = pose(k);
                                                 X.p.x *= 0.2 * edge / 0.005;
                                                 X.p.y *= 0.2 * edge / 0.005;
                                                 return X;
                                               },
                                               [&](const Pose& X) {
                                                 const SoftSurface& s = patch.surface;
                                                 refused +=
                                                     contacts.find_on(s.faces, std::span(s.body).first(60),
                                                                      std::span(s.area).first(60), nodes, X, found)
                                                         ? 0
                                                         : 1;
                                                 return &found;
                                               }});
      print(std::string(tool.name) + " on a patch of 60 faces of " + std::to_string(int(1e3 * edge)) + " mm", times);
      if (refused > 0) std::printf("  %d refused\n", refused);
    }
  }
  return 0;
}
