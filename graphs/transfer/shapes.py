"""Closed triangle meshes of the transfer scenes, as (vertices in m, faces), and points on them."""
import math


def joined(*meshes):
    """Several closed meshes as one."""
    vertices, faces = [], []
    for more, triangles in meshes:
        faces += [tuple(len(vertices) + i for i in f) for f in triangles]
        vertices += more
    return vertices, faces


def moved(mesh, by):
    return [tuple(a + b for a, b in zip(v, by)) for v in mesh[0]], mesh[1]


def outward(vertices, faces):
    """The mesh with its faces turned so that it encloses a positive volume."""
    volume = sum(x[0] * (y[1] * z[2] - y[2] * z[1]) - x[1] * (y[0] * z[2] - y[2] * z[0]) + x[2] * (y[0] * z[1] - y[1] * z[0])
                 for x, y, z in ((vertices[i] for i in f) for f in faces))
    return vertices, faces if volume > 0 else [f[::-1] for f in faces]


def tube(rows):
    """Rings of as many points each, joined in a circle: the surface of a torus."""
    n, m = len(rows), len(rows[0])
    faces = []
    for i in range(n):
        for j in range(m):
            a, b = i * m + j, i * m + (j + 1) % m
            c, d = (i + 1) % n * m + j, (i + 1) % n * m + (j + 1) % m
            faces += [(a, b, d), (a, d, c)]
    return outward([p for row in rows for p in row], faces)


def revolved(profile, sides):
    """A profile of (radius, z) turned about z. A profile from axis to axis (its first and last radius 0) makes a closed body."""
    inner = profile[1:-1]
    vertices = [(0.0, 0.0, profile[0][1])]
    for r, z in inner:
        vertices += [(r * math.cos(2 * math.pi * k / sides), r * math.sin(2 * math.pi * k / sides), z) for k in range(sides)]
    vertices.append((0.0, 0.0, profile[-1][1]))
    last = len(vertices) - 1
    faces = [(0, 1 + (k + 1) % sides, 1 + k) for k in range(sides)]
    for i in range(len(inner) - 1):
        for k in range(sides):
            a, b = 1 + i * sides + k, 1 + i * sides + (k + 1) % sides
            faces += [(a, b, b + sides), (a, b + sides, a + sides)]
    start = 1 + (len(inner) - 1) * sides
    faces += [(last, start + k, start + (k + 1) % sides) for k in range(sides)]
    return outward(vertices, faces)


def ring(r_in, r_out, height, sides):
    """A tube about z with a rectangular cross-section."""
    h = height / 2
    section = ((r_in, -h), (r_out, -h), (r_out, h), (r_in, h))
    return tube([[(r * math.cos(a), r * math.sin(a), z) for r, z in section]
                 for a in (2 * math.pi * k / sides for k in range(sides))])


def cylinder(radius, length, sides):
    return revolved([(0, -length / 2), (radius, -length / 2), (radius, length / 2), (0, length / 2)], sides)


def blob(radius, waves, sides=48):
    """A sphere whose radius goes up and down by `waves` of (amplitude as a share, direction, waves over the radius, phase)."""
    rows = sides // 2

    def at(theta, phi):
        n = (math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta))
        r = radius * (1 + sum(a * math.sin(f * sum(x * y for x, y in zip(n, d)) + p) for a, d, f, p in waves))
        return tuple(r * x for x in n)

    vertices = [at(0, 0)] + [at(math.pi * i / rows, 2 * math.pi * k / sides) for i in range(1, rows) for k in range(sides)] + [at(math.pi, 0)]
    faces = [(0, 1 + k, 1 + (k + 1) % sides) for k in range(sides)]
    for i in range(rows - 2):
        for k in range(sides):
            a, b = 1 + i * sides + k, 1 + i * sides + (k + 1) % sides
            faces += [(a, a + sides, b + sides), (a, b + sides, b)]
    start, last = 1 + (rows - 2) * sides, len(vertices) - 1
    faces += [(last, start + (k + 1) % sides, start + k) for k in range(sides)]
    return outward(vertices, faces)


def height_field(size, cells, thickness, height):
    """A square plate of that size whose top is height(x, y) and whose bottom is at -thickness."""
    n = cells + 1
    at = [size * (i / cells - 0.5) for i in range(n)]
    vertices = [(x, y, height(x, y)) for x in at for y in at] + [(x, y, -thickness) for x in at for y in at]
    faces = []
    for i in range(cells):
        for j in range(cells):
            a, b, c, d = i * n + j, (i + 1) * n + j, (i + 1) * n + j + 1, i * n + j + 1
            faces += [(a, b, c), (a, c, d)]
            faces += [(n * n + a, n * n + c, n * n + b), (n * n + a, n * n + d, n * n + c)]
    rim = [i * n for i in range(cells)] + [cells * n + j for j in range(cells)] + [i * n + cells for i in range(cells, 0, -1)] + \
          [j for j in range(cells, 0, -1)]
    for a, b in zip(rim, rim[1:] + rim[:1]):
        faces += [(a, n * n + a, n * n + b), (a, n * n + b, b)]
    return outward(vertices, faces)


def extruded(outline, middle, thickness):
    """A flat outline (x, y), every point of which is seen from `middle`, as a plate about z = 0."""
    n, h = len(outline), thickness / 2
    vertices = [(x, y, h) for x, y in outline] + [(x, y, -h) for x, y in outline] + [(*middle, h), (*middle, -h)]
    faces = []
    for i in range(n):
        j = (i + 1) % n
        faces += [(2 * n, i, j), (2 * n + 1, n + j, n + i), (i, n + i, n + j), (i, n + j, j)]
    return outward(vertices, faces)


def star(points, r_in, r_out, thickness):
    return extruded([((r_out, r_in)[k % 2] * math.cos(math.pi * k / points), (r_out, r_in)[k % 2] * math.sin(math.pi * k / points))
                     for k in range(2 * points)], (0, 0), thickness)


def gear(teeth, r_in, r_out, thickness):
    """Teeth with slanted flanks: each takes a sixth of the pitch at its tip."""
    outline = []
    for k in range(teeth):
        for share, r in ((-0.25, r_in), (-0.1, r_out), (0.1, r_out), (0.25, r_in)):
            a = 2 * math.pi * (k + share) / teeth
            outline.append((r * math.cos(a), r * math.sin(a)))
    return extruded(outline, (0, 0), thickness)


def stairs(steps, tread, rise, width):
    """Steps down along +x from the origin's left, `width` along y, the top of the highest at z = 0."""
    length, height = steps * tread, steps * rise
    outline = [(0, 0)]
    for k in range(steps):
        outline += [((steps - k) * tread, k * rise), ((steps - k) * tread, (k + 1) * rise)]
    outline += [(0, height)]
    # The outline lies in x and z: the corner sees all of it. Its first point is that corner.
    n, h = len(outline), width / 2
    vertices = [(x - length / 2, -h, z - height) for x, z in outline] + [(x - length / 2, h, z - height) for x, z in outline]
    faces = []
    for i in range(1, n - 1):
        faces += [(0, i, i + 1), (n, n + i + 1, n + i)]
    for i in range(n):
        j = (i + 1) % n
        faces += [(i, n + i, n + j), (i, n + j, j)]
    return outward(vertices, faces)


def knot(p, q, radius, thickness, rings=160, sides=12):
    """A torus knot that goes p times about the axis and q times about the core."""
    def line(t):
        r = radius * (1 + 0.4 * math.cos(q * t))
        return (r * math.cos(p * t), r * math.sin(p * t), 0.4 * radius * math.sin(q * t))

    rows = []
    for i in range(rings):
        t = 2 * math.pi * i / rings
        here, ahead = line(t), line(t + 1e-4)
        along = [b - a for a, b in zip(here, ahead)]
        size = math.sqrt(sum(x * x for x in along))
        along = [x / size for x in along]
        out = [x / math.sqrt(sum(y * y for y in here)) for x in here]  # never along the line
        share = sum(x * y for x, y in zip(out, along))
        first = [x - share * y for x, y in zip(out, along)]
        size = math.sqrt(sum(x * x for x in first))
        first = [x / size for x in first]
        second = [along[1] * first[2] - along[2] * first[1], along[2] * first[0] - along[0] * first[2], along[0] * first[1] - along[1] * first[0]]
        rows.append([tuple(h + thickness * (math.cos(a) * f + math.sin(a) * s) for h, f, s in zip(here, first, second))
                     for a in (2 * math.pi * k / sides for k in range(sides))])
    return tube(rows)


def box(x, y, z):
    corners = [(sx * x / 2, sy * y / 2, sz * z / 2) for sx in (-1, 1) for sy in (-1, 1) for sz in (-1, 1)]
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    return outward(corners, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def ball(radius, sides=24):
    return blob(radius, [], sides)


def write_off(mesh, file):
    vertices, faces = mesh
    lines = ["OFF", f"{len(vertices)} {len(faces)} 0", *(f"{x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices),
             *(f"3 {a} {b} {c}" for a, b, c in faces)]
    file.write_text("\n".join(lines) + "\n")


def points_on(mesh, spacing):
    """Points on all faces, no further apart than about `spacing`."""
    vertices, faces = mesh
    found = []
    for f in faces:
        a, b, c = (vertices[i] for i in f)
        n = max(1, math.ceil(max(math.dist(a, b), math.dist(b, c), math.dist(c, a)) / spacing))
        for i in range(n + 1):
            for j in range(n + 1 - i):
                u, v = i / n, j / n
                found.append(tuple(x + u * (y - x) + v * (z - x) for x, y, z in zip(a, b, c)))
    return found


class Heights:
    """At which height above one mesh another touches it, when it comes down along z: on a raster of 0.5 mm."""
    CELL = 5e-4

    def __init__(self, fixed, tool):
        def raster(mesh, better):
            cells = {}
            for x, y, z in points_on(mesh, self.CELL):
                key = (round(x / self.CELL), round(y / self.CELL))
                cells[key] = better(cells.get(key, z), z)
            return cells

        self.top = raster(fixed, max)
        self.bottom = raster(tool, min)

    def touch(self, x, y):
        """The height of the tool's origin there. None where it falls past."""
        i, j = round(x / self.CELL), round(y / self.CELL)
        return max((self.top[i + a, j + b] - low for (a, b), low in self.bottom.items() if (i + a, j + b) in self.top), default=None)
