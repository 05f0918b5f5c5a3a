// The files of a model of MuJoCo, on which results depend.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "framework/core/check.hpp"
#include "framework/core/temporary_folder.hpp"
#include "nodes/physics/engine/model_files.hpp"

BOOST_AUTO_TEST_SUITE(model_files_test)

using namespace tactor;

BOOST_AUTO_TEST_CASE(a_model_is_made_of_the_files_that_it_and_its_parts_name) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "meshes");
  const auto write = [&](const std::string& name, const std::string& text) {
    std::ofstream(folder.path() / name) << text;
  };
  write("meshes/a.stl", "a");
  write("part.xml",
        R"(<mujoco><asset><mesh name="a" file='meshes/a.stl'/></asset><include file="whole.xml"/></mujoco>)");
  write("b.png", "b");
  write("whole.xml", R"(<mujoco><compiler meshdir="meshes"/><include file="part.xml"/>
      <asset><texture file = "b.png"/><mesh file="a.stl"/><mesh file="gone.stl"/></asset></mujoco>)");
  std::vector<std::filesystem::path> files = model_files(folder.path() / "whole.xml");
  std::sort(files.begin(), files.end());
  const std::vector<std::filesystem::path> expected{folder.path() / "b.png", folder.path() / "meshes/a.stl",
                                                    folder.path() / "part.xml"};
  BOOST_TEST((files == expected));
  BOOST_CHECK_THROW(model_files(folder.path() / "none.xml"), InputError);
}

BOOST_AUTO_TEST_CASE(names_in_an_included_model_count_from_the_folders_of_the_main_one) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path() / "assets");
  std::filesystem::create_directories(folder.path() / "parts");
  const auto write = [&](const std::string& name, const std::string& text) {
    std::ofstream(folder.path() / name) << text;
  };
  write("main.xml", R"(<mujoco><include file="parts/robot.xml"/><compiler meshdir="assets"/></mujoco>)");
  write("parts/robot.xml", R"(<mujoco><asset><mesh file="t.stl"/></asset><include file="parts/hand.xml"/></mujoco>)");
  write("parts/hand.xml",
        R"(<mujoco><compiler texturedir="parts"/><asset><texture file="skin.png"/></asset></mujoco>)");
  write("assets/t.stl", "t");
  write("parts/skin.png", "s");
  std::vector<std::filesystem::path> files = model_files(folder.path() / "main.xml");
  std::sort(files.begin(), files.end());
  const std::vector<std::filesystem::path> expected{folder.path() / "assets/t.stl", folder.path() / "parts/hand.xml",
                                                    folder.path() / "parts/robot.xml",
                                                    folder.path() / "parts/skin.png"};
  BOOST_TEST((files == expected));
}

BOOST_AUTO_TEST_SUITE_END()
