#!/usr/bin/env python3
"""Writes tree.swc: four generations of bifurcations, fifteen branches, each pair of daughters by Murray's law and in a
plane turned by 50 degrees from the last one. Lengths in mm."""

import math
import pathlib

rows = []


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def mix(a, b, angle):
    c, s = math.cos(angle), math.sin(angle)
    return [c * x + s * y for x, y in zip(a, b)]


def grow(start, along, normal, radius, parent, generations):
    """A branch of nine radii, and what follows."""
    for i in range(1, 10):
        point = [x + radius * i * t for x, t in zip(start, along)]
        rows.append((*point, radius, parent))
        parent = len(rows)
    if generations == 0:
        return
    # r0^3 = r1^3 + r2^3 with r2 = 0.8 r1
    larger = radius / (1.0 + 0.8**3) ** (1.0 / 3.0)
    side = cross(normal, along)
    for daughter, angle in ((larger, 30.0), (0.8 * larger, -40.0)):
        direction = mix(along, side, math.radians(angle))
        turned = mix(normal, cross(direction, normal), math.radians(50.0))
        grow(point, direction, turned, daughter, parent, generations - 1)


rows.append((0.0, 0.0, 0.0, 2.0, -1))
grow([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], 2.0, 1, 3)
text = "# id type x y z radius parent, mm\n"
for i, (x, y, z, radius, parent) in enumerate(rows, 1):
    text += f"{i} 0 {x:.4f} {y:.4f} {z:.4f} {radius:.4f} {parent}\n"
(pathlib.Path(__file__).parent / "tree.swc").write_text(text)
