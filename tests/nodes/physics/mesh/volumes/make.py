#!/usr/bin/python3
"""Makes the files of this folder, by programs that know nothing of Tactor: Gmsh 4.8.4, meshio (as Debian 12 has them:
python3-gmsh, python3-meshio), and VTK 9.1 (python3-vtk9). A box of 2 x 1 x 1 with a named face below and an unnamed one above."""
import gmsh
import meshio
import vtk

gmsh.initialize()
gmsh.model.occ.addBox(0, 0, 0, 2, 1, 1)
gmsh.model.occ.synchronize()
gmsh.model.mesh.setSize(gmsh.model.getEntities(0), 1.0)
gmsh.model.addPhysicalGroup(3, [1], 7)
gmsh.model.setPhysicalName(3, 7, "all of it")
for height, group in ((0, 1), (1, 2)):
    faces = [tag for dimension, tag in gmsh.model.getEntities(2)
             if abs(gmsh.model.occ.getCenterOfMass(2, tag)[2] - height) < 1e-9]
    gmsh.model.addPhysicalGroup(2, faces, group)
gmsh.model.setPhysicalName(2, 1, "held below")
gmsh.model.mesh.generate(3)


def write(name, **options):
    for option, value in {"MshFileVersion": 4.1, "Binary": 0, "SaveParametric": 0, **options}.items():
        gmsh.option.setNumber("Mesh." + option, value)
    gmsh.write(name)


write("gmsh_text.msh")
write("gmsh_binary.msh", Binary=1)
write("gmsh_parametric.msh", Binary=1, SaveParametric=1)
write("gmsh_old.msh", MshFileVersion=2.2)
gmsh.model.mesh.setOrder(2)
write("gmsh_second.msh")
gmsh.finalize()

read = meshio.read("gmsh_text.msh")
tetrahedra = meshio.Mesh(read.points, [("tetra", read.cells_dict["tetra"])])
for binary, name in ((False, "meshio_text.msh"), (True, "meshio_binary.msh")):
    meshio.gmsh.write(name, tetrahedra, "4.1", binary=binary)
both = meshio.Mesh(read.points, [cells for cells in read.cells if cells.type in ("tetra", "triangle")])
meshio.vtu.write("meshio_ascii.vtu", both, binary=False)
for compression, name in ((None, "meshio_base64.vtu"), ("zlib", "meshio_zlib.vtu"), ("lzma", "meshio_lzma.vtu")):
    meshio.vtu.write(name, both, binary=True, compression=compression)

reader = vtk.vtkXMLUnstructuredGridReader()
reader.SetFileName("meshio_base64.vtu")
reader.Update()
for name, mode, zlib, header, encode, little in (
        ("vtk_ascii.vtu", "Ascii", False, 32, True, True), ("vtk_binary.vtu", "Binary", False, 64, True, True),
        ("vtk_binary_zlib.vtu", "Binary", True, 64, True, True), ("vtk_appended.vtu", "Appended", False, 32, True, True),
        ("vtk_appended_zlib.vtu", "Appended", True, 64, True, True), ("vtk_raw.vtu", "Appended", False, 64, False, True),
        ("vtk_raw_zlib.vtu", "Appended", True, 32, False, True), ("vtk_big.vtu", "Binary", False, 32, True, False)):
    writer = vtk.vtkXMLUnstructuredGridWriter()
    writer.SetInputData(reader.GetOutput())
    writer.SetFileName(name)
    getattr(writer, "SetDataModeTo" + mode)()
    writer.SetCompressorTypeToZLib() if zlib else writer.SetCompressorTypeToNone()
    writer.SetHeaderTypeToUInt64() if header == 64 else writer.SetHeaderTypeToUInt32()
    writer.SetEncodeAppendedData(encode)
    writer.SetByteOrderToLittleEndian() if little else writer.SetByteOrderToBigEndian()
    writer.SetBlockSize(256)  # of several blocks
    writer.Write()
