#!/usr/bin/env python3
"""Writes lines.vtp, centre-lines of a carotid bifurcation after the size of a man's, as VMTK would: two lines from the common
carotid, to the internal (CenterlineIds 0) and to the external one (1), each in three tracts, with points that scatter by
0.1 mm and the radius of the largest sphere that fits. In millimetres, anywhere in space."""

import base64
import math
import random
import struct
import zlib
from pathlib import Path


def array(name, letter, numbers, components=1):
    """A DataArray in base64, compressed by zlib, as VTK writes it."""
    kinds = {"d": "Float64", "f": "Float32", "q": "Int64", "i": "Int32"}
    raw = struct.pack(f"<{len(numbers)}{letter}", *numbers)
    packed = zlib.compress(raw)
    header = struct.pack("<4I", 1, len(raw), len(raw), len(packed))
    text = (base64.b64encode(header) + base64.b64encode(packed)).decode()
    more = f' NumberOfComponents="{components}"' if components > 1 else ""
    return f'<DataArray type="{kinds[letter]}" Name="{name}"{more} format="binary">{text}</DataArray>\n'


def trunk(t):  # the common carotid, 40 mm
    return (0.0, 3.0 * math.sin(0.05 * 40 * t), 40 * t), 3.2 - 0.1 * t


def internal(t):  # 50 mm, with a bulb where it begins
    x, y, z = trunk(1.0)[0]
    bulb = 0.9 * math.exp(-((t - 0.12) / 0.13) ** 2)
    return (x + 16 * t**1.6, y + 6 * math.sin(2.2 * t), z + 45 * t), 2.6 + bulb - 0.3 * t


def external(t):  # 40 mm
    x, y, z = trunk(1.0)[0]
    return (x - 14 * t**1.3, y - 3 * t, z + 36 * t), 2.1 - 0.4 * t


def placed(p):  # as the patient lies in the scanner
    x, y, z = p
    a, b = math.radians(25), math.radians(-15)
    y, z = y * math.cos(a) - z * math.sin(a), y * math.sin(a) + z * math.cos(a)
    x, z = x * math.cos(b) + z * math.sin(b), -x * math.sin(b) + z * math.cos(b)
    return x + 31.0, y - 148.0, z + 1204.0


def main():
    random.seed(19)
    points, radii, cells = [], [], []
    for line, branch in enumerate([internal, external]):
        tracts = [(trunk, 0.0, 0.92, 120, 0, 0), (None, 0, 0, 0, 1, 1), (branch, 0.12, 1.0, 150, 0, 2 + line)]
        ends = [trunk(0.92), branch(0.12)]
        for tract, (shape, start, stop, count, blanking, group) in enumerate(tracts):
            if shape is None:  # within the bifurcation
                middle = [tuple(a + (b - a) * t for a, b in zip(ends[0][0], ends[1][0])) for t in (k / 20 for k in range(21))]
                part = [(p, ends[0][1] + (ends[1][1] - ends[0][1]) * k / 20) for k, p in enumerate(middle)]
            else:
                part = [shape(start + (stop - start) * k / count) for k in range(count + 1)]
            first = len(points)
            for p, r in part:
                points.append(placed([c + random.gauss(0, 0.05) for c in p]))
                radii.append(r + random.gauss(0, 0.01))
            cells.append((range(first, len(points)), line, tract, blanking, group))
    ends = []
    for indices, *_ in cells:
        ends.append(len(indices) + (ends[-1] if ends else 0))
    names = ["CenterlineIds", "TractIds", "Blanking", "GroupIds"]
    text = (
        '<?xml version="1.0"?>\n<VTKFile type="PolyData" version="0.1" byte_order="LittleEndian" header_type="UInt32" '
        'compressor="vtkZLibDataCompressor">\n<PolyData>\n'
        f'<Piece NumberOfPoints="{len(points)}" NumberOfVerts="0" NumberOfLines="{len(cells)}" NumberOfStrips="0" NumberOfPolys="0">\n'
        + "<PointData>\n" + array("MaximumInscribedSphereRadius", "d", radii) + "</PointData>\n<CellData>\n"
        + "".join(array(name, "i", [cell[k + 1] for cell in cells]) for k, name in enumerate(names)) + "</CellData>\n"
        + "<Points>\n" + array("Points", "d", [c for p in points for c in p], 3) + "</Points>\n<Lines>\n"
        + array("connectivity", "q", [i for cell in cells for i in cell[0]]) + array("offsets", "q", ends) + "</Lines>\n"
        + "</Piece>\n</PolyData>\n</VTKFile>\n"
    )
    Path(__file__).with_name("lines.vtp").write_text(text)


main()
