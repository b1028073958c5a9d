"""What a run leaves: tables, figures and the wall as numpy, tables for pandas, maps and fields for pyvista."""

from __future__ import annotations

import gzip
import json
import tomllib
import zlib
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pandas
    import pyvista


class DamagedFile(Exception):
    """A file is not what fsi-driver has written; the text says which, where and what is wrong."""


class Run:
    """The folder of a run. Files are read when they are asked for."""

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder)
        if not (self.folder / "case.resolved.toml").is_file():
            raise FileNotFoundError(f"{folder} is not the folder of a run (it holds no case.resolved.toml)")

    def __repr__(self) -> str:
        return f"Run({str(self.folder)!r})"

    def _lines(self, name: str) -> list[str]:
        """The whole lines of a table, which may be compressed."""
        path = self.folder / (name if name.endswith(".csv") else f"{name}.csv")
        if path.is_file():
            text = path.read_text(encoding="utf-8")
        else:
            packed = path.with_name(path.name + ".gz")
            if not packed.is_file():
                raise FileNotFoundError(f"the run {self.folder} holds no {path.name}")
            text = gzip.decompress(packed.read_bytes()).decode("utf-8")
        return text[: text.rfind("\n") + 1].splitlines()

    def table(self, name: str) -> NDArray[Any]:
        """A table ("history", "regions.csv") as a structured array: a field a column, a record a row.

        A last row that is cut off is left out. What is empty is NaN, or an empty text.
        """
        lines = self._lines(name)
        rows = np.genfromtxt(lines, delimiter=",", names=True, dtype=None, encoding="utf-8", deletechars="")
        return np.atleast_1d(rows)

    def frame(self, name: str = "history") -> pandas.DataFrame:
        """The same table as a DataFrame. Needs pandas."""
        import io

        import pandas

        return pandas.read_csv(io.StringIO("\n".join(self._lines(name))))

    @property
    def tables(self) -> list[str]:
        """Names of the tables that there are."""
        return sorted(path.name.split(".")[0] for path in self.folder.glob("*.csv*"))

    @property
    def history(self) -> NDArray[Any]:
        """One row per time step."""
        return self.table("history")

    @property
    def iterations(self) -> NDArray[Any]:
        """One row per coupling iteration."""
        return self.table("iterations")

    @property
    def regions(self) -> NDArray[Any]:
        """One row per time step and region."""
        return self.table("regions")

    def region(self, name: str) -> NDArray[Any]:
        """The rows of one region: "bypass", "artery" or "mid_artery"."""
        regions = self.regions
        rows: NDArray[Any] = regions[regions["region"] == name]
        return rows

    @property
    def openings(self) -> NDArray[Any]:
        """One row per time step and opening."""
        return self.table("openings")

    def opening(self, name: str) -> NDArray[Any]:
        """The rows of one opening: "inlet", "outlet" or as the case names it."""
        openings = self.openings
        rows: NDArray[Any] = openings[openings["opening"] == name]
        return rows

    @property
    def probes(self) -> NDArray[Any]:
        """One row per time step and probe."""
        return self.table("probes")

    @property
    def fluid_probes(self) -> NDArray[Any]:
        """One row per time step and probe in the blood; NaN where that is not in the blood."""
        return self.table("fluid-probes")

    @property
    def phases(self) -> NDArray[Any]:
        """One row per phase of the period, averaged over beats (`fsi-driver hemodynamics RUN --phases N`)."""
        return self.table("phases")

    @property
    def wall_shear(self) -> NDArray[Any]:
        """One row per face of the wall: TAWSS, OSI and RRT over the evaluated window."""
        return self.table("wall-shear")

    @property
    def resolution(self) -> NDArray[Any]:
        """One row per face of the wall: how well the flow is resolved there."""
        return self.table("resolution")

    @property
    def hemodynamics(self) -> dict[str, Any]:
        """The evaluated window in figures."""
        return _json(self.folder / "hemodynamics.json")

    @property
    def summary(self) -> dict[str, Any]:
        """The run in figures; "openings" has mean outflow, share of all that leaves, and pressures of each."""
        return _json(self.folder / "summary.json")

    @property
    def case(self) -> dict[str, Any]:
        """Every value that was used."""
        return tomllib.loads((self.folder / "case.resolved.toml").read_text(encoding="utf-8"))

    @cached_property
    def wall(self) -> Wall:
        """The wall at every step."""
        return Wall(self.folder / "wall.bin")

    def map(self) -> pyvista.PolyData:
        """The wall with TAWSS, OSI, RRT and all other columns of `wall_shear` on its faces. Needs pyvista."""
        surface = self.wall.surface()
        rows = self.wall_shear
        for name in rows.dtype.names or ():
            surface.cell_data[name] = rows[name]
        return surface

    def fields(self, name: str = "fluid", time_s: float | None = None) -> pyvista.DataSet:
        """A field in space at the written time nearest to `time_s`, the last if left out. Needs pyvista.

        name  "fluid" (native fluid: velocity and pressure), "structure" (displacement, stresses), "wall-shear"
              or "wall-shear-over-time"; of OpenFOAM's blood as well "openfoam"
        """
        import pyvista

        reader: Any
        field: pyvista.DataSet
        if name == "fluid" and not (self.folder / "fluid.pvd").is_file() or name == "openfoam":
            reader = pyvista.OpenFOAMReader(str(self.folder / "openfoam/fluid.foam"))
            reader.set_active_time_value(_nearest(reader.time_values, time_s))
            field = reader.read()["internalMesh"]
            return field
        path = self.folder / f"{name}.pvd"
        if not path.is_file():
            raise FileNotFoundError(f"the run {self.folder} holds no {path.name}")
        reader = pyvista.PVDReader(str(path))
        reader.set_active_time_value(_nearest(reader.time_values, time_s))
        field = reader.read()[0]
        return field


def _nearest(times: list[float], time_s: float | None) -> float:
    return times[-1] if time_s is None else min(times, key=lambda time: abs(time - time_s))


def _json(path: Path) -> dict[str, Any]:
    """JSON with the texts for numbers that it does not know as such."""
    special = {"Infinity": np.inf, "-Infinity": -np.inf, "NaN": np.nan}

    def number(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: number(item) for key, item in value.items()}
        if isinstance(value, list):
            return [number(item) for item in value]
        return special.get(value, value) if isinstance(value, str) else value

    whole: dict[str, Any] = number(json.loads(path.read_text(encoding="utf-8")))
    return whole


class Wall:
    """`wall.bin`: the wet surface, its shear stress and its displacement at every step.

    points         (P, 3) positions of the unloaded wall, m
    faces          list of F arrays of numbers of points; normals point out of the blood
    time_s         (N,)
    wall_shear_Pa  (N, F, 3) of each face
    displacement_m (N, P, 3) of each point
    """

    HEAD = 24

    def __init__(self, path: str | Path, check: bool = True) -> None:
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
    def time_s(self) -> NDArray[np.float64]:
        """Time of each step."""
        return self.steps["time_s"]

    @property
    def wall_shear_Pa(self) -> NDArray[np.float32]:
        """Wall shear stress of each step and face."""
        return self.steps["wall_shear_Pa"]

    @property
    def displacement_m(self) -> NDArray[np.float32]:
        """Displacement of each step and point."""
        return self.steps["displacement_m"]

    def centres(self) -> NDArray[np.float64]:
        """Centres of the unloaded faces, (F, 3), m."""
        return np.array([self.points[face].mean(axis=0) for face in self.faces])

    def surface(self, step: int | None = None) -> pyvista.PolyData:
        """The unloaded wall, or that of a step with its shear stress and displacement. Needs pyvista."""
        import pyvista

        faces = np.concatenate([np.r_[len(face), face] for face in self.faces])
        if step is None:
            return pyvista.PolyData(self.points.copy(), faces)
        surface = pyvista.PolyData(self.points + self.displacement_m[step], faces)
        surface.cell_data["wall_shear_Pa"] = self.wall_shear_Pa[step]
        surface.point_data["displacement_m"] = self.displacement_m[step]
        return surface

    def averages(self, start_s: float, end_s: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
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


def _first(path: Path, count: int) -> bytes:
    with open(path, "rb") as file:
        return file.read(count)
