#!/usr/bin/python3
"""Pages to keep, opened from a file in a real Chromium: the report of a job, a comparison, the start of
a case. They load nothing, draw with the modules of the dashboard, print, fit a phone, and show their
figures without scripts."""
import base64
import os
import re

from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import Select

from dashboard_test import CASES, InBrowser
from dccast.v1 import follow_pb2, job_pb2, judgement_pb2
from support import main
from wall_test import Wall


class Page(InBrowser):
    """A page in a file, opened in Chromium."""
    worker = "dccast-worker"

    def dccast(self, *words):
        return super().dccast(*words).strip()

    def cast(self, case, *changes):
        words = [word for change in ("quality=draft", *changes) for word in ("--set", change)]
        job = self.dccast("submit", *words, os.path.join(CASES, case))
        self.dccast("wait", job)
        return job

    def show(self, page):
        self.complaints()  # those of the page before
        self.browser.get("file://" + self.in_folder(page))

    def drawn(self, page):
        """Opens a page and waits until all is drawn."""
        self.show(page)
        self.find("body.complete", 60)
        self.assertEqual(self.complaints(), [])
        loaded = self.browser.execute_script(
            "return performance.getEntriesByType('resource').map(e => e.name)")
        self.assertEqual([name for name in loaded if not name.startswith("data:")], [])

    def charts(self):
        return [svg.get_attribute("aria-label").split(":")[0] for svg in self.browser.find_elements(
            By.CSS_SELECTOR, ".drawn figure > svg")]

    def colours(self, canvas):
        """Number of colours in a canvas."""
        return self.browser.execute_script("""
            const copy = document.createElement('canvas'), of = arguments[0];
            copy.width = of.width; copy.height = of.height;
            const context = copy.getContext('2d'); context.drawImage(of, 0, 0);
            const bytes = context.getImageData(0, 0, copy.width, copy.height).data, seen = new Set();
            for (let i = 0; i < bytes.length; i += 4)
              if (bytes[i + 3]) seen.add(bytes[i] << 16 | bytes[i + 1] << 8 | bytes[i + 2]);
            return seen.size;""", canvas)

    def check_phone(self):
        """Tables of figures scroll in their own box; nothing else is wider than the screen."""
        self.on_phone()
        wide = [found for found in self.hidden_sideways() if not found.startswith("DIV scroll")]
        self.assertEqual(wide, [])

    def sheets(self):
        """Sheets of A4 that the page prints to."""
        pdf = base64.b64decode(self.browser.execute_cdp_cmd(
            "Page.printToPDF", {"preferCSSPageSize": True, "printBackground": True})["data"])
        self.assertEqual(pdf[:5], b"%PDF-")
        return len(re.findall(rb"/Type\s*/Page\b", pdf))


class Reports(Page):
    def test_the_report_of_a_quarter_slab(self):
        job = self.cast("start-3d.toml", "time.end=20 s")
        self.dccast("report", job, "-o", "report.html")
        self.assertLess(os.path.getsize(self.in_folder("report.html")), 2_000_000)
        self.drawn("report.html")
        for title in ("Curl against time", "Curl against cast length", "Casting speed", "Water", "Shell",
                      "Heat through each face", "Pull-in of the wide face"):
            self.assertIn(title, self.charts())
        self.assertGreater(self.colours(self.find(".stage canvas")), 20)
        self.assertGreater(self.colours(self.find(".gap-map canvas")), 1)

        with self.subTest("another field, then another time"):
            Select(self.find("select[aria-label=Field]")).select_by_value("von_mises_pa")
            self.find("canvas[aria-label^='Stress']")
            self.wait_for("MPa", "svg.colours")
            Select(self.find("select[aria-label=Field]")).select_by_value("temperature_c")
            self.browser.execute_script("""
                const time = document.querySelector('.levers input'); time.value = 1;
                time.dispatchEvent(new Event('input'));""")
            self.find("canvas[aria-label^='Temperature of the slab at -60.0 s']")

        with self.subTest("paper has three views in place of one, and no button"):
            sheets = self.sheets()
            self.assertGreaterEqual(sheets, 2)
            self.assertLessEqual(sheets, 5)
            self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
            views = self.browser.find_elements(By.CSS_SELECTOR, ".views canvas")
            self.assertEqual([view.is_displayed() for view in views], 3 * [True])
            self.assertFalse(self.find(".stage").is_displayed())
            self.assertFalse(any(button.is_displayed() for button in self.browser.find_elements(
                By.CSS_SELECTOR, "main button")))
            self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})

        self.check_phone()

    def test_without_scripts_the_figures_are_text(self):
        job = self.cast("start-2d-thickness.toml", "time.end=60 s")
        self.dccast("report", job, "-o", "report.html")
        self.browser.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": True})
        self.show("report.html")
        text = self.text("main")
        for part in ("drawn by the script in this page", "has risen", "Casting speed", "Checks of the run",
                     "Curl against time"):
            self.assertIn(part, text)
        self.assertEqual(self.charts(), [])

    def test_a_section_a_comparison_and_the_start_of_a_case(self):
        case = os.path.join(CASES, "start-2d-thickness.toml")
        jobs = [self.cast("start-2d-thickness.toml", "time.end=60 s", f"schedule.hold={hold} s")
                for hold in (60, 90)]
        self.dccast("report", jobs[0], "-o", "report.html")
        self.drawn("report.html")
        self.assertGreater(self.colours(self.find(".stage canvas")), 20)
        self.assertIn("Gap along the bottom", self.charts())
        self.assertEqual(self.browser.find_elements(By.CSS_SELECTOR, ".views"), [])

        self.dccast("compare", *jobs, "-o", "comparison.html")
        self.drawn("comparison.html")
        self.assertTrue(any(title.startswith("Curl of") for title in self.charts()))
        self.dccast("validate", "--local", case, "--set", "cooling.bottom_block.bowl.depth=30 mm", "--drawing",
                    "start.html")
        self.drawn("start.html")
        for label in ("water line", "bowl, 30 mm deep"):
            self.assertIn(label, self.text("svg.casting"))
        self.assertEqual(len(self.charts()), 2)
        self.check_phone()

    def test_the_dashboard_shows_the_report_in_a_sandbox(self):
        job = self.cast("start-2d-thickness.toml", "time.end=20 s")
        self.browser.get(self.browser.current_url.split("#")[0] + f"jobs/{job}/report")
        self.find("body.complete", 60)
        self.wait_up_to(10).until(lambda _: "Curl against time" in self.charts())


class FollowedCasting(Wall, Page):
    """Measured against forecast, after the casting."""

    def report_of(self, job_id, readings):
        """Ends the record after so many readings, and opens the report. Returns its judgement."""
        self.append(job_id, follow_pb2.Reading(number=readings + 1, closes=True))
        self.client.until_state(job_id, job_pb2.SUCCEEDED, seconds=60)
        self.ended(self.dccast("report", job_id, "-o", self.in_folder("report.html")))
        self.drawn("report.html")
        return self.client.ask("CompareRuns", runs=[judgement_pb2.ComparedRun(job=job_id)]).judgement

    def test_measured_against_forecast(self):
        job_id = self.follow_on_line()
        self.measure(job_id, 110)
        judgement = self.report_of(job_id, 171)
        self.assertIn("Corner, measured and forecast", self.charts())

        table = next(part.table for part in judgement.parts if part.table.key == "forecast")
        shown = self.text("main")
        errors = []
        for row, (ahead, forecasts) in zip(table.rows, ((30, 81), (60, 51)), strict=True):
            gauge, *numbers = row.cells
            self.assertEqual((gauge.text, numbers[0].value, numbers[1].value),
                             ("corner", ahead, forecasts))
            error, inside = numbers[2].value, numbers[3].value
            self.assertGreater(inside, 0.8)
            self.assertIn(f"corner {ahead} {forecasts} {1e3 * error:.2f} {100 * inside:.0f}\n", shown)
            errors.append(error)
        self.assertTrue(0 < errors[0] < errors[1] < 1.5e-3, errors)
        self.assertIn("111 readings were used and 0 left out", shown)
        self.assertIn("No warning was raised.", shown)
        if "DCCAST_PICTURES" in os.environ:
            self.take_card("report-followed.png")
        self.check_phone()

    def take_card(self, name):
        card = next(card for card in self.browser.find_elements(By.CSS_SELECTOR, ".histories")
                    if "measured and forecast" in card.text)
        with open(os.path.join(os.environ["DCCAST_PICTURES"], name), "wb") as file:
            file.write(card.screenshot_as_png)

    def test_warnings_with_their_times(self):
        job_id = self.follow_on_line()
        self.measure(job_id, 110, curl=lambda t: self.curl_m(t) + (12e-3 if t > 30 else 0.0))
        self.report_of(job_id, 171)
        self.assertIn("the gauge has slipped", self.text("main"))
        self.assertIn("Warnings of the forecast", self.text("main"))
        if "DCCAST_PICTURES" in os.environ:
            self.take_card("report-followed-slip.png")

    def test_without_a_gauge_one_line_says_so(self):
        job_id = self.follow(end=20)
        self.append(job_id, *[follow_pb2.Reading(number=t + 1, time_s=t) for t in range(10)])
        self.report_of(job_id, 10)
        self.assertIn(f"No forecast: job {job_id} measures no curl", self.text("main"))
        self.assertNotIn("Corner, measured and forecast", self.charts())


if __name__ == "__main__":
    main()
