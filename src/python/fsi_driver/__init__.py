"""Fluid-structure interaction of arteries with fsi-driver: writes cases, runs them, reads what runs leave.

    case = fsi_driver.Case({"extends": "defaults"})
    case["time.end_s"] = 0.02
    case.write("my-case")
    run = fsi_driver.run("my-case", preset="demo", fluid="native", progress=True)
    run.history["time_s"], run.frame("regions"), run.wall.wall_shear_Pa, run.map()

numpy is needed; `frame` needs pandas, `map` and `fields` need pyvista.
"""

from .case import Case
from .program import FailedRun, program, run, version
from .results import DamagedFile, Run, Wall

__all__ = ["Case", "DamagedFile", "FailedRun", "Run", "Wall", "program", "run", "version"]


def __getattr__(name: str) -> str:
    if name == "__version__":
        return version()
    raise AttributeError(f"module 'fsi_driver' has no attribute {name!r}")
