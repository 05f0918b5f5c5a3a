"""Breaks closed meshes in the ways in which exported meshes are broken. A mesh is (vertices, faces); the same seed breaks the same way."""
import math
import random

from shapes import ball, blob, joined, moved, outward, tube


def diagonal(mesh):
    axes = list(zip(*mesh[0]))
    return math.dist([min(a) for a in axes], [max(a) for a in axes])


def middle(mesh, face):
    corners = [mesh[0][i] for i in face]
    return tuple(sum(c[k] for c in corners) / len(corners) for k in range(3))


def edges_of(mesh):
    """The two faces of each edge."""
    found = {}
    for number, face in enumerate(mesh[1]):
        for a, b in zip(face, face[1:] + face[:1]):
            found.setdefault((min(a, b), max(a, b)), []).append(number)
    return found


def hole(mesh, dice, share=0.05):
    """A hole: the faces within `share` of the diagonal of a face are gone."""
    seed = middle(mesh, dice.choice(mesh[1]))
    reach = share * diagonal(mesh)
    nearest = min(mesh[1], key=lambda f: math.dist(middle(mesh, f), seed))
    return mesh[0], [f for f in mesh[1] if f is not nearest and math.dist(middle(mesh, f), seed) > reach]


def holes(mesh, dice):
    """Ten small holes."""
    for _ in range(10):
        mesh = hole(mesh, dice, 0.015)
    return mesh


def slit(mesh, dice):
    """A strip of faces is gone: those that a plane cuts, over a quarter of the way round."""
    level = 0.3 * max(v[2] for v in mesh[0]) + 0.01 * dice.random() * diagonal(mesh)
    cut = lambda f: min(mesh[0][i][2] for i in f) < level <= max(mesh[0][i][2] for i in f)  # noqa: E731
    quarter = lambda f: middle(mesh, f)[0] > 0 and middle(mesh, f)[1] > 0  # noqa: E731
    return mesh[0], [f for f in mesh[1] if not (cut(f) and quarter(f))]


def gaps(mesh, dice):
    """Each face has corners of its own, 1e-6 of the diagonal off, as where numbers were rounded."""
    reach = 1e-6 * diagonal(mesh)
    vertices = [tuple(c + reach * (2 * dice.random() - 1) for c in mesh[0][i]) for f in mesh[1] for i in f]
    return vertices, [(3 * n, 3 * n + 1, 3 * n + 2) for n in range(len(mesh[1]))]


def crack(mesh, dice):
    """Two halves that stand 5e-5 of the diagonal apart along the cut."""
    reach = 5e-5 * diagonal(mesh)
    level = sum(v[2] for v in mesh[0]) / len(mesh[0])
    upper = [middle(mesh, f)[2] > level for f in mesh[1]]
    of_lower = {i for f, up in zip(mesh[1], upper) if not up for i in f}
    vertices, copy = list(mesh[0]), {}
    faces = []
    for f, up in zip(mesh[1], upper):
        if up:
            for i in f:
                if i in of_lower and i not in copy:
                    copy[i] = len(vertices)
                    vertices.append(tuple(c + reach * (2 * dice.random() - 1) / math.sqrt(3) for c in mesh[0][i]))
            f = tuple(copy.get(i, i) for i in f)
        faces.append(f)
    return vertices, faces


def fins(mesh, dice):
    """Three faces stand on edges."""
    vertices, faces = list(mesh[0]), list(mesh[1])
    for _ in range(3):
        a, b, _ = dice.choice(mesh[1])
        p = [0.5 * (x + y) for x, y in zip(vertices[a], vertices[b])]
        length = math.hypot(*p) or 1
        faces.append((a, b, len(vertices)))
        vertices.append(tuple(c * (1 + 0.05 * diagonal(mesh) / length) for c in p))
    return vertices, faces


def stray(mesh, dice):
    """Five loose faces lie about."""
    size = diagonal(mesh)
    vertices, faces = list(mesh[0]), list(mesh[1])
    for _ in range(5):
        at = [size * (0.6 + 0.2 * dice.random()) for _ in range(3)]
        faces.append(tuple(range(len(vertices), len(vertices) + 3)))
        vertices += [tuple(c + 0.02 * size * (dice.random() - 0.5) for c in at) for _ in range(3)]
    return vertices, faces


def t_junctions(mesh, dice):
    """Ten edges have a vertex more on one of their sides."""
    vertices, faces = list(mesh[0]), list(mesh[1])
    taken = set()
    for edge, sides in dice.sample(sorted(edges_of(mesh).items()), 60):
        if len(taken) >= 20 or taken.intersection(sides):
            continue
        taken.update(sides)
        a, b = edge
        face = faces[sides[0]]
        c = next(i for i in face if i not in edge)
        if (a, b) not in zip(face, face[1:] + face[:1]):
            a, b = b, a
        faces[sides[0]] = (a, len(vertices), c)
        faces.append((len(vertices), b, c))
        vertices.append(tuple(0.5 * (x + y) for x, y in zip(vertices[a], vertices[b])))
    return vertices, faces


def folds(mesh, dice):
    """Three vertices are drawn beyond their neighbours along the surface, so that faces fold over and cut each other."""
    vertices = list(mesh[0])
    for a, b, c in dice.sample(mesh[1], 3):
        p, q, r = (mesh[0][i] for i in (a, b, c))
        vertices[a] = tuple(x + 1.7 * (0.5 * (y + z) - x) + 0.3 * (y - z) for x, y, z in zip(p, q, r))
    return vertices, mesh[1]


def overlap(mesh, dice):
    """Two bodies that overlap in one file."""
    axes = list(zip(*mesh[0]))
    return joined(mesh, moved(mesh, tuple((0.3 + 0.05 * dice.random()) * (max(a) - min(a)) for a in axes)))


def touch(mesh, dice):
    """The mesh and its mirror image share their outermost vertex."""
    del dice
    most = max(range(len(mesh[0])), key=lambda i: mesh[0][i])
    at = mesh[0][most][0]
    vertices, faces = list(mesh[0]), list(mesh[1])
    image = {}
    for i, (x, y, z) in enumerate(mesh[0]):
        image[i] = i if x == at else len(vertices)
        if x != at:
            vertices.append((2 * at - x, y, z))
    return vertices, faces + [tuple(image[i] for i in f[::-1]) for f in mesh[1]]


def mixed(mesh, dice):
    """A third of the faces looks inwards, some come twice, vertices are unused, a hole, a fin."""
    vertices, faces = fins(hole(mesh, dice, 0.03), dice)
    faces = [f[::-1] if dice.random() < 1 / 3 else f for f in faces]
    return vertices + [(0.0, 0.0, 0.0)] * 5, faces + dice.sample(faces, 10)


FAULTS = {f.__name__: f for f in (hole, holes, slit, gaps, crack, fins, stray, t_junctions, folds, overlap, touch, mixed)}


def torus(large, small, rings=48, sides=24):
    return tube([[((large + small * math.cos(v)) * math.cos(u), (large + small * math.cos(v)) * math.sin(u), small * math.sin(v))
                  for v in (2 * math.pi * k / sides for k in range(sides))] for u in (2 * math.pi * k / rings for k in range(rings))])


def block(x, y, z, cells=8):
    """A cuboid whose sides are divided into squares of two triangles."""
    index, vertices, faces = {}, [], []

    def at(i, j, k):
        if (i, j, k) not in index:
            index[i, j, k] = len(vertices)
            vertices.append(tuple(s * (n / cells - 0.5) for s, n in zip((x, y, z), (i, j, k))))
        return index[i, j, k]

    for axis in range(3):
        for side in (0, cells):
            for i in range(cells):
                for j in range(cells):
                    corner = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
                    a, b, c, d = (at(*(side if n == axis else p[n - (n > axis)] for n in range(3))) for p in corner)
                    turned = (side == 0) != (axis == 1)
                    faces += [(a, c, b), (a, d, c)] if turned else [(a, b, c), (a, c, d)]
    return outward(vertices, faces)


SOURCES = {
    "ball": lambda: ball(0.05),
    "torus": lambda: torus(0.06, 0.02),
    "block": lambda: block(0.08, 0.05, 0.03),
    "blob": lambda: blob(0.04, ((0.15, (1, 0.5, 0.2), 4, 0.4), (0.08, (-0.3, 1, 0.6), 7, 1.1))),
}


def broken(source, fault):
    return FAULTS[fault](SOURCES[source](), random.Random(f"{source} {fault}"))
