#!/usr/bin/env python3
"""Three sizes of the paper's imperfection with the native fluid, and what they do to the wall shear of the artery.

    pip install dist/fsi_driver-*.whl      # docs/dist/make.sh makes it
    examples/python/imperfections.py FOLDER [END_S]
"""

import sys
from pathlib import Path

import fsi_driver


def main():
    if not 2 <= len(sys.argv) <= 3:
        sys.exit(__doc__)
    folder, end = Path(sys.argv[1]), float(sys.argv[2]) if len(sys.argv) == 3 else None
    for d_max_mm in (0.0, 0.25, 0.5):
        case = fsi_driver.Case({"extends": "defaults", "model.d_max_m": 1e-3 * d_max_mm})
        options = {"preset": "demo", "fluid": "native", "end_time": end, "progress": True}
        run = fsi_driver.run(case, folder / f"d-{d_max_mm}", **options)
        artery = run.region("artery")
        largest = artery["max_wall_shear_Pa"].max()
        volume = 1e6 * artery["lumen_volume_m3"][-1]
        print(f"d_max {d_max_mm} mm: largest wall shear {largest:.2f} Pa, lumen of the artery {volume:.4f} ml")


if __name__ == "__main__":
    main()
