// What every way of finding contacts does in the benchmark, ours and others' alike.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "nodes/physics/mesh/mesh.hpp"
#include "nodes/physics/mesh/surface_samples.hpp"

namespace tactor::bench {

/// A closed mesh in its own frame, and the points that stand for its surface where a method samples it.
struct Body {
  TriangleMesh mesh;
  std::vector<SurfaceSample> samples;
};

/// The fixed body, whose frame is A, and the tool, whose frame is B.
struct Pair {
  Body fixed, tool;
};

/// Which body's sample lies inside the other.
enum class Side { none = -1, tool = 0, fixed = 1 };

/// A contact.
struct Touch {
  Vec3 p_A;          ///< m, where
  Vec3 n_A;          ///< unit, the way in which the tool gets out
  double depth = 0;  ///< m, positive where the bodies penetrate
  /// Of a method that samples: which sample it is.
  Side side = Side::none;
  int sample = -1;
  int face = -1;  ///< of the other body, nearest to the sample
};
using Touches = std::vector<Touch>;

/// One sample of a trajectory.
struct Step {
  Pose X_AB;
  Touches exact;  ///< every sample of either body that lies inside the other, from the reference
};

/// One way of finding contacts, with its structures for one pair of bodies.
class Contender {
 public:
  virtual ~Contender() = default;
  /// Finds the contacts at step.X_AB and keeps them in its own form. This alone is timed.
  virtual void query(const Step& step) = 0;
  [[nodiscard]] virtual bool touching() const = 0;
  /// What the last query found.
  [[nodiscard]] virtual Touches touches() const = 0;
};

/// What a contender tells of a contact. `samples`: depths, of the same samples as the reference's.
enum class Gives { touching, points, depths, samples };

inline bool gives_depths(Gives gives) {
  return gives >= Gives::depths;
}

struct Entry {
  std::string name;
  Gives gives = Gives::depths;
  std::function<std::unique_ptr<Contender>(const Pair&)> make;
  bool all = true;  ///< every contact there is, and not a number of them or none
};

}  // namespace tactor::bench
