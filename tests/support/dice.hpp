// Random numbers for tests, the same in every run.
#pragma once

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <boost/random/uniform_real_distribution.hpp>
#include <cstdint>

#include "framework/core/spatial.hpp"

namespace tactor::test {

class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed) {}
  double operator()(double low, double high) {
    return boost::random::uniform_real_distribution<double>(low, high)(engine_);
  }
  double normal(double sigma = 1) { return sigma * standard_(engine_); }
  Vec3 normal_vector(double sigma = 1) { return {normal(sigma), normal(sigma), normal(sigma)}; }
  Vec3 in_cube(double half) { return {(*this)(-half, half), (*this)(-half, half), (*this)(-half, half)}; }
  Pose pose(double reach, double turn) { return {in_cube(reach), from_rotation_vector(in_cube(turn))}; }

 private:
  boost::random::mt19937_64 engine_;
  boost::random::normal_distribution<double> standard_;
};

}  // namespace tactor::test
