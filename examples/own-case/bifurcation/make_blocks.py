#!/usr/bin/env python3
"""A symmetric bifurcation for blockMesh: writes fluid/system/blockMeshDict.

A parent vessel along z divides into two daughters in the plane y = 0. Three half discs, which share the line x = z = 0, part
the three tubes where they meet: one between the parent and each daughter, one between the daughters. Each tube is lofted from its two
half discs to the circle at its end by cubics. All lengths in mm.
"""

from math import cos, pi, radians, sin, sqrt
from pathlib import Path

PARENT, DAUGHTER = 3.0, 2.4  # radii: 2 * 2.4**3 is about 3**3
LENGTHS = 18.0, 18.0  # of parent and daughters, from where they meet
ANGLE = radians(35.0)  # of a daughter with the parent's axis
CROTCH = 4.6  # from where the tubes meet to where the daughters part
LEAVING = 0.7  # how far a tube follows the direction in which it leaves the half discs
CORE = 0.55  # side of the square in the middle, relative to the circle
CELLS = 3  # cells of an eighth of the circle; twice as many along a side of the square
RADIAL = 4  # from the square to the wall
ALONG = 15  # of each tube
GRADING = 0.4  # thickness of the cell at the wall over that at the square


def add(*vectors):
    return tuple(map(sum, zip(*vectors)))


def times(c, v):
    return tuple(c * x for x in v)


def unit(v):
    return times(1 / sqrt(sum(x * x for x in v)), v)


Y = (0.0, 1.0, 0.0)
HALF = ANGLE / 2
# Half discs: direction from the common line to the wall, half-axis in it, normal; y half-axis is the parent's radius.
DISCS = {
    "left": ((-cos(HALF), 0.0, -sin(HALF)), PARENT / cos(HALF), (-sin(HALF), 0.0, cos(HALF))),
    "right": ((cos(HALF), 0.0, -sin(HALF)), PARENT / cos(HALF), (sin(HALF), 0.0, cos(HALF))),
    "middle": ((0.0, 0.0, 1.0), CROTCH, (1.0, 0.0, 0.0)),
}
WIDTH = 0.5 * (PARENT + DAUGHTER)
# Tubes: axis away from the middle, radius, length, half discs with the sense of their normals into the tube and the
# direction of that half at the tube's end.
TUBES = {
    "inlet": (
        (0.0, 0.0, -1.0),
        PARENT,
        LENGTHS[0],
        [("left", -1, (-1.0, 0.0, 0.0)), ("right", -1, (1.0, 0.0, 0.0))],
    ),
    "outletLeft": (
        (-sin(ANGLE), 0.0, cos(ANGLE)),
        DAUGHTER,
        LENGTHS[1],
        [("left", 1, (-cos(ANGLE), 0.0, -sin(ANGLE))), ("middle", -1, (cos(ANGLE), 0.0, sin(ANGLE)))],
    ),
    "outletRight": (
        (sin(ANGLE), 0.0, cos(ANGLE)),
        DAUGHTER,
        LENGTHS[1],
        [("right", 1, (cos(ANGLE), 0.0, -sin(ANGLE))), ("middle", 1, (-cos(ANGLE), 0.0, sin(ANGLE)))],
    ),
}


def point(tube, half, u, v, s):
    """The point (u, v) of a unit half disc (u >= 0) at the share s of the way to the end of the tube."""
    axis, radius, length, halves = TUBES[tube]
    disc, sense, outward = halves[half]
    direction, depth, normal = DISCS[disc]
    begin = add(times(u * depth, direction), times(v * WIDTH, Y))
    end = add(times(length, axis), times(u * radius, outward), times(v * radius, Y))
    # It leaves the half disc at a right angle, but on the common line along the axis.
    tangent = unit(add(times(1 - u, axis), times(u * sense, normal)))
    tangent = times(LEAVING * sum(a * b for a, b in zip(tangent, axis)), tangent)
    h = [2 * s**3 - 3 * s**2 + 1, s**3 - 2 * s**2 + s, -2 * s**3 + 3 * s**2, s**3 - s**2]
    return add(times(h[0], begin), times(h[1] * length, tangent), times(h[2], end), times(h[3] * length, axis))


def on_circle(phi):
    return cos(phi), sin(phi)


C = CORE / sqrt(2)
# Points of a half disc: the square's half, then the circle, from -y to +y.
PLACES = [(0.0, -C), (C, -C), (C, C), (0.0, C)] + [on_circle(k * pi / 4) for k in (-2, -1, 1, 2)]

points, numbers = [], {}


def number(x):
    key = tuple(round(c, 9) + 0.0 for c in x)
    if key not in numbers:
        numbers[key] = len(points)
        points.append(x)
    return numbers[key]


blocks, edges, patches = [], {}, {name: [] for name in ["inlet", "outletLeft", "outletRight", "wall"]}


def edge(path, steps=24):
    """A curved edge, by points of its path from 0 to 1."""
    line = [path(k / steps) for k in range(steps + 1)]
    key = frozenset((number(line[0]), number(line[-1])))
    if key not in edges:
        edges[key] = line


for tube, (_, _, _, halves) in TUBES.items():
    for half in range(2):

        def at(k, s):
            return point(tube, half, *PLACES[k], s)

        def corners(face):
            return [number(at(k, 0.0)) for k in face], [number(at(k, 1.0)) for k in face]

        def across(k, m, s):
            edge(lambda t: at_circle(k, m, t, s), 16)

        def at_circle(k, m, t, s):
            phi = [None] * 4 + [-pi / 2, -pi / 4, pi / 4, pi / 2]
            return point(tube, half, *on_circle((1 - t) * phi[k] + t * phi[m]), s)

        # Turning from u to v counter-clockwise seen against the way to the end, or the other way round.
        axis, _, _, _ = TUBES[tube]
        outward = halves[half][2]
        turn = (outward[1] * Y[2] - outward[2] * Y[1], outward[2] * Y[0] - outward[0] * Y[2], outward[0] * Y[1] - outward[1] * Y[0])
        forward = sum(a * b for a, b in zip(turn, axis)) > 0
        for face, cells, grading in [
            ((0, 1, 2, 3), (CELLS, 2 * CELLS), (1, 1)),
            ((1, 5, 6, 2), (RADIAL, 2 * CELLS), (GRADING, 1)),
            ((0, 4, 5, 1), (RADIAL, CELLS), (GRADING, 1)),
            ((3, 2, 6, 7), (CELLS, RADIAL), (1, GRADING)),
        ]:
            if forward:
                bottom, top = corners(face)
            else:
                top, bottom = corners(face)
            blocks.append((bottom + top, cells, grading))
            patches[tube].append(corners(face)[1])
        for k in range(8):
            edge(lambda s, k=k: at(k, s))
        for k, m in [(4, 5), (5, 6), (6, 7)]:
            for s in (0.0, 1.0):
                across(k, m, s)
            a, b = corners((k, m))
            patches["wall"].append([a[0], a[1], b[1], b[0]])

text = [
    "FoamFile\n{\n    version     2.0;\n    format      ascii;\n    class       dictionary;\n    object      blockMeshDict;\n}\n",
    "// Made by make_blocks.py\nscale   1e-3;\n\nvertices\n(",
]
text += ["    (%.12g %.12g %.12g)" % tuple(c + 0.0 for c in x) for x in points]
text += [");\n\nblocks\n("]
for vertices, cells, grading in blocks:
    text.append(
        "    hex (%s) (%d %d %d) simpleGrading (%g %g 1)"
        % (" ".join(map(str, vertices)), *cells, ALONG, *grading)
    )
text += [");\n\nedges\n("]
for line in edges.values():
    inner = " ".join("(%.9g %.9g %.9g)" % x for x in line[1:-1])
    text.append("    polyLine %d %d (%s)" % (number(line[0]), number(line[-1]), inner))
text += [");\n\nboundary\n("]
for name, faces in patches.items():
    kind = "wall" if name == "wall" else "patch"
    listed = " ".join("(%s)" % " ".join(map(str, face)) for face in faces)
    text.append("    %s\n    {\n        type %s;\n        faces (%s);\n    }" % (name, kind, listed))
text += [");\n"]
Path(__file__).with_name("fluid").joinpath("system/blockMeshDict").write_text("\n".join(text))
print(len(points), "vertices,", len(blocks), "blocks,", sum(a * b * ALONG for _, (a, b), _ in blocks), "cells")
