"""Tests of the installed package with the program that it carries; docs/dist/try.sh runs them."""

import importlib.util
import subprocess
import sys
import tempfile
import tomllib
import unittest
from pathlib import Path

import fsi_driver

SHORT = {"preset": "demo", "fluid": "native", "end_time": 0.006}


class Package(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def test_the_version_is_that_of_the_program(self):
        from importlib.metadata import version

        self.assertEqual(version("fsi-driver"), fsi_driver.version())
        self.assertEqual(fsi_driver.__version__, fsi_driver.version())

    def test_a_case_is_written_as_it_was_read(self):
        keys = {
            "extends": "defaults",
            "vessel": {"length_m": 0.04, "section": [{"name": "a \"b\" µ", "to_m": 0.04}], "points": [[0.0, 1e-3], [1, 2]]},
            "time": {"end_s": 0.1},
            "fluid": {"mesh": {"core": 4}, "odd key": True},
        }
        case = fsi_driver.Case(keys)
        case["time.step_s"] = 5e-3
        read = fsi_driver.Case.read(case.write(self.folder / "new/case"))
        self.assertEqual(read.keys_by_table, tomllib.loads(case.text()))
        self.assertEqual(read["time.step_s"], 5e-3)
        self.assertEqual(read["vessel.section"][0]["name"], 'a "b" µ')
        self.assertIn("fluid.mesh.core", list(read))
        del read["time.step_s"]
        self.assertNotIn("time.step_s", read)
        with self.assertRaisesRegex(TypeError, "time.end_s.x: end_s is a value"):
            read["time.end_s.x"] = 1
        with self.assertRaisesRegex(TypeError, "a case cannot hold"):
            fsi_driver.Case({"a": object()}).text()

    def test_a_run_is_made_and_read(self):
        case = fsi_driver.Case({"extends": "defaults", "model.d_max_m": 0.25e-3})
        seen = []
        run = fsi_driver.run(case, self.folder / "run", progress=lambda *times: seen.append(times), **SHORT)
        self.assertEqual(run.history["time_s"].tolist(), [0.002, 0.004, 0.006])
        self.assertEqual(seen[-1], (0.006, 0.006))
        self.assertEqual(run.summary["version"], fsi_driver.version())
        self.assertEqual(run.case["model"]["d_max_m"], 0.25e-3)
        self.assertEqual(run.wall.wall_shear_Pa.shape, (3, len(run.wall.faces), 3))
        self.assertEqual(run.opening("inlet").size, 3)
        for name in run.tables:
            self.assertGreater(run.table(name).size, 0, name)
        if importlib.util.find_spec("pandas"):
            self.assertEqual(run.frame()["time_s"].tolist(), run.history["time_s"].tolist())
        if importlib.util.find_spec("pyvista"):
            self.assertEqual(run.map().n_cells, len(run.wall.faces))
            self.assertIn("pressure_Pa", run.fields("fluid").array_names)
        longer = fsi_driver.run(self.folder / "run-case", self.folder / "run", resume=True, **SHORT | {"end_time": 0.008})
        self.assertEqual(longer.history.size, 4)
        said = subprocess.run([sys.executable, "-m", "fsi_driver", longer.folder], capture_output=True, text=True).stdout
        self.assertIn("4 steps to t = 0.008 s", said)

    def test_what_the_program_refuses_is_said(self):
        case = fsi_driver.Case({"extends": "defaults", "time.endd_s": 1.0}).write(self.folder / "case")
        with self.assertRaisesRegex(fsi_driver.FailedRun, "endd_s") as refused:
            fsi_driver.run(case, **SHORT)
        self.assertEqual(refused.exception.code, 2)
        with self.assertRaisesRegex(fsi_driver.FailedRun, "coupling.e_rel"):
            fsi_driver.run(fsi_driver.Case().write(self.folder / "good"), set={"coupling.e_rel": -1.0}, **SHORT)
        with self.assertRaisesRegex(FileNotFoundError, "not the folder of a run"):
            fsi_driver.Run(self.folder)

    def test_a_new_case_runs_without_the_sources(self):
        new = subprocess.run([fsi_driver.program(), "new", "vessel"], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(new.returncode, 0, new.stderr)
        self.assertEqual(fsi_driver.run(self.folder / "vessel", **SHORT).history.size, 3)


if __name__ == "__main__":
    unittest.main()
