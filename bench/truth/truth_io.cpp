#include "truth_io.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <sstream>
#include <utility>

namespace truth {

namespace {

using nlohmann::json;

Pose read_pose(Keys keys) {
  Pose pose;
  if (keys.has("p")) pose.p = Vector3d(keys.numbers("p", 3).data());
  if (keys.has("quaternion")) {
    const std::vector<double> q = keys.numbers("quaternion", 4);
    pose.R = Quaterniond(q[0], q[1], q[2], q[3]);
    if (std::abs(pose.R.norm() - 1) > 1e-6) keys.refuse("quaternion", "expected a unit quaternion w x y z");
    pose.R.normalize();
  }
  keys.done();
  return pose;
}

Shape read_shape(Keys keys, const std::filesystem::path& scene) {
  Shape shape = Plane{};
  int found = 0;
  if (keys.has("sphere")) {
    ++found;
    Keys k = keys.object("sphere");
    shape = Sphere{k.positive("radius")};
    k.done();
  }
  if (keys.has("capsule")) {
    ++found;
    Keys k = keys.object("capsule");
    shape = Capsule{k.positive("radius"), k.positive("length")};
    k.done();
  }
  if (keys.has("box")) {
    ++found;
    Keys k = keys.object("box");
    Box box{Vector3d(k.numbers("size", 3).data())};
    if (!(box.size.minCoeff() > 0)) k.refuse("size", "expected three numbers above 0");
    shape = box;
    k.done();
  }
  if (keys.has("plane")) {
    ++found;
    keys.object("plane").done();
  }
  if (keys.has("mesh")) {
    ++found;
    Keys k = keys.object("mesh");
    Mesh mesh{scene.parent_path() / k.text("file"), 1};
    if (k.has("scale")) mesh.scale = k.positive("scale");
    if (!std::filesystem::exists(mesh.file)) k.refuse("file", "there is no file " + mesh.file.string());
    shape = mesh;
    k.done();
  }
  keys.done();
  if (found != 1) keys.refuse("", "expected one of sphere, capsule, box, plane, mesh");
  return shape;
}

Coupling read_coupling(Keys keys, bool rotates) {
  Coupling c;
  c.k_t = keys.positive("k_t");
  c.b_t = keys.not_negative("b_t");
  if (rotates || keys.has("k_r")) c.k_r = keys.not_negative("k_r");
  if (rotates || keys.has("b_r")) c.b_r = keys.not_negative("b_r");
  if (keys.has("force_max")) c.force_max = keys.not_negative("force_max");
  if (keys.has("torque_max")) c.torque_max = keys.not_negative("torque_max");
  keys.done();
  return c;
}

void read_tool(Keys keys, Scene& scene) {
  scene.tool = read_shape(keys.object("shape"), scene.file);
  if (std::holds_alternative<Plane>(scene.tool) || std::holds_alternative<Mesh>(scene.tool)) {
    keys.refuse("shape", "expected a sphere, a capsule or a box");
  }
  const std::string motion = keys.text("motion");
  if (motion != "rigid" && motion != "translation") keys.refuse("motion", "expected rigid or translation");
  scene.rotates = motion == "rigid";
  scene.mass = keys.positive("mass");
  if (scene.rotates || keys.has("inertia")) {
    scene.inertia_T = Vector3d(keys.numbers("inertia", 3).data());
    if (!(scene.inertia_T.minCoeff() > 0)) keys.refuse("inertia", "expected three numbers above 0");
  }
  scene.starts_at_handle = !keys.has("pose");
  if (!scene.starts_at_handle) scene.X_WT = read_pose(keys.object("pose"));
  keys.done();
}

Vector3d limited(const Vector3d& v, double most) {
  const double norm = v.norm();
  return most > 0 && norm > most ? Vector3d(v * (most / norm)) : v;
}

double number_of(const std::string& cell, const std::string& place) {
  std::size_t used = 0;
  double value = 0;
  try {
    value = std::stod(cell, &used);
  } catch (const std::exception&) {
    throw InputError(place + ": expected a number, found \"" + cell + "\"");
  }
  if (used != cell.size() || !std::isfinite(value)) {
    throw InputError(place + ": expected a number, found \"" + cell + "\"");
  }
  return value;
}

constexpr const char* motion_columns = "t,px,py,pz,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz";

Quaterniond turned_by(const Vector3d& arc) {
  const double angle = arc.norm();
  return angle > 0 ? Quaterniond(Eigen::AngleAxisd(angle, arc / angle)) : Quaterniond::Identity();
}

struct Curve {
  Vector3d value, rate;
};
Curve hermite(const Vector3d& y0, const Vector3d& m0, const Vector3d& y1, const Vector3d& m1, double dt, double s) {
  const double r = 1 - s;
  return {y0 * (r * r * (1 + 2 * s)) + y1 * (s * s * (3 - 2 * s)) + dt * (m0 * (s * r * r) - m1 * (s * s * r)),
          (y1 - y0) * (6 * s * r / dt) + m0 * (r * (1 - 3 * s)) + m1 * (s * (3 * s - 2))};
}

}  // namespace

Keys::Keys(std::filesystem::path file, std::string path, const json& object)
    : file_(std::move(file)), path_(std::move(path)), json_(object) {
  if (!json_.is_object()) throw InputError(file_.string() + ": " + path_ + ": expected an object");
}

void Keys::refuse(const std::string& key, const std::string& why) const {
  const std::string dot = path_.empty() || key.empty() ? "" : ".";
  throw InputError(file_.string() + ": " + path_ + dot + key + ": " + why);
}

bool Keys::has(const std::string& key) {
  asked_.push_back(key);
  return json_.contains(key);
}

const json& Keys::at(const std::string& key) {
  if (!has(key)) refuse(key, "this key is missing");
  return json_.at(key);
}

double Keys::number(const std::string& key) {
  const json& value = at(key);
  if (!value.is_number()) refuse(key, "expected a number, found " + value.dump());
  return value.get<double>();
}

double Keys::positive(const std::string& key) {
  const double value = number(key);
  if (!(value > 0)) refuse(key, "expected a number above 0, found " + json_.at(key).dump());
  return value;
}

double Keys::not_negative(const std::string& key) {
  const double value = number(key);
  if (!(value >= 0)) refuse(key, "expected a number not below 0, found " + json_.at(key).dump());
  return value;
}

std::vector<double> Keys::numbers(const std::string& key, std::size_t count) {
  const json& value = at(key);
  const bool fits = value.is_array() && value.size() == count &&
                    std::all_of(value.begin(), value.end(), [](const json& v) { return v.is_number(); });
  if (!fits) refuse(key, "expected " + std::to_string(count) + " numbers, found " + value.dump());
  return value.get<std::vector<double>>();
}

std::string Keys::text(const std::string& key) {
  const json& value = at(key);
  if (!value.is_string()) refuse(key, "expected a text, found " + value.dump());
  return value.get<std::string>();
}

Keys Keys::object(const std::string& key) {
  return {file_, path_.empty() ? key : path_ + "." + key, at(key)};
}

void Keys::done() const {
  for (const auto& [key, value] : json_.items()) {
    if (std::find(asked_.begin(), asked_.end(), key) == asked_.end()) refuse(key, "there is no such key here");
  }
}

Scene read_scene(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw InputError(file.string() + ": the scene cannot be read");
  json whole;
  try {
    whole = json::parse(in);
  } catch (const json::exception& error) {
    throw InputError(file.string() + ": not JSON: " + error.what());
  }
  Scene scene;
  scene.file = file;
  Keys keys(file, "", whole);
  scene.gravity_W = Vector3d(keys.numbers("gravity", 3).data());
  read_tool(keys.object("tool"), scene);
  scene.coupling = read_coupling(keys.object("coupling"), scene.rotates);
  const json& fixed = keys.at("fixed");
  if (!fixed.is_array()) keys.refuse("fixed", "expected a list of bodies");
  for (std::size_t i = 0; i < fixed.size(); ++i) {
    Keys body(file, "fixed[" + std::to_string(i) + "]", fixed[i]);
    FixedBody b{body.text("name"), read_shape(body.object("shape"), file), {}};
    if (body.has("pose")) b.X_WB = read_pose(body.object("pose"));
    if (std::holds_alternative<Sphere>(b.shape) || std::holds_alternative<Capsule>(b.shape)) {
      body.refuse("shape", "expected a plane, a box or a mesh");
    }
    body.done();
    scene.fixed.push_back(std::move(b));
  }
  for (const char* engine : {"mujoco", "simbody"}) {
    if (keys.has(engine)) scene.engines[engine] = keys.at(engine);
  }
  keys.done();
  return scene;
}

Motion::Motion(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw InputError(file.string() + ": the motion cannot be read");
  std::string line;
  std::getline(in, line);
  if (!line.empty() && line.back() == '\r') line.pop_back();
  if (line != motion_columns) throw InputError(file.string() + ":1: expected the columns " + motion_columns);
  for (std::size_t number = 2; std::getline(in, line); ++number) {
    const std::string place = file.string() + ":" + std::to_string(number);
    if (!line.empty() && line.back() == '\r') line.pop_back();
    std::vector<double> v;
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) v.push_back(number_of(cell, place));
    if (v.size() != 14) throw InputError(place + ": expected 14 numbers, found " + std::to_string(v.size()));
    if (!t_.empty() && !(v[0] > t_.back())) throw InputError(place + ": t: the times must increase");
    State s;
    s.X.p = Vector3d(v[1], v[2], v[3]);
    s.X.R = Quaterniond(v[4], v[5], v[6], v[7]);
    if (std::abs(s.X.R.norm() - 1) > 1e-6) throw InputError(place + ": qw: expected a unit quaternion w x y z");
    s.X.R.normalize();
    s.v = Vector3d(v[8], v[9], v[10]);
    s.w = Vector3d(v[11], v[12], v[13]);
    t_.push_back(v[0]);
    sample_.push_back(s);
  }
  if (t_.size() < 2) throw InputError(file.string() + ": expected two samples or more");
}

State Motion::at(double t) const {
  if (t <= t_.front()) return sample_.front();
  if (t >= t_.back()) return sample_.back();
  const std::size_t i = static_cast<std::size_t>(std::upper_bound(t_.begin(), t_.end(), t) - t_.begin()) - 1;
  const State &a = sample_[i], &b = sample_[i + 1];
  const double dt = t_[i + 1] - t_[i], s = (t - t_[i]) / dt;
  const Curve p = hermite(a.X.p, a.v, b.X.p, b.v, dt, s);
  const Curve arc = hermite(Vector3d::Zero(), a.w, rotation_vector(b.X.R * a.X.R.conjugate()), b.w, dt, s);
  return {{p.value, turned_by(arc.value) * a.X.R}, p.rate, arc.rate};
}

Vector3d rotation_vector(const Quaterniond& q) {
  const double sign = q.w() < 0 ? -1 : 1;
  const Vector3d v = sign * q.vec();
  const double sine = v.norm();
  return sine > 0 ? Vector3d(v * (2 * std::atan2(sine, sign * q.w()) / sine)) : Vector3d::Zero();
}

Wrench coupling_wrench(const Coupling& c, const State& handle, const State& tool, bool rotates) {
  Wrench on_device;
  on_device.force = -c.k_t * (handle.X.p - tool.X.p) - c.b_t * (handle.v - tool.v);
  if (rotates) {
    on_device.torque = -c.k_r * rotation_vector(handle.X.R * tool.X.R.conjugate()) - c.b_r * (handle.w - tool.w);
  }
  return on_device;
}

Triangles read_mesh(const Mesh& mesh, int levels) {
  std::ifstream file(mesh.file);
  std::stringstream in;
  for (std::string line; std::getline(file, line);) in << line.substr(0, line.find('#')) << '\n';
  std::string magic;
  std::size_t vertices = 0, faces = 0, edges = 0;
  in >> magic >> vertices >> faces >> edges;
  if (!in || magic != "OFF") throw InputError(mesh.file.string() + ": expected an OFF file");
  Triangles found;
  for (std::size_t i = 0; i < vertices; ++i) {
    Vector3d v;
    in >> v[0] >> v[1] >> v[2];
    found.vertices.push_back(v * mesh.scale);
  }
  for (std::size_t i = 0; i < faces; ++i) {
    int corners = 0;
    std::array<int, 3> f{};
    in >> corners >> f[0] >> f[1] >> f[2];
    const bool inside =
        std::all_of(f.begin(), f.end(), [&](int v) { return v >= 0 && v < static_cast<int>(vertices); });
    if (!in || corners != 3 || !inside)
      throw InputError(mesh.file.string() + ": face " + std::to_string(i) + " is no triangle");
    std::string rest;
    std::getline(in, rest);
    found.faces.push_back(f);
  }
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<int, int>, int> middle;
    const auto middle_of = [&](int a, int b) {
      const auto [at, is_new] =
          middle.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<int>(found.vertices.size()));
      if (is_new)
        found.vertices.push_back(
            (found.vertices[static_cast<std::size_t>(a)] + found.vertices[static_cast<std::size_t>(b)]) / 2);
      return at->second;
    };
    std::vector<std::array<int, 3>> cut;
    for (const auto& [a, b, c] : found.faces) {
      const int ab = middle_of(a, b), bc = middle_of(b, c), ca = middle_of(c, a);
      for (const std::array<int, 3>& part : {std::array{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
        cut.push_back(part);
    }
    found.faces = std::move(cut);
  }
  return found;
}

Table::Table(const std::filesystem::path& file) : file_(file), out_(file) {
  if (!out_) throw InputError(file.string() + ": the table cannot be written");
  out_ << "t,fx,fy,fz,tx,ty,tz,px,py,pz,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz,contacts,cx,cy,cz\n";
}

void Table::row(double t, const Coupling& coupling, const Wrench& device, const State& tool, int contacts,
                const Vector3d& contact) {
  const Vector3d f = limited(device.force, coupling.force_max), m = limited(device.torque, coupling.torque_max);
  if (!(f.allFinite() && m.allFinite() && tool.X.p.allFinite() && tool.v.allFinite() && contact.allFinite())) {
    throw std::runtime_error("the simulation is not finite at " + std::to_string(t) + " s");
  }
  char text[32];
  const auto put = [&](double value, char after) {
    std::snprintf(text, sizeof text, "%.9g%c", value, after);
    out_ << text;
  };
  std::snprintf(text, sizeof text, "%.9f,", t);
  out_ << text;
  for (const Vector3d& v : {f, m, tool.X.p}) {
    for (int i = 0; i < 3; ++i) put(v[i], ',');
  }
  for (const double q : {tool.X.R.w(), tool.X.R.x(), tool.X.R.y(), tool.X.R.z()}) put(q, ',');
  for (const Vector3d& v : {tool.v, tool.w}) {
    for (int i = 0; i < 3; ++i) put(v[i], ',');
  }
  out_ << contacts << ',';
  for (int i = 0; i < 3; ++i) put(contact[i], i < 2 ? ',' : '\n');
}

void Table::close() {
  out_.close();
  if (!out_) throw std::runtime_error(file_.string() + ": the table cannot be written to its end");
}

double positive_argument(const std::string& name, const std::string& text) {
  const double value = number_of(text, name);
  if (!(value > 0)) throw InputError(name + ": expected a number above 0, found " + text);
  return value;
}

int run_program(int argc, char** argv, const std::string& usage, std::size_t arguments,
                void (*work)(const std::vector<std::string>&)) {
  const std::vector<std::string> given(argv + 1, argv + argc);
  if (given.size() != arguments && given.size() != arguments + 1) {
    std::fprintf(stderr, "usage: %s %s\n", argv[0], usage.c_str());
    return 2;
  }
  try {
    work(given);
    return 0;
  } catch (const InputError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}

}  // namespace truth
