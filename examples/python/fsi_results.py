#!/usr/bin/env python3
"""Reads what a run of fsi-driver has left. Needs numpy.

    from fsi_results import Run
    run = Run("openfoam-case/S-0.25/run-coarse")
    run.history["time_s"], run.history["Q_out_m3_s"]    # every table by its columns
    run.hemodynamics["regions"][0]["OSI"]["max"]
    run.wall.time_s, run.wall.wall_shear_Pa             # (steps,), (steps, faces, 3)

As a program it says what a run holds:  fsi_results.py RUN
"""

import json
import sys
import zlib
from functools import cached_property
from pathlib import Path

import numpy as np


class DamagedFile(Exception):
    """A file is not what fsi-driver has written; the text says which, where and what is wrong."""


class Run:
    """The folder of a run. Files are read when they are asked for."""

    def __init__(self, folder):
        self.folder = Path(folder)
        if not (self.folder / "case.resolved.toml").is_file():
            raise FileNotFoundError(f"{folder} is not the folder of a run (it holds no case.resolved.toml)")

    def table(self, name):
        """A CSV file as a structured array: a field a column, a record a row; a last row that is cut off is left out."""
        text = (self.folder / name).read_text(encoding="utf-8")
        lines = text[: text.rfind("\n") + 1].splitlines()
        rows = np.genfromtxt(lines, delimiter=",", names=True, dtype=None, encoding="utf-8", deletechars="")
        return np.atleast_1d(rows)

    @property
    def history(self):
        """One row per time step."""
        return self.table("history.csv")

    @property
    def iterations(self):
        """One row per coupling iteration."""
        return self.table("iterations.csv")

    @property
    def regions(self):
        """One row per time step and region."""
        return self.table("regions.csv")

    def region(self, name):
        """The rows of one region: "bypass", "artery" or "mid_artery"."""
        return self.regions[self.regions["region"] == name]

    @property
    def probes(self):
        """One row per time step and probe."""
        return self.table("probes.csv")

    @property
    def fluid_probes(self):
        """One row per time step and probe in the blood; NaN where that is not in the blood."""
        return self.table("fluid-probes.csv")

    @property
    def phases(self):
        """One row per phase of the period, averaged over beats (`fsi-driver hemodynamics RUN --phases N`)."""
        return self.table("phases.csv")

    @property
    def wall_shear(self):
        """One row per face of the wall: TAWSS, OSI and RRT over the evaluated window."""
        return self.table("wall-shear.csv")

    @property
    def hemodynamics(self):
        """The evaluated window in figures."""
        return _json(self.folder / "hemodynamics.json")

    @property
    def summary(self):
        """The run in figures."""
        return _json(self.folder / "summary.json")

    @property
    def case(self):
        """Every value that was used (needs Python 3.11)."""
        import tomllib

        return tomllib.loads((self.folder / "case.resolved.toml").read_text(encoding="utf-8"))

    @cached_property
    def wall(self):
        """The wall at every step."""
        return Wall(self.folder / "wall.bin")


def _json(path):
    """JSON with the texts for numbers that it does not know as such."""
    special = {"Infinity": np.inf, "-Infinity": -np.inf, "NaN": np.nan}

    def number(value):
        if isinstance(value, dict):
            return {key: number(item) for key, item in value.items()}
        if isinstance(value, list):
            return [number(item) for item in value]
        return special.get(value, value) if isinstance(value, str) else value

    return number(json.loads(path.read_text(encoding="utf-8")))


class Wall:
    """`wall.bin`: the wet surface, its shear stress and its displacement at every step.

    points         (P, 3) positions of the unloaded wall, m
    faces          list of F arrays of numbers of points; normals point out of the blood
    time_s         (N,)
    wall_shear_Pa  (N, F, 3) of each face
    displacement_m (N, P, 3) of each point
    """

    HEAD = 24

    def __init__(self, path, check=True):
        """Maps the file; with `check`, reads it once to compare all checksums."""
        path = Path(path)
        head = _first(path, self.HEAD)
        if head[:7] != b"FSIWALL" or len(head) < self.HEAD:
            raise DamagedFile(f"{path}: no history of the wall")
        if head[7] != 2:
            raise DamagedFile(f"{path}: format version {head[7]}, this reader knows version 2")
        points, faces, vertices, offset = np.frombuffer(head, "<u4", 4, offset=8).tolist()
        head = _first(path, offset)
        needed = self.HEAD + 24 * points + 4 * faces + 4 * vertices + 4
        if not needed <= offset < needed + 8 or len(head) < offset:
            raise DamagedFile(f"{path}: the head has changed, or is cut off")
        if zlib.crc32(head[:-4]) != int.from_bytes(head[-4:], "little"):
            raise DamagedFile(f"{path}: the head (bytes 0 to {offset}) has changed")
        self.points = np.frombuffer(head, "<f8", 3 * points, self.HEAD).reshape(points, 3)
        numbers = np.frombuffer(head, "<u4", faces + vertices, self.HEAD + 24 * points)
        self.faces = np.split(numbers[faces:], np.cumsum(numbers[:faces])[:-1])
        record = np.dtype(
            [
                ("time_s", "<f8"),
                ("number", "<u4"),
                ("wall_shear_Pa", "<f4", (faces, 3)),
                ("displacement_m", "<f4", (points, 3)),
                ("checksum", "<u4"),
            ]
        )
        count = (path.stat().st_size - offset) // record.itemsize
        self.steps = np.memmap(path, record, "r", offset, count) if count else np.empty(0, record)
        if check:
            for number, step in enumerate(self.steps):
                if step["number"] != number or zlib.crc32(step.tobytes()[:-4]) != step["checksum"]:
                    place = offset + number * record.itemsize
                    raise DamagedFile(f"{path}: record {number} (from byte {place}) has changed")

    @property
    def time_s(self):
        return self.steps["time_s"]

    @property
    def wall_shear_Pa(self):
        return self.steps["wall_shear_Pa"]

    @property
    def displacement_m(self):
        return self.steps["displacement_m"]

    def centres(self):
        """Centres of the unloaded faces, (F, 3), m."""
        return np.array([self.points[face].mean(axis=0) for face in self.faces])

    def averages(self, start_s, end_s):
        """TAWSS (Pa) and OSI of each face over start < t <= end, with the shear of each step held over the step."""
        longest = np.median(np.diff(self.time_s, prepend=0.0))
        step = np.minimum(np.diff(self.time_s, prepend=0.0), longest)
        inside = (self.time_s > start_s + 0.5 * step) & (self.time_s < end_s + 0.5 * step)
        if not inside.any():
            raise ValueError(f"no step in {start_s} s < t <= {end_s} s")
        weight = step[inside] / step[inside].sum()
        shear = self.wall_shear_Pa[inside].astype(float)
        mean = np.einsum("n,nfc->fc", weight, shear)
        tawss = np.einsum("n,nf->f", weight, np.linalg.norm(shear, axis=2))
        osi = np.zeros_like(tawss)
        moved = tawss > 0
        osi[moved] = 0.5 * (1 - np.linalg.norm(mean[moved], axis=1) / tawss[moved])
        return tawss, osi


def _first(path, count):
    with open(path, "rb") as file:
        return file.read(count)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    try:
        run = Run(sys.argv[1])
        history, wall = run.history, run.wall
    except (OSError, DamagedFile) as error:
        sys.exit(f"error: {error}")
    print(f"{history.size} steps to t = {history['time_s'][-1]} s: " + ", ".join(history.dtype.names))
    print(f"wall.bin: {wall.steps.size} steps, {len(wall.faces)} faces, {len(wall.points)} points")
    for region in run.hemodynamics["regions"]:
        tawss, osi = region["TAWSS_Pa"]["mean"], region["OSI"]["max"]
        print(f"{region['name']}: mean TAWSS {tawss:.4g} Pa, largest OSI {osi:.4g}")


if __name__ == "__main__":
    main()
