// Reads files of tetrahedra in the formats that graphs name: Gmsh's MSH and VTK's unstructured grids.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "nodes/physics/mesh/tet_mesh.hpp"

namespace tactor {

/// What a file lists, in its unit and frame and in its order. Coordinates are finite, indices are in range, and the
/// corners of a tetrahedron or triangle differ; nothing else is known of the tetrahedra.
struct VolumeSoup {
  std::vector<Vec3> nodes;
  std::vector<std::array<int, 4>> tets;
  std::vector<FaceGroup> groups;
  std::vector<std::string> notes;  ///< what was left out
};

enum class VolumeFormat { msh, vtu };

/// Whether a name ends as a file of tetrahedra does: `.msh` or `.vtu`, in any case.
bool is_volume_file(const std::string& file);
/// Throws InputError, beginning with `file`, where the name ends otherwise.
VolumeFormat volume_format(const std::string& file);

/// Each reads a whole file, strictly: they throw InputError with `file` and the place where a number is none or not
/// finite, an index is out of range, or counts do not fit. They take memory in proportion to the bytes that are there.

/// Gmsh's MSH 4.1, ASCII or binary of little-endian machines: nodes, tetrahedra of 4 nodes, and triangles of 3 nodes,
/// which make a group for each physical group of surfaces. Points, lines and partitions are left out; other elements of
/// volume are refused.
VolumeSoup read_msh(const std::string& file, std::string_view bytes);
/// VTK's XML UnstructuredGrid, with data in ASCII, base64 or appended (raw or base64), uncompressed or by zlib, of
/// little-endian machines: points and cells of type VTK_TETRA. Cells of fewer dimensions are left out, others of volume
/// are refused. It has no groups.
VolumeSoup read_vtu(const std::string& file, std::string_view bytes);

VolumeSoup read_volume(const std::string& file, VolumeFormat format, std::string_view bytes);

/// The mesh that a file describes: turns tetrahedra that are listed the other way round, takes out nodes that none has,
/// and finds the boundary. Adds to `soup.notes`. Throws InputError, beginning with `file`, where there is no
/// tetrahedron, one is flat, or two overlap at the face that they share, as where an element is inverted.
TetMesh make_volume(VolumeSoup& soup, const std::string& file);

}  // namespace tactor
