#!/usr/bin/python3
"""Every picture of the documentation, those of docs/dashboard.md among them, made anew from real runs: in the
folder DCCAST_PICTURES, from where they are copied to docs/images when what they show has changed. The script
states which picture comes from where."""
import os
import pathlib
import re
import subprocess
import time
import unittest

import dccast
import matplotlib
import numpy as np
import PIL.Image
from selenium.webdriver.common.keys import Keys

from dashboard_test import CASES, InBrowser
from dccast.v1 import job_pb2
from support import main
from wall_test import Wall
from waiting import until

ROOT = pathlib.Path(__file__).resolve().parents[2]
MADE = os.environ.get("DCCAST_PICTURES", "pictures")


class Camera(InBrowser):
    worker = "dccast-worker"
    files = (os.path.join(CASES, "start-2d-thickness.toml"),)

    def setUp(self):
        os.makedirs(MADE, exist_ok=True)
        super().setUp()
        self.browser.set_window_size(1180, 1400)

    def made(self, name):
        return os.path.abspath(os.path.join(MADE, name))

    def keep(self, name):
        """Reduces a picture to 256 colours, which takes a third of the bytes. It shows something: many
        colours, and no single one fills it."""
        with PIL.Image.open(self.made(name)) as taken:
            reduced = taken.convert("RGB").quantize(256, dither=PIL.Image.Dither.NONE)
        reduced.save(self.made(name), optimize=True)
        counts = np.array(reduced.histogram())
        self.assertGreater(np.count_nonzero(counts), 20, name)
        self.assertLess(counts.max() / counts.sum(), 0.97, name)
        self.assertLessEqual(reduced.width, 1200, name)

    def take(self, name, selector=""):
        """A picture of the page, or of a part of it, without the address of the test's own server."""
        self.browser.execute_script(
            "document.getElementById('server').style.visibility = 'hidden'")
        self.assertNotRegex(self.text("main"), r"/(home|root|tmp|work)/", name)
        if selector:
            self.find(selector).screenshot(self.made(name))
        else:
            self.browser.save_screenshot(self.made(name))
        self.keep(name)


class Pictures(Camera):
    def dccast(self, *words):
        return super().dccast(*words).strip()

    def show(self, file, selector="body"):
        self.browser.get("file://" + self.in_folder(file))
        return self.find(selector)

    def test_report_drawing_and_page(self):
        job = self.dccast("submit", "--set", "quality=engineering", os.path.join(CASES, "start-3d.toml"))
        self.dccast("wait", job)
        self.dccast("report", job, "-o", "report.html")
        again = f"http://127.0.0.1:{self.url.port}/"
        self.show("report.html")
        self.find("body.complete", 60)
        self.browser.save_screenshot(self.made("report.png"))
        # Paper shows three views side by side; the window holds all of them.
        self.browser.set_window_size(1180, 3000)
        self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
        self.find(".views").screenshot(self.made("quarter-slab.png"))
        self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
        self.browser.set_window_size(1180, 1400)
        self.dccast("validate", os.path.join(CASES, "start-3d.toml"), "--drawing", "drawing.html")
        self.show("drawing.html", ".drawn .pair").screenshot(self.made("casting-drawing.png"))
        self.browser.get(again)
        self.browser.set_window_size(1100, 1500)
        self.go(f"job/{job}")
        self.find("canvas[aria-label^='Temperature']", 60)
        self.find("select[aria-label=Field] option[value=von_mises_pa]").click()
        self.find("canvas[aria-label^='Stress']", 60)
        self.find(".cuts option[value='1']").click()
        self.find("canvas").click()
        time.sleep(1)  # a canvas does not say that it is drawn
        self.take("dashboard-slab.png", ".job-parts")
        for name in ("report.png", "quarter-slab.png", "casting-drawing.png"):
            self.keep(name)

    def test_what_if(self):
        self.browser.set_window_size(1100, 800)
        self.go("what-if")
        self.wait_for("As it is: corner", seconds=60)
        slider = self.find("#cooling-bottom_block-temperature-offset")
        for _ in range(12):
            slider.send_keys(Keys.ARROW_RIGHT)
        self.wait_for("Changed: corner", seconds=60)
        time.sleep(1)  # a canvas does not say that it is drawn
        self.take("dashboard-what-if.png")

    def test_new_case(self):
        self.browser.set_window_size(1100, 1200)
        self.go("new")
        self.find("#found svg.casting", 60)
        self.take("dashboard-new-case.png")

    def test_jobs_studies_and_the_wall(self):
        self.browser.set_window_size(1100, 1000)
        thickness = os.path.join(CASES, "start-2d-thickness.toml")
        with self.subTest("a job while it runs"):
            slab = os.path.join(CASES, "start-3d.toml")
            running = self.dccast("submit", "--set", "quality=engineering", slab)
            until(lambda: self.client.job(running).last_step.time_s > 120.0, 200)
            self.go(f"job/{running}")
            self.find("canvas", 60)
            self.take("dashboard-running.png")
            self.assertEqual(self.client.job(running).state, job_pb2.RUNNING)
            self.client.cancel(running)
            self.client.until_state(running, job_pb2.CANCELLED)
        with self.subTest("the wall, and what helps"):
            short = self.dccast("submit", "--set", "schedule.hold=30 s", thickness)
            self.client.until_state(short, job_pb2.SUCCEEDED, job_pb2.FAILED, seconds=120)
            self.go("wall")
            self.find(".verdict .tag", 60)
            self.take("dashboard-wall.png")
            self.go(f"job/{short}")
            self.press("Compute what helps", "main")
            self.wait_for("shell_melted_through goes: hold", "#answer", 180)
            until(lambda: "to come" not in self.text("#answer"), 180)
            self.take("dashboard-remedy.png", "main")
        with self.subTest("a study"):
            data = ("cooling.bottom_block.temperature", "alloy.conductivity", "cooling.water.temperature")
            shown = self.dccast("uncertainty", thickness, "--runs", "24",
                                *(word for datum in data for word in ("--only", datum)))
            self.go("study/" + re.search(r"study ([0-9a-f-]{36})", shown)[1])
            self.wait_for("castings have", "#answer", 60)
            self.browser.set_window_size(1100, 1300)
            self.take("dashboard-study.png", "main")
        with self.subTest("the list"):
            self.browser.set_window_size(1100, 620)
            self.go("jobs")
            self.find("tr.study")
            self.take("dashboard-jobs.png")

    def test_python_excel_and_paraview(self):
        matplotlib.use("Agg")
        service = dccast.connect(self.daemon.address)
        job = service.submit("start-2d-thickness", quality="draft").wait()
        axes = job.plot()
        axes.figure.set_size_inches(7, 4)
        axes.figure.savefig(self.made("python-curl.png"), dpi=110, bbox_inches="tight")
        self.keep("python-curl.png")
        frame = (1000 * job.curl_frame().drop(columns="beyond_validity")).round(3)
        frame.columns = [name.removesuffix("_m") + "_mm" for name in frame.columns]
        frame.iloc[:: len(frame) // 30].to_csv(self.in_folder("curl.csv"))
        with self.subTest("a spreadsheet opens the table"):
            for words in (["soffice", f"-env:UserInstallation=file://{self.folder}/office", "--headless",
                           "--convert-to", "pdf", "curl.csv"],
                          ["pdftoppm", "-png", "-singlefile", "-r", "100", "-x", "60", "-y", "60", "-W",
                           "640", "-H", "300", "curl.pdf", self.made("excel-curl")]):
                subprocess.run(words, cwd=self.folder, capture_output=True, timeout=120, check=True)
            self.keep("excel-curl.png")
        slab = self.dccast("submit", "--set", "quality=draft", os.path.join(CASES, "start-3d.toml"))
        self.dccast("wait", slab)
        self.dccast("fetch", slab, "-o", "run.h5")
        with self.subTest("ParaView draws the slab"):
            subprocess.run(["xvfb-run", "-a", "pvpython", os.path.join(ROOT, "docs", "paraview_slab.py"),
                            "./run.xdmf", self.made("paraview-slab.png")], cwd=self.folder,
                           capture_output=True, timeout=180, check=True)
            self.keep("paraview-slab.png")


class Following(Wall, Camera):
    def test_a_casting_that_is_followed(self):
        plan = self.case_file(end=145)
        self.ended(self.dccast("follow", "--prepare", plan), seconds=300)
        hidden = self.submit_case("cooling.bottom_block.temperature=60 degC", path=plan)
        self.client.until_state(hidden, job_pb2.SUCCEEDED, seconds=60)
        self.take_curl_of(hidden)

        following = self.dccast("follow", plan, "--line", "pit-3", "--noise", "0.3 mm", stdin=subprocess.PIPE)
        self.addCleanup(following.communicate)
        self.addCleanup(following.kill)  # the first of the two
        lines = ["time [s], speed [mm/min], water [l/min/m], metal [degC], curl corner [mm]"]
        noise = np.random.default_rng(1).normal(0.0, 0.3, 200)
        for t in range(-60, 46):
            curl_mm = 1e3 * self.curl_m(t) + noise[t]
            lines.append(f"{t}, {40 if t > 0 else 0}, 90, 680, {curl_mm:.2f}")
        following.stdin.write("\n".join(lines) + "\n")
        following.stdin.flush()
        jobs = lambda: self.client.ask("ListJobs").jobs
        until(lambda: any(job.HasField("casting") and job.last_step.time_s >= 43 for job in jobs()), 60)
        self.browser.set_window_size(1200, 900)
        self.go("wall")
        self.wait_for("45 s", ".when")
        self.take("dashboard-following.png")


class Pages(unittest.TestCase):
    def test_the_tour_has_ten_pictures_with_captions(self):
        tour = (ROOT / "docs/dashboard.md").read_text(encoding="utf-8")
        stops = re.findall(r"^### \d+\. .+\n\n(?:.+\n)+\n!\[.+\]\(images/([\w-]+\.png)\)$", tour, re.MULTILINE)
        self.assertEqual(len(set(stops)), 10)

    def test_pictures_keep_the_repository_small(self):
        sizes = {path.name: path.stat().st_size for path in (ROOT / "docs" / "images").iterdir()}
        self.assertLess(max(sizes.values()), 150_000, sizes)

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
