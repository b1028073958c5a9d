#!/usr/bin/env python3
"""Writes the surface of a lumen as STL, as a segmentation has it: `lumen.py LINES OUT.stl`.

LINES are centre-lines with radii in ASCII: .swc, or .vtp as the examples here have. Around them lies a smooth union of
tubes whose cross-sections are not round, in triangles by surface nets (Gibson 1998). Lengths as in LINES."""

import argparse
import collections
import math
import pathlib
import re
import struct

# How much wider the cross-sections are across than upright, how far tubes blend, in radii.
LOBES, FILLET = 0.06, 0.6


def read_swc(path):
    """Each branch from where it begins to where it divides or ends."""
    nodes, children = {}, collections.defaultdict(list)
    for row in path.read_text().splitlines():
        if row.strip() and not row.startswith("#"):
            number, _, x, y, z, r, parent = map(float, row.split()[:7])
            nodes[number] = ((x, y, z), r)
            children[parent].append(number)
    lines = []

    def follow(line, at):
        while len(children[at]) == 1:
            at = children[at][0]
            line.append(nodes[at])
        lines.append(line)
        for child in children[at]:
            # It begins with its own radius.
            follow([(nodes[at][0], nodes[child][1]), nodes[child]], child)

    for root in children[-1.0]:
        follow([nodes[root]], root)
    return lines


def read_vtp(path):
    text = path.read_text()
    blocks = [b.split() for b in re.findall(r"<DataArray[^>]*>([^<]*)</DataArray>", text)]
    radii = list(map(float, blocks[0]))
    x = list(map(float, blocks[2]))
    points = [((x[3 * i], x[3 * i + 1], x[3 * i + 2]), r) for i, r in enumerate(radii)]
    ends = list(map(int, blocks[4]))
    return [points[a:b] for a, b in zip([0, *ends], ends)]


class Lumen:
    """f below 0 inside; a segment of each line is found through cells of space."""

    def __init__(self, lines, sacs=()):
        self.widest = max(r for line in lines for _, r in line)
        self.cell = 2.0 * self.widest
        self.near = collections.defaultdict(set)
        self.lines = lines
        # Open ends: points that no other line has within its radius there, with the direction outward.
        firsts = [(line[0], line[1]) for line in lines]
        lasts = [(line[-1], line[-2]) for line in lines]
        self.ends = []
        for number, (end, inner) in enumerate(firsts[:1] + lasts):
            mine = max(number - 1, 0)
            others = (p for i, line in enumerate(lines) if i != mine for p in (line[0], line[-1]))
            if number > 0 and any(math.dist(p[0], end[0]) < 0.5 * end[1] for p in others):
                continue
            if any(math.dist(end[0], sac) < 0.5 * end[1] for sac in sacs):
                continue
            length = math.dist(end[0], inner[0])
            self.ends.append((end[0], [(a - b) / length for a, b in zip(end[0], inner[0])], end[1]))
        # Tubes go on there, and are cut off.
        for end, out, radius in self.ends:
            for line in lines:
                beyond = ([c + 2.0 * radius * d for c, d in zip(end, out)], radius)
                if line[0][0] == end:
                    line.insert(0, beyond)
                elif line[-1][0] == end:
                    line.append(beyond)
        for number, line in enumerate(lines):
            for i in range(len(line) - 1):
                middle = [0.5 * (a + b) for a, b in zip(line[i][0], line[i + 1][0])]
                here = [math.floor(c / self.cell) for c in middle]
                for key in ((here[0] + a, here[1] + b, here[2] + c)
                            for a in (-1, 0, 1) for b in (-1, 0, 1) for c in (-1, 0, 1)):
                    self.near[key].add((number, i))

    def of_line(self, x, found):
        """The distance from the tube of a line, the direction away from it and its radius."""
        best = None
        for number, i in found:
            (a, r), (b, q) = self.lines[number][i : i + 2]
            ab = (b[0] - a[0], b[1] - a[1], b[2] - a[2])
            ax = (x[0] - a[0], x[1] - a[1], x[2] - a[2])
            u = (ab[0] * ax[0] + ab[1] * ax[1] + ab[2] * ax[2]) / (ab[0] ** 2 + ab[1] ** 2 + ab[2] ** 2)
            u = min(max(u, 0.0), 1.0)
            arm = (ax[0] - u * ab[0], ax[1] - u * ab[1], ax[2] - u * ab[2])
            away = math.sqrt(arm[0] ** 2 + arm[1] ** 2 + arm[2] ** 2) or 1e-12
            radius = r + u * (q - r)
            normal = (arm[0] / away, arm[1] / away, arm[2] / away)
            wall = radius * (1.0 + LOBES * (1.0 + normal[1] * normal[1]))
            if best is None or away - wall < best[0]:
                best = (away - wall, normal, radius)
        return best

    def value(self, x):
        found = collections.defaultdict(list)
        for segment in self.near[tuple(math.floor(c / self.cell) for c in x)]:
            found[segment[0]].append(segment)
        if not found:
            return self.cell
        all_lines = [self.of_line(x, line) for line in found.values()]
        least = min(d for d, _, _ in all_lines)
        lowered = least
        for i, (a, n, r) in enumerate(all_lines):
            for b, m, q in all_lines[:i]:
                k = FILLET * min(r, q) * 0.5 * (1.0 - n[0] * m[0] - n[1] * m[1] - n[2] * m[2])
                if k > abs(a - b):
                    lowered = min(lowered, min(a, b) - (k - abs(a - b)) ** 2 / (4.0 * k))
        return lowered

    def past(self, x):
        """How far past an open end, and the direction outward."""
        for end, out, radius in self.ends:
            arm = [a - b for a, b in zip(x, end)]
            if math.hypot(*arm) < 3.0 * radius:
                return sum(a * b for a, b in zip(arm, out)), out
        return -math.inf, None


def net(lumen, h):
    """Triangles of the surface in a lattice of the spacing h, from cell to cell along it."""
    values, places = {}, {}

    def value(p):
        if p not in values:
            values[p] = lumen.value([c * h for c in p])
        return values[p]

    def corners(cell):
        return [(cell[0] + a, cell[1] + b, cell[2] + c) for a in (0, 1) for b in (0, 1) for c in (0, 1)]

    def projected(cell):
        points = corners(cell)
        cut = [(points[a], points[b]) for a in range(8) for b in range(a)
               if bin(a ^ b).count("1") == 1 and (value(points[a]) < 0.0) != (value(points[b]) < 0.0)]
        x = [0.0, 0.0, 0.0]
        for p, q in cut:
            t = value(p) / (value(p) - value(q))
            x = [s + h * (a + t * (b - a)) / len(cut) for s, a, b in zip(x, p, q)]
        for _ in range(2):
            f, d = lumen.value(x), 1e-3 * h
            slope = [(lumen.value([c + d * (i == k) for i, c in enumerate(x)]) - f) / d for k in range(3)]
            square = sum(s * s for s in slope) or 1.0
            x = [c - f * s / square for c, s in zip(x, slope)]
        past, out = lumen.past(x)
        return [c - past * d for c, d in zip(x, out)] if past > -0.5 * h else x

    start = [round(c / h) for c in lumen.lines[0][1][0]]
    while value(tuple(start)) < 0.0:
        start[1] += 1
    queue = collections.deque([(start[0], start[1] - 1, start[2])])
    seen, triangles = set(queue), []
    while queue:
        cell = queue.popleft()
        signs = {value(p) < 0.0 for p in corners(cell)}
        if len(signs) == 1 or lumen.past([h * (c + 0.5) for c in cell])[0] > 0.5 * h:
            continue
        places[cell] = projected(cell)
        for k in range(3):
            for step in (-1, 1):
                other = tuple(c + step * (i == k) for i, c in enumerate(cell))
                if other not in seen:
                    seen.add(other)
                    queue.append(other)
    for cell in sorted(places):
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            low = cell
            high = tuple(c + (n == k) for n, c in enumerate(cell))
            inside = value(low) < 0.0
            if inside == (value(high) < 0.0):
                continue
            around = [tuple(c - a * (n == i) - b * (n == j) for n, c in enumerate(cell))
                      for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
            if any(c not in places for c in around):
                continue
            quad = around if inside else around[::-1]
            p = [places[c] for c in quad]
            if math.dist(p[0], p[2]) < math.dist(p[1], p[3]):
                triangles += [(quad[0], quad[1], quad[2]), (quad[0], quad[2], quad[3])]
            else:
                triangles += [(quad[1], quad[2], quad[3]), (quad[1], quad[3], quad[0])]
    return places, triangles


def caps(places, triangles):
    """Fans that close the surface, one list for each of its holes."""
    along = {edge: True for t in triangles for edge in zip(t, (*t[1:], t[0]))}
    after = {b: a for a, b in along if (b, a) not in along}
    fans = []
    while after:
        loop = [next(iter(after))]
        while loop[-1] in after:
            loop.append(after.pop(loop[-1]))
        middle = ("cap", len(places))
        places[middle] = [sum(places[c][k] for c in loop[1:]) / (len(loop) - 1) for k in range(3)]
        fans.append([(a, b, middle) for a, b in zip(loop, loop[1:])])
    return fans


def write_binary(path, places, triangles):
    with path.open("wb") as out:
        out.write(b"lumen".ljust(80) + struct.pack("<I", len(triangles)))
        for t in triangles:
            out.write(struct.pack("<12fH", 0.0, 0.0, 0.0, *(c for p in t for c in places[p]), 0))


def write_solids(path, places, solids):
    """In ASCII, each solid with its name, as snappyHexMesh makes patches of them."""
    with path.open("w", encoding="ascii") as out:
        for name, triangles in solids:
            out.write(f"solid {name}\n")
            for t in triangles:
                out.write("facet normal 0 0 0\n outer loop\n")
                out.writelines("  vertex {:.6g} {:.6g} {:.6g}\n".format(*places[p]) for p in t)
                out.write(" endloop\nendfacet\n")
            out.write(f"endsolid {name}\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("lines", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--spacing", type=float, default=0.25, help="of the lattice, in the smallest radius [0.25]")
    parser.add_argument("--closed", action="store_true", help="close the surface at its ends")
    parser.add_argument("--sac", action="append", default=[], metavar="X,Y,Z",
                        help="the line that ends there ends in a sac, which is round and no opening")
    parser.add_argument("--solids", help="close it, and write solids of these names: the wall, the beginning, each end")
    given = parser.parse_args()
    lines = read_swc(given.lines) if given.lines.suffix == ".swc" else read_vtp(given.lines)
    smallest = min(r for line in lines for _, r in line)
    lumen = Lumen(lines, [tuple(map(float, sac.split(","))) for sac in given.sac])
    places, triangles = net(lumen, given.spacing * smallest)
    fans = caps(places, triangles) if given.closed or given.solids else []
    if given.solids:
        wall, *names = given.solids.split(",")
        solids = [(wall, triangles)]
        for name, (end, _, _) in zip(names, lumen.ends):
            solids.append((name, min(fans, key=lambda fan: math.dist(places[fan[0][2]], end))))
        write_solids(given.out, places, solids)
    else:
        write_binary(given.out, places, triangles + [t for fan in fans for t in fan])
    print(f"{given.out}: {len(triangles)} triangles")


if __name__ == "__main__":
    main()
