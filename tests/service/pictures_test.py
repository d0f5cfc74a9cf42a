#!/usr/bin/python3
"""Every picture of the documentation, made anew from real runs: in the folder DCCAST_PICTURES, from where they are
copied to docs/images when what they show has changed. The script states which picture comes from where."""
import os
import pathlib
import re
import subprocess
import time

import dccast
import matplotlib
import matplotlib.image
import numpy as np
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from dashboard_test import CASES, InBrowser
from support import BIN, main

ROOT = pathlib.Path(__file__).resolve().parents[2]
MADE = os.environ.get("DCCAST_PICTURES", "pictures")


class Pictures(InBrowser):
    worker = "dccast-worker"
    files = (os.path.join(CASES, "start-2d-thickness.toml"),)

    def setUp(self):
        os.makedirs(MADE, exist_ok=True)
        super().setUp()
        self.browser.set_window_size(1180, 1400)

    def made(self, name):
        return os.path.abspath(os.path.join(MADE, name))

    def dccast(self, *words):
        done = subprocess.run([os.path.join(BIN, "dccast"), "--server", self.daemon.address, *words],
                              capture_output=True, text=True, timeout=300, check=False, cwd=self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout.strip()

    def show(self, file, selector="body"):
        self.browser.get("file://" + os.path.join(self.folder, file))
        return self.find(selector)

    def seen(self, name):
        """A picture shows something: many colours, and no single one fills it."""
        pixels = matplotlib.image.imread(self.made(name))[:, :, :3]
        colours, counts = np.unique(pixels.reshape(-1, 3), axis=0, return_counts=True)
        self.assertGreater(len(colours), 20, name)
        self.assertLess(counts.max() / counts.sum(), 0.97, name)
        return pixels.shape[1], pixels.shape[0]

    def test_report_drawing_and_page(self):
        job = self.dccast("submit", "--set", "quality=engineering", os.path.join(CASES, "start-3d.toml"))
        self.dccast("wait", job)
        self.dccast("report", job, "-o", "report.html")
        again = self.another()
        self.show("report.html")
        self.browser.save_screenshot(self.made("report.png"))
        self.find("body.complete", 60)
        self.find(".drawn .stage").screenshot(self.made("quarter-slab.png"))
        self.dccast("validate", os.path.join(CASES, "start-3d.toml"), "--drawing", "drawing.html")
        self.show("drawing.html", ".drawn .pair").screenshot(self.made("casting-drawing.png"))
        self.browser.get(again)
        self.browser.set_window_size(1100, 900)
        self.go(f"job/{job}")
        self.find("canvas[aria-label^='Temperature']", 60)
        self.find("select[aria-label=Field] option[value=von_mises_pa]").click()
        self.find("canvas[aria-label^='Stress']", 60)
        self.find(".cuts option[value='1']").click()
        self.find("canvas").click()
        time.sleep(1)
        self.find(".job-parts").screenshot(self.made("dashboard-slab.png"))
        for name in ("report.png", "quarter-slab.png", "casting-drawing.png", "dashboard-slab.png"):
            self.seen(name)

    def test_what_if(self):
        self.browser.set_window_size(1100, 800)
        self.go("what-if")
        self.wait_for("As it is: corner", seconds=60)
        slider = self.find("#cooling-bottom_block-temperature-offset")
        for _ in range(12):
            slider.send_keys(Keys.ARROW_RIGHT)
        self.wait_for("Changed: corner", seconds=60)
        time.sleep(1)
        self.browser.save_screenshot(self.made("dashboard-what-if.png"))
        self.seen("dashboard-what-if.png")

    def test_new_case(self):
        self.browser.set_window_size(1100, 1200)
        self.go("new")
        self.find("#found svg.casting", 60)
        self.browser.save_screenshot(self.made("dashboard-new-case.png"))
        self.seen("dashboard-new-case.png")

    def test_python_excel_and_paraview(self):
        matplotlib.use("Agg")
        service = dccast.connect(self.daemon.address)
        job = service.submit("start-2d-thickness", quality="draft").wait()
        axes = job.plot()
        axes.figure.set_size_inches(7, 4)
        axes.figure.savefig(self.made("python-curl.png"), dpi=110, bbox_inches="tight")
        self.seen("python-curl.png")
        frame = (1000 * job.curl_frame().drop(columns="beyond_validity")).round(3)
        frame.columns = [name.removesuffix("_m") + "_mm" for name in frame.columns]
        frame.iloc[:: len(frame) // 30].to_csv(os.path.join(self.folder, "curl.csv"))
        with self.subTest("a spreadsheet opens the table"):
            for words in (["soffice", f"-env:UserInstallation=file://{self.folder}/office", "--headless",
                           "--convert-to", "pdf", "curl.csv"],
                          ["pdftoppm", "-png", "-singlefile", "-r", "100", "-x", "60", "-y", "60", "-W",
                           "640", "-H", "300", "curl.pdf", self.made("excel-curl")]):
                subprocess.run(words, cwd=self.folder, capture_output=True, timeout=120, check=True)
            self.seen("excel-curl.png")
        slab = self.dccast("submit", "--set", "quality=draft", os.path.join(CASES, "start-3d.toml"))
        self.dccast("wait", slab)
        self.dccast("fetch", slab, "-o", "run.h5")
        with self.subTest("ParaView draws the slab"):
            subprocess.run(["xvfb-run", "-a", "pvpython", os.path.join(ROOT, "docs", "paraview_slab.py"),
                            "./run.xdmf", self.made("paraview-slab.png")], cwd=self.folder,
                           capture_output=True, timeout=180, check=True)
            self.seen("paraview-slab.png")


class Pages(InBrowser):
    def test_pages_show_no_other_pictures(self):
        pages = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
        shown = {name for page in pages
                 for name in re.findall(r"images/([\w-]+\.png)", page.read_text(encoding="utf-8"))}
        script = pathlib.Path(__file__).read_text(encoding="utf-8")
        kept = {path.name for path in (ROOT / "docs" / "images").iterdir()}
        self.assertEqual(shown, kept)
        self.assertEqual([name for name in sorted(shown) if f'"{name}"' not in script], [])


if __name__ == "__main__":
    main()
