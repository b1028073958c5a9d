"""Two other programs read a study of uncertain inputs: SALib beside the driver's own indices, and EasyVVUQ.

    fsi-driver study --cases examples/uncertainty --samples pce:2 --export salib,easyvvuq --out study
    pip install SALib easyvvuq
    python3 examples/python/sensitivity.py study
"""

import csv
import json
import sys
from pathlib import Path

import numpy as np


def with_salib(folder: Path) -> None:
    """First-order indices of the given samples by SALib (RBD-FAST), beside those of indices.csv."""
    from SALib.analyze import rbd_fast

    study = json.loads((folder / "salib.json").read_text())
    problem, x = study["problem"], np.array(study["X"])
    with open(folder / "indices.csv", newline="") as file:
        own = {(row["measure"], row["input"]): float(row["first-order index"]) for row in csv.DictReader(file)}
    for measure, values in study["Y"].items():
        if None in values:  # some runs lack it
            continue
        found = rbd_fast.analyze(problem, x, np.array(values), M=4, seed=1)
        print(measure)
        for name, index, interval in zip(problem["names"], found["S1"], found["S1_conf"]):
            print(f"  {name:12} SALib {index:6.3f} +- {interval:.3f}, driver {own.get((measure, name), 0.0):6.3f}")


def with_easyvvuq(folder: Path):
    """The runs as a campaign of EasyVVUQ; its table has a row for each run."""
    import easyvvuq as uq
    from easyvvuq.actions import Actions

    runs = sorted(str(path) for path in (folder / "easyvvuq" / "runs").glob("*.json"))
    params = json.loads((folder / "easyvvuq" / "params.json").read_text())
    values = json.loads(Path(runs[0]).read_text())
    measures = [name for name in values if name not in params]
    campaign = uq.Campaign(name="study", params=params, actions=Actions(), work_dir=str(folder / "easyvvuq"))
    decoder = uq.decoders.JSONDecoder
    campaign.add_external_runs(runs, runs, decoder("", list(params)), decoder("", measures))
    table = campaign.get_collation_result()
    print(f"EasyVVUQ has {len(table)} runs with {len(params)} inputs and {len(measures)} measures")
    return table


if __name__ == "__main__":
    study = Path(sys.argv[1])
    with_salib(study)
    with_easyvvuq(study)
