// What the two truth programs share: the scene, the handle's motion, the spring to the handle, and the table they
// write.
//
// Frames: W world, D handle, T tool (origin at its centre of mass). SI units throughout.
#pragma once

#include <Eigen/Dense>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

namespace truth {

using Eigen::Quaterniond;
using Eigen::Vector3d;

/// The input is wrong: the message names the file and the key or line. Exit code 2.
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct Pose {
  Vector3d p = Vector3d::Zero();            ///< m
  Quaterniond R = Quaterniond::Identity();  ///< unit
};
struct State {
  Pose X;
  Vector3d v = Vector3d::Zero();  ///< m/s, in W
  Vector3d w = Vector3d::Zero();  ///< rad/s, in W
};

struct Sphere {
  double radius = 0;  ///< m
};
struct Capsule {
  double radius = 0;  ///< m
  double length = 0;  ///< m, of the segment along z, without the caps
};
struct Box {
  Vector3d size;  ///< m, whole edges
};
struct Plane {};  ///< the half-space z <= 0
struct Mesh {
  std::filesystem::path file;  ///< OFF
  double scale = 1;            ///< multiplies the file's coordinates to give metres
};
using Shape = std::variant<Sphere, Capsule, Box, Plane, Mesh>;

struct FixedBody {
  std::string name;
  Shape shape;
  Pose X_WB;
};

/// Force on the device: -k_t (p_WD - p_WT) - b_t (v_WD - v_WT). Torque likewise, with log(R_WD R_WT^T).
struct Coupling {
  double k_t = 0;         ///< N/m
  double b_t = 0;         ///< N s/m
  double k_r = 0;         ///< N m/rad
  double b_r = 0;         ///< N m s/rad
  double force_max = 0;   ///< N, by norm, of what the device gets; 0: no limit
  double torque_max = 0;  ///< N m, likewise
};

struct Scene {
  std::filesystem::path file;
  Vector3d gravity_W = Vector3d::Zero();  ///< m/s^2
  Coupling coupling;
  Shape tool;
  bool rotates = true;                    ///< false: the tool keeps its orientation and there is no torque
  double mass = 0;                        ///< kg
  Vector3d inertia_T = Vector3d::Zero();  ///< kg m^2, principal, in T
  bool starts_at_handle = true;           ///< false: the tool starts at X_WT
  Pose X_WT;
  std::vector<FixedBody> fixed;
  nlohmann::json engines;  ///< what the key of each engine holds
};

struct Wrench {
  Vector3d force = Vector3d::Zero();   ///< N
  Vector3d torque = Vector3d::Zero();  ///< N m
};

/// A JSON object whose keys are all asked for by name; `done` throws for those that were not.
class Keys {
 public:
  Keys(std::filesystem::path file, std::string path, const nlohmann::json& json);
  [[nodiscard]] bool has(const std::string& key);
  const nlohmann::json& at(const std::string& key);
  double number(const std::string& key);
  double positive(const std::string& key);
  double not_negative(const std::string& key);
  std::vector<double> numbers(const std::string& key, std::size_t count);
  std::string text(const std::string& key);
  bool boolean(const std::string& key);
  Keys object(const std::string& key);
  void done() const;
  [[noreturn]] void refuse(const std::string& key, const std::string& why) const;

 private:
  std::filesystem::path file_;
  std::string path_;
  nlohmann::json json_;
  std::vector<std::string> asked_;
};

Scene read_scene(const std::filesystem::path& file);

/// The handle's motion: cubic Hermite of position between the samples, and of the rotation vector relative to the
/// sample before. At the samples' times it is exact; between those of 1 kHz the angular velocity is that vector's rate.
class Motion {
 public:
  /// Columns t,px,py,pz,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz. Times increase.
  explicit Motion(const std::filesystem::path& file);
  [[nodiscard]] std::size_t count() const { return t_.size(); }
  [[nodiscard]] double time(std::size_t i) const { return t_[i]; }
  /// Held before the first sample and after the last.
  [[nodiscard]] State at(double t) const;

 private:
  std::vector<double> t_;
  std::vector<State> sample_;
};

Vector3d rotation_vector(const Quaterniond& q);

/// What acts on the device; the tool gets the opposite.
Wrench coupling_wrench(const Coupling& coupling, const State& handle, const State& tool, bool rotates);

/// The triangles of a mesh in metres.
struct Triangles {
  std::vector<Vector3d> vertices;
  std::vector<std::array<int, 3>> faces;
};
/// An OFF file; each face cut into 4^levels.
Triangles read_mesh(const Mesh& mesh, int levels);

/// The table a program writes: one row for each sample of the motion.
class Table {
 public:
  explicit Table(const std::filesystem::path& file);
  /// `contact` is the sum of the contacts on the tool, in W. Throws std::runtime_error where a number is not finite.
  void row(double t, const Coupling& coupling, const Wrench& device, const State& tool, int contacts,
           const Vector3d& contact);
  void close();

 private:
  std::filesystem::path file_;
  std::ofstream out_;
};

/// Calls `work` with the arguments; prints what it throws, and returns the exit code: 0, 1 or 2.
int run_program(int argc, char** argv, const std::string& usage, std::size_t arguments,
                void (*work)(const std::vector<std::string>&));
/// A number above zero out of the command line.
double positive_argument(const std::string& name, const std::string& text);

}  // namespace truth
