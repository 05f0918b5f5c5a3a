// What rollout_bench leads the rollout over: a handle's motion, and what physics makes of it.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "framework/core/messages.hpp"
#include "nodes/interpolation/rollout.hpp"
#include "nodes/physics/contact/local_contacts.hpp"

namespace tactor::bench {

/// What physics tells at one time.
struct PhysicsResult {
  BodyStates bodies;
  LocalContacts around;
  PhysicsState state;
};

struct Course {
  std::string name;
  Scene scene;
  Rollout::Params params;  ///< of the rollout that finds its contacts anew
  CouplingParameters coupling;
  std::function<DeviceState(double)> handle;  ///< by the time in s
  std::vector<PhysicsResult> results;         ///< at 0 and then every `result_period`
  std::vector<int> work;                      ///< of the contact query at each ms (see SampleTree::find)
  double contacts = 0;                        ///< that a query finds and keeps, mean
};

constexpr double result_period = 0.02;  // s

/// A box that slides to and fro over a flat mesh. Of the surface it finds about as many contacts as `contacts`, which
/// come with the results as a ring that all touch and slide in a bowl. All throw InputError where a mesh is no solid.
Course ring_course(double seconds, int contacts);

/// The same with a box of 4 cm and samples `spacing` (m) apart: so many that the work of a query is near its bound.
Course dense_course(double seconds, int contacts, double spacing);

/// The bunny over the bunny, as graphs/bunny/scene.yaml has them: pressed and slid. `motion`: its way-points.
/// Throws InputError also where the way-points cannot be read.
Course bunny_course(double seconds, const std::filesystem::path& mesh, const std::filesystem::path& motion);

}  // namespace tactor::bench
