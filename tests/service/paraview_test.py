#!/usr/bin/python3
"""ParaView opens what `dccast fetch` stored as a slab that deforms. Skipped where it is not installed."""
import json
import os
import shutil
import subprocess
import unittest

import h5py
import numpy as np
from support import ServiceTest, main
from waiting import WAIT_FACTOR

HERE = os.path.dirname(os.path.abspath(__file__))
CASES = os.path.join(HERE, "..", "..", "cases")
PVPYTHON = shutil.which("pvpython")
NODE_FIELDS = {"temperature_c", "displacement_m", "solid_fraction", "contact_pressure_pa"}
ELEMENT_FIELDS = {"stress_pa", "viscoplastic_strain", "von_mises_pa"}


@unittest.skipUnless(PVPYTHON, "pvpython is not installed")
class ParaView(ServiceTest):
    worker = "dccast-worker"

    def read(self, case):
        """The stored file, and what each reader of ParaView makes of it."""
        self.dccast("submit", "--watch", os.path.join(CASES, case), "--set", "quality=draft",
                    "--set", "time.end=15 s")
        self.dccast("fetch", "last", "-o", self.in_folder("run.h5"))
        said = subprocess.run([PVPYTHON, os.path.join(HERE, "paraview_reads.py"), "./run.xdmf"],
                              cwd=self.folder, capture_output=True, text=True, timeout=120 * WAIT_FACTOR,
                              check=True)
        return h5py.File(self.in_folder("run.h5")), json.loads(said.stdout)

    def check(self, case, dimension):
        file, readers = self.read(case)
        frames = file["frames"]
        last = frames[sorted(frames)[-1]]
        flat = np.zeros((len(last["node_m"]), 3 - dimension))
        points = np.hstack([last["node_m"], flat])
        moved = points + np.hstack([last["displacement_m"], flat])
        for name, seen in readers.items():
            with self.subTest(reader=name):
                self.assertEqual(seen["times"], [frames[key].attrs["time_s"] for key in sorted(frames)])
                np.testing.assert_allclose(seen["points"], points, rtol=0, atol=1e-6)  # floats there
                self.assertEqual(seen["cells"], len(last["element_node"]))
                self.assertLessEqual(NODE_FIELDS, set(seen["point_fields"]))
                self.assertLessEqual(ELEMENT_FIELDS, set(seen["cell_fields"]))
                for field in ("temperature_c", "solid_fraction", "contact_pressure_pa"):
                    np.testing.assert_array_equal(seen["point_fields"][field], last[field])
                np.testing.assert_array_equal(seen["cell_fields"]["von_mises_pa"], last["von_mises_pa"])
                bounds = np.stack([moved.min(axis=0), moved.max(axis=0)], axis=1).ravel()
                np.testing.assert_allclose(seen["warped_bounds"], bounds, rtol=0, atol=1e-6)

    def test_a_quarter_slab(self):
        self.check("start-3d.toml", 3)

    @unittest.skipUnless(shutil.which("xvfb-run"), "xvfb is not installed")
    def test_the_script_of_the_docs_draws_without_a_display(self):
        self.dccast("submit", "--watch", os.path.join(CASES, "start-3d.toml"), "--set", "quality=draft",
                    "--set", "time.end=15 s")
        self.dccast("fetch", "last", "-o", self.in_folder("run.h5"))
        for name in ("run.xdmf", "run-end.xdmf"):
            drawn = subprocess.run([PVPYTHON, os.path.join(HERE, "..", "..", "docs", "paraview_slab.py"), name],
                                   cwd=self.folder, capture_output=True, text=True, timeout=120 * WAIT_FACTOR,
                                   env={name: value for name, value in os.environ.items() if name != "DISPLAY"},
                                   check=False)
            self.assertEqual(drawn.returncode, 0, drawn.stderr)
            self.assertGreater(os.path.getsize(drawn.stdout.strip()), 10_000)

    def test_a_section(self):
        self.check("start-2d-thickness.toml", 2)


if __name__ == "__main__":
    main()
