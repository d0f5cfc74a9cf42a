#!/usr/bin/python3
"""The notebooks of docs/notebooks run from top to bottom on the real solver, and draw their charts."""
import os
import pathlib

import nbclient
import nbformat

from support import BIN, ServiceTest, main

NOTEBOOKS = pathlib.Path(__file__).resolve().parents[2] / "docs" / "notebooks"


class Notebooks(ServiceTest):
    worker = "dccast-worker"

    def test_every_notebook_runs(self):
        os.environ["DCCAST_SERVER"] = self.daemon.address
        os.environ["DCCAST_PROGRAM"] = os.path.join(BIN, "dccast")
        paths = sorted(NOTEBOOKS.glob("*.ipynb"))
        self.assertGreaterEqual(len(paths), 6)
        for path in paths:
            with self.subTest(path.name):
                notebook = nbformat.read(path, as_version=4)
                nbformat.validate(notebook)
                nbclient.NotebookClient(notebook, timeout=600).execute(cwd=self.folder)
                pictures = [output for cell in notebook.cells for output in cell.get("outputs", [])
                            if "image/png" in output.get("data", {})]
                self.assertGreaterEqual(len(pictures), 1)


if __name__ == "__main__":
    main()
