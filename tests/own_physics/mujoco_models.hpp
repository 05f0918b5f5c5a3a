// Models of MuJoCo for tests, and the precondition of tests that step them.
#pragma once

#include <boost/test/unit_test.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "framework/core/temporary_folder.hpp"
#include "nodes/physics/engine/mujoco_plugin.hpp"

namespace tactor::test {

/// Skips a test where this build has no MuJoCo, and tells its name.
struct NeedsMujoco {
  boost::test_tools::assertion_result operator()(boost::unit_test::test_unit_id id) const {
    boost::test_tools::assertion_result result(has_mujoco_plugin());
    if (!result) {
      const auto& test = boost::unit_test::framework::get(id, boost::unit_test::TUT_ANY);
      std::fprintf(stderr, "skipped: %s: this build has no MuJoCo\n", test.full_name().c_str());
      result.message() << "this build has no MuJoCo";
    }
    return result;
  }
};

inline const std::string slides = R"(<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>
  <joint type="slide" axis="0 0 1"/>)";

/// A ball of 50 g and a radius of 10 mm at `place`, whose centre is `off` from the origin of its body.
inline std::string ball(const std::string& joints, const std::string& place = "0 0 0",
                        const std::string& off = "0 0 0") {
  return "<body name=\"tool\" pos=\"" + place + "\">" + joints +
         "<geom type=\"sphere\" size=\"0.01\" mass=\"0.05\" pos=\"" + off + "\"/></body>";
}

/// A file with a model, in a folder that this process alone has.
inline std::filesystem::path model_file(const std::string& world, const std::string& head = "",
                                        const std::string& tail = "") {
  static const TemporaryFolder folder;
  static int count = 0;
  const std::filesystem::path path = folder.path() / ("model_" + std::to_string(count++) + ".xml");
  std::ofstream(path) << "<mujoco>" << head << "<worldbody>" << world << "</worldbody>" << tail << "</mujoco>";
  return path;
}

inline const std::string weightless = R"(<option gravity="0 0 0"/>)";
inline const std::string plane = R"(<geom name="ground" type="plane" size="1 1 0.1"/>)";

inline std::unique_ptr<CoupledEngine> engine_of(const std::filesystem::path& file, const std::string& keyframe = "") {
  return load_mujoco_plugin("a test").engine({.file = file, .tool = "tool", .keyframe = keyframe, .bodies = {}});
}

inline const CouplingParameters stiff{
    .k_t = 1000, .b_t = 14, .k_r = 1, .b_r = 0.004, .force_max = 8, .torque_max = 0.3};

}  // namespace tactor::test
