// Other libraries' collision of two meshes, as contenders.
#pragma once

#include <cstddef>

#include "bench/collision/contender.hpp"

namespace tactor::bench {

enum class Precision { single_precision, double_precision };

/// FCL: collide() of two BVHModel<OBBRSS>, with at most `contacts` contacts; 0: whether they touch, and no more.
std::unique_ptr<Contender> make_fcl(const Pair& pair, Precision precision, std::size_t contacts);

/// ODE: dCollide() of two triangle meshes, with at most `contacts` contacts (65,535 is the most it takes). Each query
/// hands it the tool's last pose too, as its own stepping does.
std::unique_ptr<Contender> make_ode(const Pair& pair, int contacts);

/// Bullet: GImpact meshes against each other, every contact that the algorithm reports. Single precision loses
/// contacts in metres, so its world is in units of `unit` m.
std::unique_ptr<Contender> make_gimpact(const Pair& pair, double unit);

/// CGAL: pairs of faces whose boxes meet (box_intersection_d), then whether the triangles do. No depth.
std::unique_ptr<Contender> make_box_pairs(const Pair& pair);

}  // namespace tactor::bench
