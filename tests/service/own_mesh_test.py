#!/usr/bin/python3
"""A mesh of one's own, as docs/own-mesh.md writes it: it travels with the case, two of them give an error, and a
plan grows."""
import pathlib
import re

import numpy as np

import dccast
from support import ServiceTest, main

ROOT = pathlib.Path(__file__).resolve().parents[2]
CASE = (ROOT / "cases/start-2d-thickness.toml").read_text(encoding="utf-8")


SLAB = (ROOT / "cases/start-3d.toml").read_text(encoding="utf-8")


def writers_of_the_page():
    page = (ROOT / "docs/own-mesh.md").read_text(encoding="utf-8")
    names = {}
    exec(re.search(r"```python\n(.*?)```", page, re.DOTALL)[1], names)
    return names["write_section"], names["write_plan"]


class OwnMesh(ServiceTest):
    worker = "dccast-worker"

    def setUp(self):
        super().setUp()
        self.write, self.write_plan = writers_of_the_page()
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

    def test_the_mesh_of_a_section_cannot_grow(self):
        with self.assertRaises(dccast.DccastError) as refused:
            self.query(0.02, 2, growth="true")
        self.assertIn("cannot grow: it has no rows", str(refused.exception))

    def cast(self, mesh, x_m, y_m):
        """The curl at a place of the butt in the first seconds of a slab."""
        path = pathlib.Path(self.folder) / "slab.toml"
        case = re.sub(r"\[\[monitor\]\].*", "", SLAB, flags=re.DOTALL)
        path.write_text(f'{case}[mesh]\n{mesh}\n[[monitor]]\nname = "corner"\n'
                        f'x = "{x_m} m"\ny = "{y_m} m"\nz = "0 m"\n')
        curl = self.service.query(str(path), {"quality": "draft", "time.end": "10 s"}).curl
        return curl["corner_curl_m"][-1], curl["corner_upper_error_m"][-1]

    def test_a_plan_grows_like_the_built_in_mesh(self):
        self.write_plan(pathlib.Path(self.folder) / "plan.msh", [0.11 * i for i in range(7)],
                        [0.095 * j for j in range(4)], lambda x, y: True)
        own, error = self.cast('file = "plan.msh"', 0.66, 0.285)
        built_in, _ = self.cast("columns = 6\nlayers = 3", 0.66, 0.285)
        self.assertNotEqual(own, 0.0)
        self.assertAlmostEqual(own, built_in, delta=1e-6 * abs(built_in))
        self.assertTrue(np.isnan(error))

        with self.assertRaises(dccast.DccastError) as refused:
            self.cast('file = "plan.msh"\ngrowth = false', 0.66, 0.285)
        self.assertIn("is a flat mesh", str(refused.exception))

    def test_a_plan_may_have_an_inner_corner(self):
        self.write_plan(pathlib.Path(self.folder) / "plan.msh", [0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.66],
                        [0, 0.08, 0.15, 0.22, 0.285], lambda x, y: x < 0.3 or y < 0.15)
        curl, _ = self.cast('file = "plan.msh"', 0.66, 0.15)
        self.assertTrue(np.isfinite(curl))
        self.assertNotEqual(curl, 0.0)


if __name__ == "__main__":
    main()
