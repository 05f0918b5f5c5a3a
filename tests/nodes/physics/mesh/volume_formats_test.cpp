// Files of tetrahedra that Gmsh, meshio and VTK wrote give the same mesh, and damaged ones are refused with their
// place.
#include <cmath>
#include <filesystem>
#include <functional>

#include <boost/test/unit_test.hpp>

#include "framework/core/input_file.hpp"
#include "framework/core/value_error.hpp"
#include "nodes/physics/mesh/body_volume.hpp"
#include "nodes/physics/mesh/volume_formats.hpp"
#include "tests/nodes/physics/mesh/volume_checks.hpp"

BOOST_AUTO_TEST_SUITE(volume_formats_test)

using namespace tactor;
namespace fs = std::filesystem;
namespace tt = boost::test_tools;

namespace {

fs::path path_of(const std::string& name) {
  return fs::path(TACTOR_SOURCE_DIR) / "tests/nodes/physics/mesh/volumes" / name;
}

std::string bytes_of(const std::string& name) {
  return read_input_file(path_of(name), 1U << 20U);
}

VolumeSoup read(const std::string& name, const std::string& bytes) {
  return read_volume(name, volume_format(name), bytes);
}

/// The corners of each tetrahedron, so that files that order their nodes otherwise can be compared.
std::vector<std::array<double, 12>> corners_of_all(const VolumeSoup& soup) {
  std::vector<std::array<double, 12>> all;
  for (const auto& tet : soup.tets) {
    std::vector<std::array<double, 3>> corners;
    for (const int i : tet) {
      const Vec3& p = soup.nodes.at(static_cast<std::size_t>(i));
      // Text files round the last digits.
      const auto rounded = [](double x) { return std::round(x * 1e9) / 1e9 + 0.0; };
      corners.push_back({rounded(p.x), rounded(p.y), rounded(p.z)});
    }
    std::sort(corners.begin(), corners.end());
    all.emplace_back();
    for (std::size_t k = 0; k < 12; ++k) all.back()[k] = corners[k / 3][k % 3];
  }
  std::sort(all.begin(), all.end());
  return all;
}

std::string message_for(const std::string& name, const std::string& bytes) {
  try {
    VolumeSoup soup = read(name, bytes);
    make_volume(soup, name);
  } catch (const InputError& e) {
    BOOST_TEST_MESSAGE(e.what());
    return e.what();
  }
  return "accepted";
}

bool says(const std::string& name, const std::string& bytes, const std::string& expected) {
  const std::string message = message_for(name, bytes);
  BOOST_TEST_INFO(message);
  return message.starts_with(name + ":") && message.find(expected) != std::string::npos;
}

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  BOOST_TEST_REQUIRE(at != std::string::npos);
  return text.replace(at, what.size(), with);
}

/// A tetrahedron as each format has it; `more` goes into it.
std::string small_msh(const std::string& nodes = "1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n",
                      const std::string& elements = "1 1 1 1\n3 1 4 1\n1 1 2 3 4\n", const std::string& more = "") {
  return "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n" + more + "$Nodes\n" + nodes + "$EndNodes\n$Elements\n" + elements +
         "$EndElements\n";
}

std::string small_vtu(const std::string& points = "0 0 0 1 0 0 0 1 0 0 0 1", const std::string& corners = "0 1 2 3",
                      const std::string& offsets = "4", const std::string& types = "10",
                      const std::string& count = "1") {
  const auto array = [](const std::string& type, const std::string& name, const std::string& values) {
    return "<DataArray type=\"" + type + "\" Name=\"" + name + "\" NumberOfComponents=\"3\" format=\"ascii\">\n" +
           values + "\n</DataArray>\n";
  };
  return "<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n<Piece "
         "NumberOfPoints=\"4\" NumberOfCells=\"" +
         count + "\">\n<Points>\n" + array("Float64", "Points", points) + "</Points>\n<Cells>\n" +
         array("Int32", "connectivity", corners) + array("Int32", "offsets", offsets) + array("UInt8", "types", types) +
         "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
}

}  // namespace

BOOST_AUTO_TEST_CASE(every_way_of_writing_a_mesh_gives_the_same_tetrahedra) {
  const auto expected = corners_of_all(read("gmsh_text.msh", bytes_of("gmsh_text.msh")));
  BOOST_TEST(expected.size() == 48U);
  for (const char* name :
       {"gmsh_text.msh", "gmsh_binary.msh", "gmsh_parametric.msh", "meshio_text.msh", "meshio_binary.msh",
        "meshio_ascii.vtu", "meshio_base64.vtu", "meshio_zlib.vtu", "vtk_ascii.vtu", "vtk_binary.vtu",
        "vtk_binary_zlib.vtu", "vtk_appended.vtu", "vtk_appended_zlib.vtu", "vtk_raw.vtu", "vtk_raw_zlib.vtu"}) {
    BOOST_TEST_CONTEXT(name) {
      VolumeSoup soup = read(name, bytes_of(name));
      BOOST_TEST((corners_of_all(soup) == expected));
      const TetMesh mesh = make_volume(soup, name);
      test::check_sound(mesh);
      BOOST_TEST(quality_of(mesh).volume == 2.0, tt::tolerance(1e-9));
      BOOST_TEST(mesh.nodes.size() == 23U);
      // VTK's files have the triangles as cells.
      const bool has_triangles = std::string(name).ends_with(".vtu");
      BOOST_TEST_REQUIRE(soup.notes.size() == (has_triangles ? 1U : 0U));
      if (has_triangles) BOOST_TEST(soup.notes[0] == "16 cells of fewer than 3 dimensions were left out");
    }
  }
}

BOOST_AUTO_TEST_CASE(physical_groups_of_gmsh_name_faces_of_the_boundary) {
  for (const char* name : {"gmsh_text.msh", "gmsh_binary.msh", "gmsh_parametric.msh"}) {
    VolumeSoup soup = read(name, bytes_of(name));
    const TetMesh mesh = make_volume(soup, name);
    BOOST_TEST_REQUIRE(mesh.groups.size() == 2U);
    BOOST_TEST(mesh.groups[0].name == "held below");
    BOOST_TEST(mesh.groups[1].name == "2");
    for (const FaceGroup& group : mesh.groups) {
      const bool is_low = &group == mesh.groups.data();
      double area = 0;
      for (const auto& face : group.faces) {
        BOOST_TEST(std::count(mesh.faces.begin(), mesh.faces.end(), face) == 1);
        const auto node = [&](std::size_t k) { return mesh.nodes[static_cast<std::size_t>(face[k])]; };
        const Vec3 normal = cross(node(1) - node(0), node(2) - node(0));
        BOOST_TEST((is_low ? -normal.z : normal.z) > 0);
        area += 0.5 * norm(normal);
      }
      BOOST_TEST(area == 2.0, tt::tolerance(1e-9));
    }
  }
}

BOOST_AUTO_TEST_CASE(a_body_is_loaded_from_its_file_with_its_scale_and_held_at_named_faces) {
  Body body;
  body.name = "block";
  body.motion = Motion::deformable;
  body.shape = MeshShape{path_of("gmsh_binary.msh"), 0.05};
  body.deformable.fixed = {NamedFaces{"held below"}};
  Notes notes;
  const BodyVolume volume = load_body_volume(body, &notes);
  BOOST_TEST(quality_of(volume.mesh).volume == 2 * 0.05 * 0.05 * 0.05, tt::tolerance(1e-9));
  for (std::size_t i = 0; i < volume.fixed.size(); ++i) {
    BOOST_TEST((volume.fixed[i] == 1) == (std::abs(volume.mesh.nodes[i].z) < 1e-9));
  }
  BOOST_TEST_REQUIRE(notes.size() == 1U);
  BOOST_TEST(notes[0].starts_with("body 'block': 48 tetrahedra, 23 nodes, "));
  const auto refusal = [&] {
    try {
      load_body_volume(body);
    } catch (const ValueError& e) {
      BOOST_TEST_MESSAGE(e.what());
      return e.path() + ": " + e.what();
    }
    return std::string("accepted");
  };
  body.deformable.fixed = {NamedFaces{"above"}};
  BOOST_TEST(refusal() ==
             "scene.bodies.block.fixed: body 'block': it has no faces named 'above'; its mesh has 'held below', '2'");
  body.deformable.fixed.clear();
  body.shape = MeshShape{path_of("gmsh_binary.msh"), 1e-9};
  BOOST_TEST(refusal().starts_with("scene.bodies.block.scale: body 'block': "));
  body.shape = MeshShape{path_of("gmsh_second.msh"), 0.05};
  BOOST_TEST(refusal().find("scene.bodies.block.mesh: body 'block': " + path_of("gmsh_second.msh").string() +
                            ": section $Elements: it has a tetrahedron of second order") == 0);
  body.motion = Motion::rigid;
  body.shape = MeshShape{path_of("gmsh_binary.msh"), 0.05};
  BOOST_CHECK_EXCEPTION(load_body_mesh(body), ValueError, [](const ValueError& e) {
    return std::string(e.what()).find("a file of tetrahedra is for a body with `motion: deformable`") !=
           std::string::npos;
  });
}

BOOST_AUTO_TEST_CASE(what_is_not_read_is_told_by_name) {
  BOOST_TEST(says("a.msh", bytes_of("gmsh_old.msh"), "expected version 4.1 of Gmsh's format, found '2.2'"));
  BOOST_TEST(says("a.msh", bytes_of("gmsh_second.msh"), "it has a tetrahedron of second order"));
  BOOST_TEST(says("a.vtu", bytes_of("vtk_big.vtu"), "the bytes come from a big-endian machine"));
  BOOST_TEST(says("a.vtu", bytes_of("meshio_lzma.vtu"), "found 'vtkLZMADataCompressor'"));
  std::string big = bytes_of("gmsh_binary.msh");
  const std::size_t one = big.find(std::string("\1\0\0\0", 4));
  big.replace(one, 4, std::string("\0\0\0\1", 4));
  BOOST_TEST(says("a.msh", big, "comes from a big-endian machine"));
  BOOST_TEST(says("a.vtu", replaced(small_vtu(), "UnstructuredGrid", "PolyData"), "found 'PolyData'"));
  BOOST_TEST(says("a.vtu", small_vtu("0 0 0 1 0 0 0 1 0 0 0 1", "0 1 2 3", "4", "14"), "cell 0 is of the VTK type 14"));
  BOOST_TEST(
      says("a.msh",
           small_msh("1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n", "1 1 1 1\n3 1 7 1\n1 1 2 3 4 4\n"),
           "it has a pyramid"));
  BOOST_TEST(says("a.vtu", small_vtu("0 0 0 1 0 0 0 1 0 0 0 1", "0 1 2", "3", "5"), "the file has no tetrahedra"));
  BOOST_CHECK_THROW(volume_format("a.off"), InputError);
  BOOST_TEST(is_volume_file("A.MSH"));
  BOOST_TEST(!is_volume_file("msh"));
}

BOOST_AUTO_TEST_CASE(a_small_file_of_each_format_is_read) {
  BOOST_TEST(message_for("a.msh", small_msh()) == "accepted");
  BOOST_TEST(message_for("a.vtu", small_vtu()) == "accepted");
  // Sections and arrays of others are left out.
  BOOST_TEST(message_for("a.msh", "$Comments\n# $ anything\n$EndComments\n\n" + small_msh() +
                                      "$NodeData\n1\n$EndNodeData\n") == "accepted");
  BOOST_TEST(message_for("a.vtu", "<?xml version='1.0'?>\n<!-- a <comment> -->\n" +
                                      replaced(small_vtu(), "<Points>",
                                               "<PointData><DataArray type=\"Float32\" Name=\"u>1\">x\n"
                                               "</DataArray></PointData><Points>")) == "accepted");
}

BOOST_AUTO_TEST_CASE(tetrahedra_listed_the_other_way_round_are_turned_and_told) {
  VolumeSoup soup = read("a.vtu", small_vtu("0 0 0 1 0 0 0 1 0 0 0 1", "1 0 2 3"));
  const TetMesh mesh = make_volume(soup, "a.vtu");
  test::check_sound(mesh);
  BOOST_TEST_REQUIRE(soup.notes.size() == 1U);
  BOOST_TEST(soup.notes[0] == "1 of 1 tetrahedra listed their corners in reverse order and were turned");
}

BOOST_AUTO_TEST_CASE(flat_and_inverted_tetrahedra_are_refused_with_their_number_and_place) {
  BOOST_TEST(
      says("a.vtu", small_vtu("0 0 0 1 0 0 0 1 0 1 1 0"), "tetrahedron 0 (counted from 0) at (0.5, 0.5, 0) is flat"));
  // A node drawn through the opposite face turns the box's tetrahedra about it inside out.
  VolumeSoup soup = read("gmsh_text.msh", bytes_of("gmsh_text.msh"));
  for (Vec3& p : soup.nodes) {
    const bool is_inside = p.x > 0.1 && p.x < 1.9 && p.y > 0.1 && p.y < 0.9 && p.z > 0.1 && p.z < 0.9;
    if (is_inside) p.z += 3;
  }
  BOOST_CHECK_EXCEPTION(make_volume(soup, "a.msh"), InputError, [](const InputError& e) {
    BOOST_TEST_MESSAGE(e.what());
    return std::string(e.what()).find(
               "overlap: they lie on the same side of the face that they share (counted from 0)") != std::string::npos;
  });
}

BOOST_AUTO_TEST_CASE(damaged_gmsh_files_are_refused_with_their_place) {
  const std::string nodes = "1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
  BOOST_TEST(says("a.msh", "", "has no section $MeshFormat"));
  BOOST_TEST(says("a.msh", "OFF\n", "1: expected a section, $..., found 'OFF'"));
  BOOST_TEST(says("a.msh", "$MeshFormat\n4.1 0 8\n", "1: expected $EndMeshFormat, found the end of the file"));
  BOOST_TEST(says("a.msh", "$MeshFormat\n4.1 0 4\n$EndMeshFormat\n", "expected 8, the bytes of a number"));
  BOOST_TEST(says("a.msh", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n", "has no section $Nodes"));
  BOOST_TEST(
      says("a.msh", small_msh("1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 O\n"), "12: expected a coordinate, found 'O'"));
  BOOST_TEST(says("a.msh", small_msh("1 5 1 4\n" + nodes.substr(8)), "it says 5 nodes and lists 4"));
  BOOST_TEST(says("a.msh", small_msh("1 4 1 4\n3 1 0 4\n1\n2\n3\n3\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n"),
                  "two nodes have the number 3"));
  BOOST_TEST(
      says("a.msh", small_msh(nodes, "1 1 1 1\n3 1 4 1\n1 1 2 3 9\n"), "element 1 names a node that is not there"));
  BOOST_TEST(says("a.msh", small_msh(nodes, "1 1 1 1\n3 1 4 1\n1 1 2 3 3\n"), "element 1 names a node twice"));
  BOOST_TEST(says("a.msh", small_msh(nodes, "1 2 1 1\n3 1 4 1\n1 1 2 3 4\n"), "it says 2 elements and lists 1"));
  BOOST_TEST(says("a.msh", small_msh(nodes, "1 1 1 1\n3 1 4 1\n1 1 2 3 4 5\n"), "expected $EndElements, found '5'"));
  BOOST_TEST(says("a.msh", small_msh(nodes, "1 1 1 1\n3 1 99 1\n1 1 2 3 4\n"), "the type of elements 99 is not known"));
  BOOST_TEST(says("a.msh", small_msh(replaced(nodes, "0 1 0", "0 nan 0")), "a coordinate is not finite"));
  BOOST_TEST(says("a.msh",
                  small_msh(nodes, "1 1 1 1\n3 1 4 1\n1 1 2 3 4\n", "$PhysicalNames\n1\n2 1 held\n$EndPhysicalNames\n"),
                  "expected a name in quotes"));
  BOOST_TEST(says("a.msh", small_msh() + small_msh(), "two sections $MeshFormat"));
  BOOST_TEST(says("a.msh",
                  small_msh(nodes, "1 1 1 1\n3 1 4 1\n1 1 2 3 4\n", "$PartitionedEntities\n$EndPartitionedEntities\n"),
                  "partitioned"));
}

BOOST_AUTO_TEST_CASE(damaged_vtk_files_are_refused_with_their_place) {
  const std::string points = "0 0 0 1 0 0 0 1 0 0 0 1";
  BOOST_TEST(says("a.vtu", "", "expected the tag VTKFile, found the end of the file"));
  BOOST_TEST(says("a.vtu", "<html></html>", "1: expected the tag VTKFile, found 'html'"));
  BOOST_TEST(says("a.vtu", "<VTKFile type=\"UnstructuredGrid\"", "expected a tag that ends with >"));
  BOOST_TEST(says("a.vtu", "<VTKFile type=UnstructuredGrid>", "expected a value in quotes"));
  BOOST_TEST(says("a.vtu", "<VTKFile type=\"UnstructuredGrid\">\n</VTKFile>", "expected a tag Piece"));
  BOOST_TEST(says("a.vtu", small_vtu(points, "0 1 2 4"), "expected an index below 4, the number of points, found 4"));
  BOOST_TEST(says("a.vtu", small_vtu(points, "0 1 2 -1"), "found -1"));
  BOOST_TEST(says("a.vtu", small_vtu(points, "0 1 2 2"), "cell 0 names a point twice"));
  BOOST_TEST(says("a.vtu", small_vtu(points, "0 1 2 3", "5"), "the offset 5 is out of range"));
  BOOST_TEST(says("a.vtu", small_vtu(points, "0 1 2 3", "3"), "expected 4 corners of a tetrahedron, found 3"));
  BOOST_TEST(says("a.vtu", small_vtu(points, "0 1 2 3", "4", "10", "2"),
                  "a piece says 2 cells and has 1 offsets and 1 types"));
  BOOST_TEST(says("a.vtu", small_vtu("0 0 0 1 0 0 0 1 0"), "a piece says 4 points and has 9 coordinates"));
  BOOST_TEST(says("a.vtu", small_vtu("0 0 0 1 0 0 0 1 0 0 0 inf"), "point 3: a coordinate is not finite"));
  BOOST_TEST(says("a.vtu", small_vtu("0 0 0 1 0 0 0 1 0 0 0 l"), "6: expected a number, found 'l'"));
  BOOST_TEST(says("a.vtu", replaced(small_vtu(), "format=\"ascii\"", "format=\"hex\""), "found 'hex'"));
  BOOST_TEST(
      says("a.vtu", replaced(small_vtu(), "format=\"ascii\"", "format=\"binary\""), "data array 'Points': the data"));
  BOOST_TEST(says("a.vtu", replaced(small_vtu(), "Float64", "Complex"), "found 'Complex'"));
  const std::string packed = bytes_of("meshio_zlib.vtu");
  std::string damaged = packed;
  // In the middle of the points.
  const std::size_t at = packed.find("binary\">") + 60;
  damaged.replace(at, 8, "AAAAAAAA");
  BOOST_TEST(says("a.vtu", damaged, "data array 'Points': "));
}

BOOST_AUTO_TEST_CASE(a_file_cut_anywhere_is_refused) {
  for (const char* name :
       {"gmsh_text.msh", "gmsh_binary.msh", "meshio_zlib.vtu", "vtk_appended_zlib.vtu", "vtk_raw.vtu"}) {
    const std::string bytes = bytes_of(name);
    // What ends a file may miss: `</VTKFile>`, a line.
    for (std::size_t size = 0; size + 60 < bytes.size(); size += 7) {
      BOOST_TEST_INFO(name << " cut to " << size);
      BOOST_TEST(message_for(name, bytes.substr(0, size)).starts_with(name));
    }
  }
}

BOOST_AUTO_TEST_SUITE_END()
