"""The program itself: where it is, and runs of it."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import sysconfig
import tempfile
import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from .case import Case, _value
from .results import Run

Progress = Callable[[float, float], None]


class FailedRun(RuntimeError):
    """The program refused a case (`code` 2) or a run failed; the text is what the program said."""

    def __init__(self, message: str, code: int) -> None:
        super().__init__(message)
        self.code = code


def program() -> str:
    """The program: what the variable FSI_DRIVER names, or else the one installed with this package, or on the path."""
    named = os.environ.get("FSI_DRIVER")
    if named:
        return named
    schemes = [sysconfig.get_path("scripts"), sysconfig.get_path("scripts", f"{os.name}_user")]
    # Installed with `pip install --target`, the program lies next to the package.
    folders = [*filter(None, schemes), str(Path(__file__).resolve().parents[1] / "bin")]
    found = shutil.which("fsi-driver", path=os.pathsep.join(folders)) or shutil.which("fsi-driver")
    if not found:
        raise FileNotFoundError("there is no program fsi-driver: pip install fsi-driver, or set FSI_DRIVER to its path")
    return found


def version() -> str:
    """Version of the program, which is that of this package."""
    said = subprocess.run([program(), "--version"], capture_output=True, text=True, check=True).stdout
    return said.split()[1]


def run(
    case: str | os.PathLike[str] | Case,
    out: str | os.PathLike[str] | None = None,
    *,
    preset: str = "paper",
    fluid: str | None = None,
    end_time: float | None = None,
    ranks: int | None = None,
    set: Mapping[str, Any] | None = None,
    resume: bool = False,
    force: bool = False,
    progress: bool | Progress | None = None,
) -> Run:
    """Runs a case to its end and returns what it left.

    case      folder with a `case.toml`, that file, or a `Case` (which is written into the folder `out`-case)
    out       folder of the results; `run-PRESET` in the folder of the case if left out
    set       values that replace those of the case, by their dotted names
    progress  True for a line on standard error, or a function of the time reached and the end, s

    Ctrl-C lets the program finish its step and write a checkpoint; `resume=True` goes on from there.
    Raises FailedRun if the program refuses the case or fails.
    """
    if isinstance(case, Case):
        if out is None:
            raise ValueError("a Case that was not written needs `out`, the folder of the results")
        case = case.write(f"{os.fspath(out).rstrip('/')}-case")
    path = Path(case)
    folder = path if path.is_dir() else path.parent
    results = Path(out) if out is not None else folder / f"run-{preset}"
    command = [program(), "--case", str(path), "--preset", preset, "--out", str(results), "--quiet"]
    options = {"--fluid": fluid, "--end-time": end_time, "--ranks": ranks}
    for option, value in options.items():
        command += [] if value is None else [option, str(value)]
    for key, value in (set or {}).items():
        command += ["--set", f"{key}={_value(value)}"]
    command += ["--resume"] * resume + ["--force"] * force
    show = _line if progress is True else (progress or None)
    with tempfile.TemporaryFile("w+") as said:
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=said)
        try:
            _wait(process, results, show)
        except BaseException:
            process.send_signal(signal.SIGINT)
            process.wait()
            raise
        finally:
            if show is _line:
                print(file=sys.stderr)
        said.seek(0)
        text = said.read().strip()
    if process.returncode != 0:
        raise FailedRun(text or f"fsi-driver ended with {process.returncode}", process.returncode)
    return Run(results)


def _wait(process: subprocess.Popen[bytes], results: Path, show: Progress | None) -> None:
    end = None
    before = (results / "case.resolved.toml").stat().st_mtime_ns if (results / "case.resolved.toml").exists() else 0
    while True:
        try:
            process.wait(0.2)
        except subprocess.TimeoutExpired:
            pass
        if show:
            record = results / "case.resolved.toml"
            if end is None and record.exists() and record.stat().st_mtime_ns != before:
                end = float(tomllib.loads(record.read_text(encoding="utf-8"))["time"]["end_s"])
            reached = _reached(results / "history.csv") if end is not None else None
            if reached is not None and end is not None:
                show(reached, end)
        if process.returncode is not None:
            return


def _reached(history: Path) -> float | None:
    """The time of the last whole row."""
    try:
        with open(history, "rb") as file:
            names = file.readline().decode().strip().split(",")
            file.seek(max(file.tell(), history.stat().st_size - 4096))
            rows = file.read().split(b"\n")[:-1]
        return float(rows[-1].split(b",")[names.index("time_s")])
    except (OSError, IndexError, ValueError):
        return None


def _line(reached: float, end: float) -> None:
    share = reached / end if end > 0 else 1.0
    print(f"\rt = {reached:.4g} s of {end:.4g} s ({share:.0%})", end="", file=sys.stderr, flush=True)
