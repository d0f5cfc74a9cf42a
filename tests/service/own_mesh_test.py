#!/usr/bin/python3
"""A mesh of one's own, as docs/own-mesh.md writes it: it travels with the case, and two of them give an error."""
import pathlib
import re

import numpy as np

import dccast
from support import ServiceTest, main

ROOT = pathlib.Path(__file__).resolve().parents[2]
CASE = (ROOT / "cases/start-2d-thickness.toml").read_text(encoding="utf-8")


def writer_of_the_page():
    page = (ROOT / "docs/own-mesh.md").read_text(encoding="utf-8")
    names = {}
    exec(re.search(r"```python\n(.*?)```", page, re.DOTALL)[1], names)
    return names["write_section"]


class OwnMesh(ServiceTest):
    worker = "dccast-worker"

    def setUp(self):
        super().setUp()
        self.write = writer_of_the_page()
        self.service = dccast.connect(self.daemon.address)

    def query(self, cell_m, step_s, growth="false"):
        folder = pathlib.Path(self.folder)
        name = f"cells-{1e3 * cell_m:.0f}.msh"
        self.write(folder / name, 0.28, 0.10, cell_m)
        case = CASE.replace("\n[mesh]", f'\n[mesh]\nfile = "{name}"\ngrowth = {growth}')
        (folder / "case.toml").write_text(case)
        return self.service.query(str(folder / "case.toml"), {
            "schedule.casting_speed": "0 mm/min", "time.end": "40 s", "time.step": f"{step_s} s"})

    def test_two_meshes_give_an_error_that_holds_a_third(self):
        answers = [self.query(*size) for size in ((0.02, 2), (0.01, 1), (0.005, 0.5))]
        for answer in answers:
            # Nothing is known of such a mesh.
            self.assertTrue(np.isnan(answer.curl["corner_upper_error_m"]).all())
        coarse, fine, truth = (answer.curl["corner_curl_m"][-1] for answer in answers)
        self.assertNotEqual(coarse, fine)
        self.assertLess(abs(truth - fine), 3.0 * abs(fine - coarse))

    def test_a_mesh_cannot_grow(self):
        with self.assertRaises(dccast.DccastError) as refused:
            self.query(0.02, 2, growth="true")
        self.assertIn("an imported mesh cannot grow", str(refused.exception))


if __name__ == "__main__":
    main()
