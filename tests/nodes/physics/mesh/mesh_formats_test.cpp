// Every format gives the same points and faces, as CGAL's readers do, and a damaged file is refused with its place.
#include <boost/test/unit_test.hpp>

#include <CGAL/IO/polygon_soup_io.h>
#include <CGAL/Simple_cartesian.h>

#include <limits>
#include <sstream>

#include "framework/core/check.hpp"
#include "nodes/physics/mesh/mesh_writers.hpp"
#include "tests/nodes/physics/mesh/mesh_files.hpp"
#include "tests/support/shapes.hpp"

BOOST_AUTO_TEST_SUITE(mesh_formats_test)

using namespace tactor;
using Corners = std::vector<Vec3>;

namespace {

/// The corners of each polygon by their places, so that formats with and without indices can be compared.
std::vector<Corners> polygons_of(const PolygonSoup& soup) {
  std::vector<Corners> polygons;
  for (const auto& polygon : soup.polygons) {
    polygons.emplace_back();
    for (const std::size_t corner : polygon) polygons.back().push_back(soup.points.at(corner));
  }
  return polygons;
}

/// What CGAL's readers make of a file.
std::vector<Corners> read_by_cgal(const std::string& name, const std::string& bytes) {
  std::vector<CGAL::Simple_cartesian<double>::Point_3> points;
  std::vector<std::vector<std::size_t>> polygons;
  std::istringstream in(bytes);
  const std::string ending = name.substr(name.size() - 3);
  const bool read = ending == "off"   ? CGAL::IO::read_OFF(in, points, polygons)
                    : ending == "obj" ? CGAL::IO::read_OBJ(in, points, polygons)
                    : ending == "stl" ? CGAL::IO::read_STL(in, points, polygons)
                                      : CGAL::IO::read_PLY(in, points, polygons);
  BOOST_TEST(read);
  PolygonSoup soup;
  for (const auto& p : points) soup.points.push_back({p.x(), p.y(), p.z()});
  soup.polygons = polygons;
  return polygons_of(soup);
}

/// A body whose coordinates are exact in single precision too.
TriangleMesh exact_body() {
  TriangleMesh mesh = test::icosphere(0.05, 1);
  for (Vec3& v : mesh.vertices) {
    for (int axis = 0; axis < 3; ++axis) v[axis] = std::round(v[axis] * 1048576) / 1048576;
  }
  return mesh;
}

std::string message_for(const std::string& name, const std::string& bytes) {
  try {
    test::read_soup(name, bytes);
  } catch (const InputError& e) {
    BOOST_TEST_MESSAGE(e.what());
    return e.what();
  }
  return "no error";
}

bool says(const std::string& name, const std::string& bytes, const std::string& begin, const std::string& expected) {
  const std::string message = message_for(name, bytes);
  BOOST_TEST_INFO(message);
  return message.starts_with(name + begin) && message.find(expected) != std::string::npos;
}

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  BOOST_TEST_REQUIRE(at != std::string::npos);
  return text.replace(at, what.size(), with);
}

const std::string four = "4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
const std::string faces = "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
const std::string obj_points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
const std::string stl_face =
    "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";

}  // namespace

BOOST_AUTO_TEST_CASE(every_format_gives_the_same_polygons_as_the_mesh_and_as_another_reader) {
  const TriangleMesh mesh = exact_body();
  std::vector<Corners> expected;
  for (const auto& f : mesh.faces) {
    expected.emplace_back();
    for (const int i : f) expected.back().push_back(mesh.vertices[static_cast<std::size_t>(i)]);
  }
  for (const test::MeshFile& file : test::in_every_format(mesh)) {
    BOOST_TEST_CONTEXT(file.name) {
      const std::vector<Corners> polygons = polygons_of(test::read_soup(file.name, file.bytes));
      BOOST_TEST((polygons == expected));
      BOOST_TEST((polygons == read_by_cgal(file.name, file.bytes)));
    }
  }
}

BOOST_AUTO_TEST_CASE(points_and_polygons_keep_their_order_where_a_format_has_indices) {
  const TriangleMesh mesh = exact_body();
  for (const test::MeshFile& file : test::in_every_format(mesh)) {
    if (file.name.ends_with(".stl")) continue;
    const PolygonSoup soup = test::read_soup(file.name, file.bytes);
    BOOST_TEST((soup.points == mesh.vertices));
    for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) BOOST_TEST(soup.polygons[i][k] == static_cast<std::size_t>(mesh.faces[i][k]));
    }
  }
}

BOOST_AUTO_TEST_CASE(the_format_is_told_by_the_content_first_and_by_the_name_where_that_tells_nothing) {
  const TriangleMesh mesh = test::box({1, 1, 1});
  BOOST_TEST((mesh_format("a.stl", test::as_off(mesh)) == MeshFormat::off));
  BOOST_TEST((mesh_format("a", test::as_binary_ply(mesh)) == MeshFormat::ply));
  BOOST_TEST((mesh_format("a", test::as_ascii_stl(mesh)) == MeshFormat::stl));
  BOOST_TEST((mesh_format("a.OBJ", test::as_obj(mesh)) == MeshFormat::obj));
  BOOST_TEST((mesh_format("a.Stl", test::as_binary_stl(mesh)) == MeshFormat::stl));
  BOOST_CHECK_EXCEPTION(mesh_format("a.3ds", "MM"), InputError, [](const InputError& e) {
    return std::string(e.what()).find("a.3ds: neither the name nor the content") == 0;
  });
}

BOOST_AUTO_TEST_CASE(the_ending_of_a_name_to_write_counts_in_any_case) {
  BOOST_TEST((format_of_ending("a.PLY") == MeshFormat::ply));
  BOOST_TEST((format_of_ending("a.Off") == MeshFormat::off));
}

BOOST_AUTO_TEST_CASE(what_is_no_surface_is_left_out) {
  const PolygonSoup off = read_off("a.off",
                                   "COFF # coloured\n4 4 6\n0 0 0 255 0 0 255\n1 0 0 9 9 9 9\n\n0 1 0 1 2 3 4\n"
                                   "0 0 1 1 1 1 1 # last\n3 0 2 1 255 0 0\n3 0 1 3\n3 1 2 3\n3 0 3 2\n");
  BOOST_TEST(off.points.size() == 4U);
  BOOST_TEST((off.points[2] == Vec3{0, 1, 0}));
  BOOST_TEST(off.polygons.size() == 4U);
  // Weights, texture coordinates, normals, tabs, carriage returns, continued lines and indices from the end.
  const PolygonSoup obj =
      read_obj("a.obj",
               "v +0 0 0 1.0\r\nv 1 0 0\r\nvt 0.5 0.5\r\nvn 0 0 1\r\nv 1e0 1 0 0.5 0.5 0.5\r\n"
               "v 0 1.0E0 0\r\nusemtl red\r\nf 1/1/1\t2/1/1 \\\r\n 3//1 -1\r\nl 1 2\r\nf 1 2 3 # end");
  BOOST_TEST((obj.polygons == std::vector<std::vector<std::size_t>>{{0, 1, 2, 3}, {0, 1, 2}}));
  BOOST_TEST((obj.points[2] == Vec3{1, 1, 0}));
  const PolygonSoup stl = read_stl("a.stl",
                                   "SOLID facet\nFACET NORMAL nan nan nan\nOUTER LOOP\nVERTEX 0 0 0\nVERTEX 1 0 0\n"
                                   "VERTEX 0 1 0\nENDLOOP\nENDFACET\nENDSOLID facet\nsolid\n" +
                                       stl_face + "endsolid");
  BOOST_TEST(stl.polygons.size() == 2U);
  const PolygonSoup ply =
      read_ply("a.ply",
               "ply\r\nformat ascii 1.0\r\nobj_info x\r\nelement camera 1\r\nproperty list uint8 float32 "
               "lens\r\nelement face 1\r\nproperty uchar flags\r\nproperty list int8 uint32 vertex_index\r\n"
               "element vertex 3\r\nproperty float z\r\nproperty int16 y\r\nproperty double x\r\n"
               "end_header\r\n2 0.5 0.25\r\n7 3 0 2 1\r\n3 2 1\r\n6 5 4\r\n9 8 7\r\n");
  BOOST_TEST((ply.points[0] == Vec3{1, 2, 3}));
  BOOST_TEST((ply.polygons == std::vector<std::vector<std::size_t>>{{0, 2, 1}}));
}

BOOST_AUTO_TEST_CASE(a_broken_off_file_is_refused_with_its_line) {
  const std::string good = "OFF\n" + four;
  BOOST_TEST(message_for("a.off", good + faces) == "no error");
  BOOST_TEST(says("a.off", "", ":1:", "the header OFF, found the end of the file"));
  BOOST_TEST(says("a.off", "0FF\n", ":1:", "the header OFF, found '0FF'"));
  BOOST_TEST(says("a.off", "OFF BINARY\n", ":1:", "4 vertices or more, found 'BINARY'"));
  BOOST_TEST(says("a.off", "OFF\n-4 4 0\n", ":2:", "4 vertices or more"));
  BOOST_TEST(says("a.off", "OFF\n4 4 0\n0 0 0\n1 nan 0\n0 1 0\n0 0 1\n" + faces, ":4:", "finite coordinates"));
  BOOST_TEST(says("a.off", "OFF\n4 4 0\n0 0 0\n1 1e400 0\n0 1 0\n0 0 1\n" + faces, ":4:", "a coordinate of a vertex"));
  BOOST_TEST(says("a.off", "OFF\n4 4 0\n0 0 0\n1 x\1 0\n0 1 0\n0 0 1\n" + faces, ":4:", "of a vertex, found 'x?'"));
  BOOST_TEST(says("a.off", good + "3 0 2 1\n3 0 1 4\n" + faces, ":8:", "an index from 0 to 3, found '4'"));
  BOOST_TEST(says("a.off", good + "3 0 2 1\n3 0 1 -1\n" + faces, ":8:", "an index from 0 to 3, found '-1'"));
  BOOST_TEST(says("a.off", good + "2 0 2\n" + faces, ":7:", "a face of 3 corners or more"));
  BOOST_TEST(says("a.off", good + "3 0 2 1\n", ":8:", "the end of the file"));
  BOOST_TEST(says("a.off", good + faces + "3 0 1 2\n", ":11:", "the end of the file after 4 faces"));
  // Counts that lie take neither time nor memory.
  BOOST_TEST(
      says("a.off", "OFF\n4000000000000 4000000000000 0\n0 0 0\n", ":4:", "a coordinate of a vertex, found the end"));
  BOOST_TEST(says("a.off", good + "4000000000000 0 1 2\n", ":8:", "the index of a vertex, found the end"));
}

BOOST_AUTO_TEST_CASE(a_broken_obj_file_is_refused_with_its_line) {
  BOOST_TEST(message_for("a.obj", obj_points + "f 1 3 2\n") == "no error");
  BOOST_TEST(says("a.obj", "v 0 0\nv 1 0 0\n", ":1:", "a coordinate of a vertex, found the end of the line"));
  BOOST_TEST(says("a.obj", obj_points + "v 1 inf 0\n", ":5:", "finite coordinates"));
  BOOST_TEST(
      says("a.obj", obj_points + "f 1 2 5\n", ":5:", "an index from 1 to 4, the vertices up to here, found '5'"));
  BOOST_TEST(says("a.obj", obj_points + "f 1 2 0\n", ":5:", "found '0'"));
  BOOST_TEST(says("a.obj", obj_points + "f 1 2 -5\n", ":5:", "found '-5'"));
  BOOST_TEST(says("a.obj", obj_points + "f 1 2 3 99999999999999999999\n", ":5:", "the index of a vertex"));
  BOOST_TEST(says("a.obj", obj_points + "f 1 2\n", ":5:", "a face of 3 corners or more, found '2'"));
  BOOST_TEST(says("a.obj", obj_points + "f 1 2 3x\n", ":5:", "the index of a vertex, found '3x'"));
  BOOST_TEST(
      says("a.obj", obj_points + "curv 0 1 1 2 3\n", ":5:", "a statement of polygons (v, f, ...), found 'curv'"));
  BOOST_TEST(says("a.obj",
                  "\x7f"
                  "ELF\2\1\1",
                  ":1:", "found '?ELF?"));
}

BOOST_AUTO_TEST_CASE(a_broken_stl_file_is_refused_with_its_place) {
  BOOST_TEST(message_for("a.stl", "solid\n" + stl_face + "endsolid\n") == "no error");
  BOOST_TEST(says("a.stl", "solid\n" + stl_face, ":9:", "facet or endsolid, found the end of the file"));
  BOOST_TEST(says("a.stl", "solid\n" + stl_face + "endsolid\nfacet", ":10:", "solid or the end of the file"));
  BOOST_TEST(
      says("a.stl", "solid\n" + replaced(stl_face, "vertex 1 0 0", "vertex 1 0 nan") + "endsolid", ":5:", "finite"));
  BOOST_TEST(says("a.stl", "solid\n" + replaced(stl_face, "endloop", "vertex 0 0 0") + "endsolid", ":7:", "endloop"));
  BOOST_TEST(says("a.stl", "", ":", "the file has 0 bytes, too few for an STL file"));
  const TriangleMesh box = test::box({1, 1, 1});
  const std::string binary = test::as_binary_stl(box);
  BOOST_TEST(
      says("a.stl", binary.substr(0, binary.size() - 1), ":", "12 faces, which take 684 bytes, but the file has 683"));
  BOOST_TEST(says("a.stl", binary + "x", ":", "the file has 685"));
  std::string lying = binary;
  lying.replace(80, 4, "\xff\xff\xff\xff");
  BOOST_TEST(says("a.stl", lying, ":", "4294967295 faces"));
  std::string infinite = binary;
  infinite.replace(84 + 50 * 3 + 12 + 12, 4, test::bytes_of(std::numeric_limits<float>::infinity()));
  BOOST_TEST(says("a.stl", infinite, ":", "corner 1 of face 3 is not finite"));
}

BOOST_AUTO_TEST_CASE(a_broken_ply_file_is_refused_with_its_place) {
  const TriangleMesh box = test::box({1, 1, 1});
  const std::string ascii = test::as_ascii_ply(box), binary = test::as_binary_ply(box);
  BOOST_TEST(says("a.ply", "plx\n", ":1:", "the header ply"));
  BOOST_TEST(says("a.ply", "ply\nformat ascii 1.0\n", ":2:", "end_header"));
  BOOST_TEST(says("a.ply", "ply\nelement vertex 8\nend_header\n", ":3:", "format before end_header"));
  BOOST_TEST(
      says("a.ply", replaced(ascii, "ascii 1.0", "text 1.0"), ":2:", "binary_little_endian or binary_big_endian"));
  BOOST_TEST(says("a.ply", replaced(ascii, "1.0", "2.0"), ":2:", "version 1.0"));
  BOOST_TEST(says("a.ply", replaced(ascii, "double z", "quad z"), ":7:", "a type"));
  BOOST_TEST(says("a.ply", replaced(ascii, "double z", "double w"), ":", "a vertex must have one property z"));
  BOOST_TEST(
      says("a.ply", replaced(ascii, "vertex_indices", "corners"), ":", "a face must have one list vertex_indices"));
  BOOST_TEST(says("a.ply", replaced(ascii, "element face", "element tristrips"), ":", "one element face"));
  BOOST_TEST(says("a.ply", replaced(ascii, "list uchar", "list float"), ":10:", "a whole number as length of a list"));
  BOOST_TEST(says("a.ply", ascii + "1\n", ":32:", "the end of the file, found '1'"));
  BOOST_TEST(says("a.ply", replaced(ascii, "-0.5 255", "inf 255"), ":", "vertex 0 of 8: a coordinate is not finite"));
  BOOST_TEST(says("a.ply", replaced(ascii, "\n3 ", "\n2 "), ":", "face 0 of 12: expected 3 corners or more, found 2"));
  BOOST_TEST(says("a.ply", replaced(ascii, "\n3 0", "\n3 8"), ":", "face 0: expected an index below 8"));
  BOOST_TEST(says("a.ply", replaced(ascii, "\n3 0", "\n3 -1"), ":", "face 0 of 12: the index of a vertex is -1"));
  BOOST_TEST(says("a.ply", binary.substr(0, binary.size() - 1), ":", "face 11 of 12: the file ends here"));
  BOOST_TEST(says("a.ply", binary + "x", ":", "the file has 1 bytes more than its header says"));
  // Counts that lie take neither time nor memory.
  BOOST_TEST(
      says("a.ply", replaced(binary, "vertex 8", "vertex 999999999999"), ":", "of 999999999999: the file ends here"));
  BOOST_TEST(says(
      "a.ply", replaced(replaced(binary, "face 12", "face 999999999999"), "list uchar int", "list uint int"), ":", ""));
  BOOST_TEST(says("a.ply", "ply\nformat ascii 1.0\nelement face 99999999999999\nend_header\n", ":", "has no property"));
}

BOOST_AUTO_TEST_CASE(a_file_cut_off_anywhere_is_refused_or_says_the_same) {
  const TriangleMesh box = test::box({0.5, 0.25, 1});
  for (const test::MeshFile& file : test::in_every_format(box)) {
    const std::vector<Corners> whole = polygons_of(test::read_soup(file.name, file.bytes));
    std::size_t refused = 0;
    for (std::size_t size = 0; size < file.bytes.size(); ++size) {
      try {
        const PolygonSoup soup = test::read_soup(file.name, std::string_view(file.bytes).substr(0, size));
        // Text may lose its last digit or line end, and OBJ, which has no counts, its last faces.
        BOOST_TEST(!file.name.starts_with("binary"));
        BOOST_TEST(polygons_of(soup).size() <= whole.size());
      } catch (const InputError& e) {
        BOOST_TEST(std::string(e.what()).starts_with(file.name + ":"));
        ++refused;
      }
    }
    BOOST_TEST(refused > 0U);
    if (!file.name.ends_with(".obj")) BOOST_TEST(refused + 20 > file.bytes.size());
  }
}

BOOST_AUTO_TEST_SUITE_END()
