"""python -m fsi_driver RUN says what a run holds."""

import sys

from . import DamagedFile, Run


def main() -> None:
    """Prints the steps, the columns, the wall, the regions and the outlets of the run that is named."""
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    try:
        run = Run(sys.argv[1])
        history, wall = run.history, run.wall
        print(f"{history.size} steps to t = {history['time_s'][-1]} s: " + ", ".join(history.dtype.names or ()))
        print(f"wall.bin: {wall.steps.size} steps, {len(wall.faces)} faces, {len(wall.points)} points")
    except (OSError, DamagedFile) as error:
        sys.exit(f"error: {error}")
    for region in run.hemodynamics["regions"]:
        tawss, osi = region["TAWSS_Pa"]["mean"], region["OSI"]["max"]
        print(f"{region['name']}: mean TAWSS {tawss:.4g} Pa, largest OSI {osi:.4g}")
    for opening in run.summary.get("openings", []):
        if share := opening.get("share_of_outflow"):
            outflow = 1e6 * opening["mean_outflow_m3_s"]
            print(f"{opening['opening']}: mean outflow {outflow:.4g} ml/s, {100 * share:.3g} % of all")


if __name__ == "__main__":
    main()
