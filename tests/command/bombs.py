"""Small files that announce, repeat, nest or pack far more than they hold: a member of each family of each format.

Each member is a function that returns bytes; `MEMBERS` has them by the name of their file. All are below 2 MB.
"""
import base64
import gzip
import math
import struct
import zlib

import h5py


def _msh(nodes, elements, entities="", extra=""):
    body = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n" + extra
    if entities:
        body += f"$Entities\n{entities}$EndEntities\n"
    return (body + f"$Nodes\n{nodes}$EndNodes\n$Elements\n{elements}$EndElements\n").encode()


FOUR_NODES = "1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
ONE_TET = "1 1 1 1\n3 1 4 1\n1 1 2 3 4\n"


def msh_many_groups(same):
    """Each of 20,000 triangles is a face of each of 60,000 groups, or of one group that is named 60,000 times."""
    groups = "".join(f"{1 if same else n} " for n in range(1, 60_001))
    entities = f"0 0 1 0\n1 0 0 0 1 1 1 60000 {groups}0\n"
    triangles = "".join(f"{n} 1 2 3\n" for n in range(20_000))
    return _msh(FOUR_NODES, f"1 20000 1 20000\n2 1 2 20000\n{triangles}", entities)


def msh_colliding_nodes():
    """Numbers of nodes that fall together in the tables of a usual hash, whose sizes are known."""
    count, prime = 60_000, 107_897 * 85_229
    tags = "".join(f"{prime * n}\n" for n in range(1, count + 1))
    return _msh(f"1 {count} 1 {count}\n3 1 0 {count}\n{tags}" + "0 0 0\n" * count, ONE_TET)


def msh_announced(count):
    """Counts that the file does not hold."""
    return _msh(f"{count} {count} 1 {count}\n3 1 0 {count}\n1\n", ONE_TET)


def msh_announced_groups():
    return _msh(FOUR_NODES, ONE_TET, f"0 0 1 0\n1 0 0 0 1 1 1 {2**63} 1 1 1\n")


def msh_sections():
    return _msh(FOUR_NODES, ONE_TET, extra="".join(f"$A{n}\n$EndA{n}\n" for n in range(60_000)))


def msh_names():
    return _msh(FOUR_NODES, ONE_TET, extra="$PhysicalNames\n60000\n" +
                "".join(f'2 {n} "n"\n' for n in range(60_000)) + "$EndPhysicalNames\n")


def _block(data, size=None, count=1):
    """An appended array of one kind of block, by zlib, `count` times."""
    packed = zlib.compress(data, 9)
    return struct.pack(f"<{3 + count}I", count, size or len(data), size or len(data), *[len(packed)] * count) + packed * count


def _vtu(pieces, appended=b"", compressor=True, inline=""):
    head = '<VTKFile type="UnstructuredGrid" byte_order="LittleEndian" header_type="UInt32"'
    head += ' compressor="vtkZLibDataCompressor"' if compressor else ""
    return (f"{head}><UnstructuredGrid>{inline}{pieces}</UnstructuredGrid>".encode() +
            (b'<AppendedData encoding="raw">_' + appended + b"</AppendedData>" if appended else b"") + b"</VTKFile>")


def _piece(points, cells, offsets, types="UInt8", number="Float64"):
    at = [f'format="appended" offset="{offset}"' for offset in offsets]
    return (f'<Piece NumberOfPoints="{points}" NumberOfCells="{cells}"><Points><DataArray type="{number}" '
            f'NumberOfComponents="3" {at[0]}/></Points><Cells><DataArray type="Int8" Name="connectivity" {at[1]}/>'
            f'<DataArray type="Int8" Name="offsets" {at[2]}/><DataArray type="{types}" Name="types" {at[3]}/></Cells></Piece>')


def vtu_packed(blocks, pieces):
    """Zeros that pack a thousandfold, in each of many pieces that all name the same bytes."""
    data = _block(bytes(1 << 20), count=blocks)
    count = blocks << 20
    return _vtu(_piece(count // 24, count, (0, 0, 0, 0)) * pieces, data)


def vtu_vertices(pieces):
    """The same in cells that are left out."""
    cells = 1 << 22
    points, types = _block(bytes(24)), _block(b"\x01" * cells)
    zeros = _block(bytes(cells))
    appended = points + zeros + types
    piece = _piece(1, cells, (0, 0 + len(points), len(points), len(points) + len(zeros)))
    return _vtu(piece * pieces, appended)


def vtu_empty_blocks():
    """Headers of 50,000 blocks without content, named by each of 300 pieces."""
    empty = zlib.compress(b"")
    header = struct.pack("<50003I", 50_000, 0, 0, *[len(empty)] * 50_000) + empty * 50_000
    point, zero, vertex = _block(bytes(24)), _block(b"\0"), _block(b"\1")
    at = (0, len(point + zero + vertex), len(point), len(point + zero))
    return _vtu(_piece(1, 1, at) * 300, point + zero + vertex + header)


def vtu_announced(count):
    return _vtu(_piece(count, count, (0, 0, 0, 0)), struct.pack("<4I", 2**32 - 1, 2**32 - 1, 2**32 - 1, 2**32 - 1))


def vtu_same_raw():
    """Uncompressed, but named 4 times by each of 3,000 pieces, as numbers of one byte that become eight."""
    data = struct.pack("<I", 192_000) + bytes(192_000)
    return _vtu(_piece(8_000, 192_000, (0, 0, 0, 0)) * 3_000, data, compressor=False)


def vtu_base64():
    text = base64.b64encode(struct.pack("<I", 2**31)) + b"A" * 400_000
    array = f'<DataArray type="Float64" NumberOfComponents="3" format="binary">{text.decode()}</DataArray>'
    return _vtu(f'<Piece NumberOfPoints="9" NumberOfCells="1"><Points>{array}</Points></Piece>', compressor=False)


def vtu_pieces():
    return _vtu('<Piece NumberOfPoints="0" NumberOfCells="0"/>' * 40_000, compressor=False)


def vtu_nested():
    return _vtu("<Points>" * 200_000, compressor=False)


def vtu_keys():
    keys = " ".join(f'k{n}="1"' for n in range(100_000))
    return _vtu(f"<Piece {keys}/>", compressor=False)


def ply(header, body=b"", coding="ascii"):
    return f"ply\nformat {coding} 1.0\n{header}end_header\n".encode() + body


VERTEX = "property float x\nproperty float y\nproperty float z\n"
FACE = "property list uchar int vertex_indices\n"


def ply_announced(count):
    return ply(f"element vertex {count}\n{VERTEX}element face {count}\n{FACE}", b"0 0 0\n")


def ply_long_list():
    return ply(f"element vertex 3\n{VERTEX}element face 1\nproperty list uint int vertex_indices\n",
               struct.pack("<9fI", *range(9), 2**32 - 1) + bytes(4_000), "binary_little_endian")


def ply_properties():
    return ply("element vertex 1\n" + VERTEX + "".join(f"property char p{n}\n" for n in range(60_000)) +
               f"element face 1\n{FACE}", b"0 " * 60_003)


def ply_elements():
    return ply("".join(f"element e{n} {2**62}\nproperty char p\n" for n in range(40_000)) +
               f"element vertex 3\n{VERTEX}element face 1\n{FACE}")


def ply_empty_lists():
    """Faces that take one byte each."""
    return ply(f"element vertex 3\n{VERTEX}element nothing 1000000\nproperty list uchar char p\nelement face 1\n{FACE}",
               struct.pack("<9f", *range(9)) + bytes(1_000_000) + struct.pack("<B3i", 3, 0, 1, 2), "binary_little_endian")


def ply_small_faces():
    return ply(f"element vertex 3\n{VERTEX}element face 400000\nproperty list uchar uchar vertex_indices\n",
               struct.pack("<9f", *range(9)) + b"\x03\x00\x01\x02" * 400_000, "binary_little_endian")


def off(counts, body):
    return f"OFF\n{counts} 0\n{body}".encode()


def off_announced(count):
    return off(f"{count} {count}", "0 0 0\n")


def off_corners():
    return off("4 4", "0 0 0\n1 0 0\n0 1 0\n0 0 1\n" + f"{2**62} 0 1 2\n" * 4)


def off_polygon(corners):
    """One polygon of all points, which something has to cut into triangles."""
    points = "".join(f"{n % 1000} {n // 1000} {n * 7 % 13}\n" for n in range(corners))
    return off(f"{corners} 4", points + f"{corners} " + " ".join(map(str, range(corners))) + "\n3 0 1 2\n3 0 2 1\n3 1 2 3\n")


def off_prism(corners, step=1):
    """A closed prism whose ends have so many corners each; stars where the step is larger, with crossings by the square."""
    around = [(math.cos(2 * math.pi * n * step / corners), math.sin(2 * math.pi * n * step / corners)) for n in range(corners)]
    points = "".join(f"{x:.7f} {y:.7f} {z}\n" for z in (0, 1) for x, y in around)
    sides = "".join(f"4 {n} {(n + 1) % corners} {corners + (n + 1) % corners} {corners + n}\n" for n in range(corners))
    ends = [range(corners - 1, -1, -1), range(corners, 2 * corners)]
    return off(f"{2 * corners} {corners + 2}", points + sides + "".join(f"{corners} {' '.join(map(str, end))}\n" for end in ends))


def off_cone(faces):
    """A closed double cone: so many faces meet at each end, and each pair of them is looked at."""
    around = "".join(f"{math.cos(2 * math.pi * n / faces):.7f} {math.sin(2 * math.pi * n / faces):.7f} 0\n" for n in range(faces))
    sides = "".join(f"3 0 {2 + n} {2 + (n + 1) % faces}\n3 1 {2 + (n + 1) % faces} {2 + n}\n" for n in range(faces))
    return off(f"{faces + 2} {2 * faces}", "0 0 1\n0 0 -1\n" + around + sides)


def off_needles(count):
    """Thin tetrahedra along the diagonal: none touches another, and the boxes of all faces overlap."""
    points, sides = [], []
    for n in range(count):
        x, y = n % 100 / 5_000, n // 100 / 5_000
        points += [f"{x:.5f} {y - x:.5f} {-y:.5f}", f"{x + 1:.5f} {y - x + 1:.5f} {1 - y:.5f}",
                   f"{x + 1e-4:.5f} {y - x:.5f} {-y:.5f}", f"{x:.5f} {y - x + 1e-4:.5f} {-y:.5f}"]
        sides += [f"3 {4 * n + i} {4 * n + j} {4 * n + k}" for i, j, k in ((0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2))]
    return off(f"{4 * count} {4 * count}", "\n".join(points + sides) + "\n")


def off_same_faces():
    return off("4 100000", "0 0 0\n1 0 0\n0 1 0\n0 0 1\n" + "3 0 1 2\n" * 100_000)


def obj_polygon():
    return b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf" + b" 1 2 3 4" * 100_000 + b"\n"


def obj_same_faces():
    return b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n" + b"f 1 2 3\n" * 100_000


def obj_line():
    return b"v 0 0 0\n#" + b"a" * 1_000_000 + b"\n" + b"\\\n" * 200_000


def stl_announced():
    return bytes(80) + struct.pack("<I", 2**32 - 1) + bytes(50)


def stl_same_faces():
    return bytes(80) + struct.pack("<I", 30_000) + (struct.pack("<12f", *range(12)) + b"\0\0") * 30_000


def stl_solids():
    return b"solid a\nendsolid a\n" * 50_000


def yaml_billion():
    lines = ["a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1]"]
    return ("\n".join(lines + [f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]" for n in range(1, 12)]) + "\n").encode()


def yaml_long_text():
    """A text of 400 kB that 60,000 aliases repeat: few values, and gigabytes."""
    return ("title: &t " + "x" * 400_000 + "\nnodes: [" + "*t, " * 60_000 + "]\n").encode()


def yaml_anchored_nest():
    """Each level of a nest has a name, so that each value is kept once a level."""
    return ("nodes: " + "".join(f"&a{n} [" for n in range(60)) + "1, " * 90_000 + "]" * 60 + "\n").encode()


def yaml_long_key():
    return ("nodes: {" + "k" * 300_000 + ": &a [" + "1, " * 50 + "]}\nedges: [" + "*a, " * 1_500 + "]\n").encode()


def yaml_nested(text):
    return ("nodes: " + text * 200_000 + "\n").encode()


def csv_packed(row, rows):
    return gzip.compress(b"t_s,F_N\n" + row * rows, 9, mtime=0)


def csv_wide():
    return b",".join(b"c%d_N" % n for n in range(100_000)) + b"\n"


MESHES = {
    "announced.off": lambda: off_announced(2**62), "more.off": lambda: off_announced(10**9), "corners.off": off_corners,
    "polygon.off": lambda: off_polygon(30_000), "same.off": off_same_faces,
    "prism.off": lambda: off_prism(10_000), "wide_prism.off": lambda: off_prism(25_000), "cone.off": lambda: off_cone(30_000),
    "needles.off": lambda: off_needles(10_000), "star.off": lambda: off_prism(10_007, 4_001),
    "polygon.obj": obj_polygon, "same.obj": obj_same_faces, "line.obj": obj_line,
    "announced.stl": stl_announced, "same.stl": stl_same_faces, "solids.stl": stl_solids,
    "announced.ply": lambda: ply_announced(2**63), "more.ply": lambda: ply_announced(4 * 10**9), "list.ply": ply_long_list,
    "properties.ply": ply_properties, "elements.ply": ply_elements, "empty.ply": ply_empty_lists, "small.ply": ply_small_faces,
}
# Those of them whose check would go on for minutes.
SLOW = {"wide_prism.off", "cone.off", "needles.off"}
VOLUMES = {
    "groups.msh": lambda: msh_many_groups(False), "named_twice.msh": lambda: msh_many_groups(True),
    "colliding.msh": msh_colliding_nodes, "announced.msh": lambda: msh_announced(2**63), "more.msh": lambda: msh_announced(10**9),
    "announced_groups.msh": msh_announced_groups, "sections.msh": msh_sections, "names.msh": msh_names,
    "packed.vtu": lambda: vtu_packed(32, 1), "packed_often.vtu": lambda: vtu_packed(8, 100), "vertices.vtu": lambda: vtu_vertices(400),
    "blocks.vtu": vtu_empty_blocks, "announced.vtu": lambda: vtu_announced(2**63), "raw.vtu": vtu_same_raw, "base64.vtu": vtu_base64,
    "pieces.vtu": vtu_pieces, "nested.vtu": vtu_nested, "keys.vtu": vtu_keys,
}
GRAPHS = {
    "billion.yaml": yaml_billion, "text.yaml": yaml_long_text, "anchors.yaml": yaml_anchored_nest, "key.yaml": yaml_long_key,
    "lists.yaml": lambda: yaml_nested("["), "maps.yaml": lambda: yaml_nested("{a: "), "dashes.yaml": lambda: yaml_nested("- "),
    "questions.yaml": lambda: yaml_nested("? "), "anchored.yaml": lambda: yaml_nested("&a "),
}
TABLES = {
    "rows.csv.gz": lambda: csv_packed(b"0,0\n", 20_000_000), "blanks.csv.gz": lambda: csv_packed(b"0,0" + b" " * 500_000 + b"\n", 2_000),
    "line.csv.gz": lambda: csv_packed(b"0" * 500_000_000, 1), "lines.csv.gz": lambda: csv_packed(b"\n", 200_000_000), "wide.csv": csv_wide,
}


def _repacked(file, filters, size):
    """The first chunk of the messages of a stream, packed so often, holds so many zeros. The name of the stream."""
    name = sorted(file["streams"])[0]
    old = file[f"streams/{name}/data"]
    creation = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    creation.set_chunk(old.chunks)
    for _ in range(filters):
        creation.set_deflate(9)
    space = h5py.h5s.create_simple((old.shape[0],), (h5py.h5s.UNLIMITED,))
    kind = old.id.get_type()
    del file[f"streams/{name}/data"]
    made = h5py.h5d.create(file[f"streams/{name}"].id, b"data", kind, space, creation)
    packed = bytes(size)
    for _ in range(filters):
        packed = zlib.compress(packed, 9)
    made.write_direct_chunk((0,), packed)
    return name


def _elsewhere(file, pipe, what):
    """The streams, one of them or its messages are in another file, which is a pipe."""
    name = sorted(file["streams"])[0]
    place = {"streams": "streams", "stream": f"streams/{name}", "messages": f"streams/{name}/data"}[what]
    del file[place]
    file[place] = h5py.ExternalLink(pipe, "/")
    return name


def _linked(file, links):
    name = sorted(file["streams"])[0]
    for n in range(links):
        file[f"streams/again_{n}"] = file[f"streams/{name}"]
    return name


RECORDINGS = {
    "a chunk that holds more than its rows": lambda file, pipe: _repacked(file, 1, 256 << 20),
    "a chunk packed twice": lambda file, pipe: _repacked(file, 2, 64 << 20),
    "a chunk packed three times": lambda file, pipe: _repacked(file, 3, 64 << 20),
    "streams elsewhere": lambda file, pipe: _elsewhere(file, pipe, "streams"),
    "a stream elsewhere": lambda file, pipe: _elsewhere(file, pipe, "stream"),
    "messages elsewhere": lambda file, pipe: _elsewhere(file, pipe, "messages"),
    "many links": lambda file, pipe: _linked(file, 5000),
}
