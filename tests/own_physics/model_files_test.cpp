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

BOOST_AUTO_TEST_SUITE_END()
