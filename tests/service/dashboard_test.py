#!/usr/bin/python3
"""The dashboard: who gets in, what its server gives, and its pages in a real Chromium."""
import http.client
import json
import os
import re
import shutil
import signal
import stat
import struct
import subprocess
import time
import urllib.parse
import uuid

from selenium import webdriver
from selenium.common.exceptions import StaleElementReferenceException
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import WebDriverWait

import own_mesh_test
from dccast.v1 import case_pb2, job_pb2
from support import ServiceTest, fake_case, main
from waiting import WAIT_FACTOR, stays, until

CASES = os.path.join(os.path.dirname(__file__), "..", "..", "cases")
SERVICE = "/dccast.v1.SimulationService/"
HOSTILE = "<img src=x onerror=\"document.title='broken in'\">"


class Dashboard(ServiceTest):
    files = ()

    def setUp(self):
        super().setUp()
        self.start_dashboard()

    def tearDown(self):
        self.stop_dashboard()
        super().tearDown()

    def start_dashboard(self, port=None, options=(), environment=None):
        words = self.client_command("dashboard", *self.files, *options)
        self.process = subprocess.Popen(words + (["--port", str(port)] if port else []),
                                        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
                                        env={**os.environ, **(environment or {})})
        self.address = self.process.stdout.readline().strip()
        self.url = urllib.parse.urlsplit(self.address)

    def stop_dashboard(self):
        """Ctrl-C: within two seconds, also while pages are open."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
            self.assertIn(self.process.wait(timeout=5), (0, 130))
        self.process.stdout.close()

    def finished_job(self, title="steps=20", **rest):
        job = self.client.submit(fake_case(title, **rest))
        self.client.until_state(job.id, job_pb2.SUCCEEDED)
        return job.id


class WithoutBrowser(Dashboard):
    def ask(self, path, method="GET", body=None, cookie="own", **headers):
        connection = http.client.HTTPConnection("127.0.0.1", self.url.port, timeout=30)
        if cookie == "own":
            if not hasattr(self, "session"):
                self.session = ""
                response = self.ask(f"/?{self.url.query}", cookie=None)[0]
                self.assertEqual(response.status, 302)
                self.set_cookie = response.getheader("Set-Cookie")
                self.session = self.set_cookie.split(";")[0]
            headers["Cookie"] = self.session
        elif cookie:
            headers["Cookie"] = cookie
        connection.request(method, path, body, headers)
        response = connection.getresponse()
        body = response.read()
        connection.close()
        return response, body

    def own(self):
        return {"Origin": f"http://127.0.0.1:{self.url.port}", "Content-Type": "application/json"}

    def call(self, name, **request):
        response, body = self.ask(SERVICE + name, "POST", json.dumps(request), **self.own())
        self.assertEqual(response.status, 200, body)
        return json.loads(body)


class Entrance(WithoutBrowser):
    """What is refused, and what is answered."""

    def test_only_the_holder_of_the_key_gets_in_and_the_key_works_once(self):
        for path in ("/", "/app.js", "/cases/", "/?key=" + 64 * "0"):
            response, body = self.ask(path, cookie=None)
            self.assertEqual(response.status, 403, path)
            self.assertNotIn(b"<script", body)
        self.assertEqual(self.ask("/")[0].status, 200)
        self.assertEqual(self.ask(f"/?{self.url.query}", cookie=None)[0].status, 403)
        name = self.session.split("=")[0]
        self.assertEqual(self.ask("/", cookie=f"{name}={64 * '0'}")[0].status, 403)

    def test_other_sites_cannot_use_the_session(self):
        evil = {"Host": f"evil.example:{self.url.port}"}  # a name that its owner points at 127.0.0.1
        self.assertEqual(self.ask("/", **evil)[0].status, 403)
        for origin in ({}, {"Origin": "http://evil.example"}, {"Origin": "null"},
                       {"Origin": "http://127.0.0.1:1"}):
            self.assertEqual(self.ask(SERVICE + "ListJobs", "POST", "{}", **origin)[0].status, 403, origin)
        self.assertEqual(self.ask("/cases/", Origin="http://evil.example")[0].status, 403)
        head = self.ask("/")[0]
        self.assertIn("default-src 'none'", head.getheader("Content-Security-Policy"))
        self.assertNotIn("unsafe", head.getheader("Content-Security-Policy"))
        self.assertEqual(head.getheader("Cache-Control"), "no-store")
        self.assertIn("HttpOnly; SameSite=Strict", self.set_cookie)

    def test_it_listens_on_loopback_alone(self):
        with open("/proc/net/tcp", encoding="ascii") as file:
            listening = [line.split()[1] for line in file if line.split()[3] == "0A"]
        port = f"{self.url.port:04X}"
        self.assertEqual([at for at in listening if at.endswith(":" + port)], ["0100007F:" + port])

    def test_paths_lead_to_no_other_files(self):
        for path in ("/cases/../../etc/passwd", "/cases/?case=/etc/passwd", "/job/..%2F..%2Fetc%2Fpasswd"):
            self.assertNotIn(b"root:", self.ask(path)[1])

    def test_a_job_as_pages_see_it(self):
        job = self.finished_job("steps=30")
        seen = json.loads(self.ask(f"/job/{job}")[1])
        steps = self.client.steps(job)
        self.assertEqual([step["time_s"] for step in seen["steps"]], [step.time_s for step in steps])
        self.assertEqual([step["monitors"][0]["curl_m"] for step in seen["steps"]],
                         [step.monitors[0].curl_m for step in steps])
        self.assertEqual(self.call("ListJobs")["jobs"][0]["id"], job)
        few = self.call("QueryResult", id=job, samples=8)
        self.assertLessEqual(len(few["steps"]), 8)
        self.assertEqual([few["steps"][0], few["steps"][-1]],
                         [seen_step for seen_step in self.call("QueryResult", id=job)["steps"]
                          if int(seen_step["step"]) in (1, len(steps))])
        self.assertNotIn("case", few)
        report, page = self.ask(f"/jobs/{job}/report")
        self.assertIn(b"<h1>", page)
        self.assertIn("sandbox", report.getheader("Content-Security-Policy"))
        other = self.finished_job("steps=31")
        self.assertIn(b"comparison", self.ask(f"/compare/?job={job}&job={other}")[1])


class RealRuns(WithoutBrowser):
    """What comes from a real solver."""
    worker = "dccast-worker"

    def test_a_case_and_frames(self):
        changes = [{"key": "quality", "value": "draft"}, {"key": "time.end", "value": "20 s"}]
        read = self.call("ReadCase", shipped="start-2d-thickness", changes=changes)
        self.assertEqual(read["faults"], [])
        self.assertEqual([(chart["heading"], chart["y"]["unit"]) for chart in read["charts"]],
                         [("casting speed", "m/s"), ("water", "m2/s")])
        self.assertGreater(len(read["complete"]["cooling"]), len(read["case"]["cooling"]), "defaults")
        written = self.call("ReadCase", case=read["case"])
        self.assertIn('end = "20 s"', written["text"])
        self.assertEqual(written["case"], read["case"])
        wrong = self.call("ReadCase", case={"section": {"half_width_m": -1}})
        self.assertIn("section.half_width", [fault["field"] for fault in wrong["faults"]])
        self.assertEqual(wrong["text"], "")

        job = self.call("SubmitJob", request_id=str(uuid.uuid4()), case=read["case"],
                        changes=changes)["id"]
        self.client.until_state(job, job_pb2.SUCCEEDED)
        times = json.loads(self.ask(f"/frames/{job}")[1])["times"]
        self.assertGreater(len(times), 1)

        raw = self.ask(f"/jobs/{job}/frame?number={len(times)}")[1]
        nodes, elements, per, triangles, edges, dimension = struct.unpack("<6i", raw[:24])
        self.assertEqual(len(raw), 32 + 4 * (4 + 7 * nodes + elements * per + 3 * triangles + 2 * edges))

        frame = self.client.ask("QueryResult", id=job, frame=True).frame
        self.assertEqual((nodes, dimension), (len(frame.temperature_c), 2))

        height = struct.unpack(f"<{3 * nodes}f", raw[48:48 + 12 * nodes])[2::3]
        for drawn, stored in zip(height, list(frame.node_m)[1::2]):
            self.assertAlmostEqual(drawn, stored, delta=1e-6)


class InBrowser(Dashboard):
    """In Chromium."""

    def setUp(self):
        super().setUp()
        options = webdriver.ChromeOptions()
        for word in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage",
                     "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                     "--window-size=1280,900",
                     f"--user-data-dir={self.folder}/chromium"):
            options.add_argument(word)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.browser = webdriver.Chrome(options=options)
        self.browser.get(self.address)

    def tearDown(self):
        self.browser.quit()
        super().tearDown()

    def go(self, page):
        self.browser.execute_script(f"location.hash = {json.dumps('#/' + page)}")

    def wait_up_to(self, seconds, *ignored):
        return WebDriverWait(self.browser, seconds * WAIT_FACTOR, ignored_exceptions=ignored)

    def find(self, selector, seconds=20):
        return self.wait_up_to(seconds).until(
            lambda browser: browser.find_element(By.CSS_SELECTOR, selector))

    def read(self, selector, what, seconds=20):
        """what(element), on pages that draw an element anew between its finding and its reading."""
        wait = self.wait_up_to(seconds, StaleElementReferenceException)
        return wait.until(lambda browser: [what(browser.find_element(By.CSS_SELECTOR, selector))])[0]

    def text(self, selector, seconds=20):
        return self.read(selector, lambda element: element.text, seconds)

    def wait_for(self, text, selector="main", seconds=20):
        def there(browser):
            found = browser.find_elements(By.CSS_SELECTOR, selector)
            return any(text in element.text for element in found)
        self.wait_up_to(seconds, Exception).until(there)

    def press(self, text, selector="main .bar"):
        """Presses the button with this text."""
        def pressed(browser):
            for button in browser.find_elements(By.CSS_SELECTOR, f"{selector} button"):
                if button.text == text and button.is_enabled():
                    button.click()
                    return True
            return False
        self.wait_up_to(20, Exception).until(pressed)

    def on_phone(self, width=390):
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
            "width": width, "height": 844, "deviceScaleFactor": 1, "mobile": True})

    def hidden_sideways(self):
        """Elements that reach beyond the screen, or hold more than they show side by side."""
        return self.browser.execute_script("""
            const wide = document.documentElement.clientWidth, found = [];
            for (const e of document.body.querySelectorAll('*')) {
              const box = e.getBoundingClientRect(), style = getComputedStyle(e);
              if (box.width === 0 || e.closest('svg') !== null && e.tagName !== 'svg') continue;
              const scrolls = /auto|scroll|hidden/.test(style.overflowX) && e.scrollWidth > e.clientWidth + 1
                && !/INPUT|SELECT|TEXTAREA/.test(e.tagName);
              if (box.right > wide + 1 && !e.classList.contains('skip') || scrolls)
                found.push(`${e.tagName} ${e.className} ${Math.round(box.right)} ${e.scrollWidth}`);
            }
            return found;""")

    def complaints(self):
        """Errors of the pages. The browser reports refusals, too, that a page shows as its answer."""
        answers = re.compile(r"/(ForecastJob|PredictStudy|CompareRuns|JudgeStudy|ReadCase) - Failed to "
                             r"load resource: the server responded with a status of 400 ")
        return [entry["message"] for entry in self.browser.get_log("browser")
                if entry["level"] == "SEVERE" and not answers.search(entry["message"])]


class Pages(InBrowser):
    def test_jobs_by_mouse_and_keyboard(self):
        jobs = [self.finished_job(f"steps=20 number={n}") for n in range(3)]
        self.wait_for("3 jobs: 0 running, 0 queued, 3 succeeded")
        self.assertEqual(len(self.browser.find_elements(By.CSS_SELECTOR, "tbody tr")), 3)

        self.find("td.sketch svg")
        box = self.find("input[type=search]")
        box.send_keys("number=1")
        self.wait_up_to(10).until(
            lambda b: len(b.find_elements(By.CSS_SELECTOR, "tbody tr")) == 1)
        box.send_keys(Keys.CONTROL, "a", Keys.DELETE)
        for checkbox in self.browser.find_elements(By.CSS_SELECTOR, "tbody input")[:2]:
            checkbox.send_keys(Keys.SPACE)
        self.find(".bar button").send_keys(Keys.ENTER)
        self.wait_for("2 jobs compared")
        self.wait_for("run 2")
        self.assertTrue(self.find("figure svg").get_attribute("aria-label").startswith("Curl of"))

        self.go("jobs")
        self.find(f"a[href='#/job/{jobs[0]}']").click()
        self.wait_up_to(20).until(lambda browser: browser.title == "Job · dccast")
        self.wait_for("succeeded")
        self.wait_for("since the block started", "p.answer")
        self.assertEqual(self.complaints(), [])

    def test_a_running_job_grows_and_is_cancelled(self):
        job = self.client.submit(fake_case("steps=100000 sleep_ms=20"))
        self.go(f"job/{job.id}")
        self.wait_for("running")
        self.find("figure path.line")
        def drawn():  # at once: the page may draw it anew between two questions
            return self.browser.execute_script(
                "return document.querySelector('figure path.line')?.getAttribute('d')")
        first = drawn()
        self.wait_up_to(20).until(lambda _: drawn() not in (first, None))
        self.find("details summary").click()
        self.find("svg[aria-label^='Residuals of the steps']")
        self.press("Cancel")
        self.press("Cancel this job", "dialog")
        self.wait_for("cancelled")
        self.client.until_state(job.id, job_pb2.CANCELLED)

    def test_a_cancel_is_asked_for_and_can_be_undone(self):
        job = self.client.submit(fake_case("steps=100000 sleep_ms=20"))
        self.go(f"job/{job.id}")
        self.wait_for("running")
        self.press("Cancel")
        self.wait_for("cannot be continued", "dialog")
        self.press("Keep running", "dialog")
        self.assertEqual(self.browser.find_elements(By.CSS_SELECTOR, "dialog, .pending"), [])

        self.press("Cancel")
        self.press("Cancel this job", "dialog")
        self.go("jobs")  # it can be undone from any page
        self.press("Undo", ".pending")
        self.assertEqual(self.browser.find_elements(By.CSS_SELECTOR, ".pending"), [])
        step = self.client.job(job.id).last_step.step
        self.client.until_step(job.id, step + 350, seconds=60)  # 7 s or more: longer than it would have waited
        self.assertEqual(self.client.job(job.id).state, job_pb2.RUNNING)

        self.go(f"job/{job.id}")
        self.wait_for("running")
        self.press("Cancel")
        self.press("Cancel this job", "dialog")
        self.find(".pending")
        self.browser.get("about:blank")  # the page is left: there is nobody to undo it any more
        self.client.until_state(job.id, job_pb2.CANCELLED, seconds=4)

    def test_many_jobs_by_their_label(self):
        running = [self.client.submit(fake_case("steps=100000 sleep_ms=20"), labels=["line=3"]).id
                   for _ in range(2)]
        other = self.client.submit(fake_case("steps=100000 sleep_ms=20"), labels=["line=4"]).id
        self.wait_for("3 jobs")
        self.find("select[aria-label=Label] option[value='line=3']").click()
        self.wait_up_to(10).until(
            lambda b: len(b.find_elements(By.CSS_SELECTOR, "tbody tr")) == 2)
        self.find(".bar input[type=checkbox]").click()
        self.press("Pause 2")
        for job in running:
            self.client.until_state(job, job_pb2.PAUSED)
        self.press("Resume 2")
        self.press("Cancel 2")
        self.press("Cancel 2 jobs", "dialog")
        for job in running:
            self.client.until_state(job, job_pb2.CANCELLED, seconds=20)
        self.assertIn(self.client.job(other).state, (job_pb2.QUEUED, job_pb2.RUNNING))
        self.client.cancel(other)
        self.assertEqual(self.complaints(), [])

    def test_runs_fold_under_their_study(self):
        study = str(uuid.uuid4())
        for number, quality in enumerate(2 * [case_pb2.DRAFT]):
            change = {"key": "schedule.water_flow.scale", "value": f"0.{8 + number}"}
            job = self.client.submit(fake_case(f"steps=20 number={number}", quality=quality), study=study,
                                     changes=[change, {"key": "time.end", "value": "145 s"}])
            self.client.until_state(job.id, job_pb2.SUCCEEDED)
        self.finished_job("steps=20 alone")
        self.wait_for("3 jobs: 0 running, 0 queued, 3 succeeded")
        rows = lambda: self.read("tbody", lambda table: [
            row.text for row in table.find_elements(By.CSS_SELECTOR, "tr")])
        self.assertEqual(len(rows()), 2)
        folded = self.text("tr.study")
        for text in ("2 runs", study[:8], "2 of 2 succeeded", "draft", "time.end = 145 s", " to "):
            self.assertIn(text, folded)
        self.assertNotIn("water_flow", folded)
        self.find("button.fold").send_keys(Keys.ENTER)
        self.wait_up_to(10).until(lambda _: len(rows()) == 4)
        self.assertIn("schedule.water_flow.scale = 0.9", self.text("tr.run"))
        self.assertNotIn("time.end", self.text("tr.run"))
        self.assertIn("engineering", rows()[0])
        self.assertEqual(self.find("button.fold").get_attribute("aria-expanded"), "true")
        self.assertEqual(self.complaints(), [])

    def test_the_wall_shows_the_worst_finding_beside_the_number(self):
        self.finished_job("steps=20 finding_at=3")
        self.go("wall")
        self.wait_for("The shell leaves the mould 3 mm thick.", ".verdict")
        self.assertIn("danger", self.text(".verdict"))
        middle = lambda element: element.rect["y"] + element.rect["height"] / 2
        self.assertLess(abs(self.read(".verdict", middle) - self.read(".huge", middle)), 100)

    def test_a_run_that_failed_shows_no_curl_as_of_a_good_one(self):
        job = self.client.submit(fake_case("steps=20 fail_at=9"))
        self.client.until_state(job.id, job_pb2.FAILED)
        self.wait_for("1 failed")
        self.assertEqual(self.text("tbody .curl"), "")
        self.go("wall")
        self.wait_for("failed", ".huge")
        self.go(f"job/{job.id}")
        self.find("figure")
        self.assertEqual(self.browser.find_elements(By.CSS_SELECTOR, ".tile"), [])
        self.assertEqual(self.complaints(), [])

    def test_the_link_of_a_job_opens_it(self):
        job = self.finished_job("steps=20 for anna")
        self.go(f"job/{job}")
        self.wait_for("for anna")
        self.press("Link")
        self.find("dialog input")
        links = [box.get_attribute("value")
                 for box in self.browser.find_elements(By.CSS_SELECTOR, "dialog input")]
        self.assertEqual(links[0], f"http://127.0.0.1:{self.url.port}/#/job/{job}")
        self.press("Close", "dialog")
        self.browser.get(links[0])
        self.wait_for("for anna")
        self.assertEqual(self.complaints(), [])

    def test_hostile_names_are_inert(self):
        job = self.finished_job("steps=20 " + HOSTILE)
        self.wait_for("onerror", "tbody")
        for page in ("jobs", f"job/{job}", f"compare/{job}/{job}", "wall", "studies"):
            self.go(page)
            stays(lambda: "broken" not in self.browser.title, 0.5)  # a script among the names runs by then
            self.assertEqual(self.browser.find_elements(By.CSS_SELECTOR, "main img"), [])

    def test_a_thousand_jobs(self):
        for n in range(1000):
            self.client.submit(fake_case(f"sleep_ms=50 steps=1000 number={n}"), request_id=f"r{n}")
        self.browser.refresh()
        self.wait_for("1000 newest jobs", seconds=30)
        took = self.browser.execute_async_script("""
            const done = arguments[0], begin = performance.now();
            location.hash = '#/studies';
            setTimeout(() => { const from = performance.now(); location.hash = '#/jobs';
              const look = () => document.querySelectorAll('tbody tr').length === 1000
                ? requestAnimationFrame(() => done(performance.now() - from)) : setTimeout(look, 5);
              look(); }, 300);""")
        print(f"\n1,000 jobs are listed in {took:.0f} ms")

    def test_it_comes_back_with_its_servers(self):
        self.wait_for("No jobs yet")
        self.daemon.terminate()
        self.wait_up_to(30).until(
            lambda b: "bad" in b.find_element(By.ID, "server").get_attribute("class"))
        self.daemon.settings["listen__socket"] = self.daemon.address
        self.restart()
        self.wait_up_to(30).until(
            lambda b: "bad" not in b.find_element(By.ID, "server").get_attribute("class"))
        self.stop_dashboard()
        self.wait_up_to(30).until(
            lambda b: "start dccast dashboard again" in b.find_element(By.ID, "server").text)
        self.start_dashboard(self.url.port)  # another session: the page asks for its key
        self.wait_up_to(30).until(
            lambda b: "key in the address" in b.find_element(By.ID, "server").text)
        self.browser.get(self.address)
        self.wait_for("No jobs yet")

    def test_screen_readers_and_small_screens(self):
        self.finished_job("steps=20")
        for page in ("jobs", "studies", "what-if", "wall"):
            self.go(page)
            time.sleep(1)  # nothing says that a page has drawn its last part
            tree = self.browser.execute_cdp_cmd("Accessibility.getFullAXTree", {})["nodes"]
            unnamed = [node["role"]["value"] for node in tree
                       if not node.get("ignored") and node["role"]["value"] in
                       ("button", "link", "slider", "checkbox", "textbox", "searchbox", "combobox",
                        "progressbar") and not node.get("name", {}).get("value")]
            self.assertEqual(unnamed, [], page)
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
            "width": 360, "height": 740, "deviceScaleFactor": 1, "mobile": True})
        self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {
            "features": [{"name": "prefers-color-scheme", "value": "dark"}]})
        for page in ("jobs", "studies", "what-if", "wall"):
            self.go(page)
            time.sleep(0.5)  # as above
            wide = self.browser.execute_script("return document.documentElement.scrollWidth")
            self.assertLessEqual(wide, 360, page)
            ink, paper = (self.browser.execute_script(
                f"return getComputedStyle(document.body).{name}") for name in ("color", "backgroundColor"))
            self.assertGreater(sum(map(int, ink[4:-1].split(","))),
                               sum(map(int, paper[4:-1].split(","))))

    def test_drawings_are_made_anew_when_a_phone_is_turned(self):
        widths = lambda: self.browser.execute_script(
            "return [...document.querySelectorAll('main figure > svg, svg.casting')]"
            ".map(svg => svg.viewBox.baseVal.width)")
        self.on_phone()
        for page, upright, across in ((f"job/{self.finished_job('steps=20')}", 334, 788), ("new", 700, 640)):
            self.go(page)
            until(lambda: upright in widths(), 20)
            self.on_phone(844)
            until(lambda: across in widths() and upright not in widths(), 5)
            self.on_phone()
            until(lambda: upright in widths() and across not in widths(), 5)
        self.assertEqual(self.complaints(), [])

    def test_on_a_phone_nothing_is_hidden_sideways(self):
        study = str(uuid.uuid4())
        change = {"key": "cooling.bottom_block.contact_coefficient.scale", "value": "1.25 until 100 mm"}
        jobs = [self.client.submit(fake_case(f"steps=20 finding_at=3 number={n} " + 8 * "long-title "),
                                   study=study if n else "", changes=[change], labels=["line=3"]).id
                for n in range(3)]
        for job in jobs:
            self.client.until_state(job, job_pb2.SUCCEEDED)
        self.on_phone()
        self.find("button.fold").click()
        for page in ("jobs", f"job/{jobs[0]}", f"compare/{jobs[0]}/{jobs[1]}", "studies", "what-if",
                     "wall"):
            self.go(page)
            time.sleep(1)  # nothing says that a page has drawn its last part
            self.assertEqual(self.hidden_sideways(), [], page)
        self.assertEqual(self.complaints(), [])


class Opened(InBrowser):
    """By --open: what xdg-open is given can be read by every user of the machine."""

    def start_dashboard(self, *_, **__):
        programs, self.runtime = (os.path.join(self.folder, name) for name in ("bin", "run"))
        for folder in (programs, self.runtime):
            os.makedirs(folder)
        given = os.path.join(self.folder, "given")
        with open(os.path.join(programs, "xdg-open"), "w", encoding="ascii") as script:
            script.write(f"#!/bin/sh\nprintf '%s\\n' \"$@\" > {given}.tmp && mv {given}.tmp {given}\n")
        os.chmod(os.path.join(programs, "xdg-open"), 0o700)
        super().start_dashboard(options=["--open"], environment={
            "PATH": programs + os.pathsep + os.environ["PATH"], "XDG_RUNTIME_DIR": self.runtime})
        until(lambda: os.path.exists(given), 10)
        with open(given, encoding="utf-8") as file:
            self.given = file.read().splitlines()
        self.address = urllib.parse.urljoin("file:", self.given[0])

    def test_the_key_is_in_a_file_of_its_user_that_goes_once_it_was_used(self):
        self.wait_for("No jobs yet")
        self.assertEqual(len(self.given), 1)
        self.assertNotIn("key", self.given[0])
        self.assertTrue(self.given[0].startswith(self.runtime + os.sep))
        until(lambda: os.listdir(self.runtime) == [], 10)
        self.assertEqual(self.complaints(), [])

    def test_nobody_else_reads_the_file_and_it_goes_with_the_dashboard(self):
        self.stop_dashboard()
        self.assertEqual(os.listdir(self.runtime), [])
        shutil.rmtree(self.runtime)
        shutil.rmtree(os.path.join(self.folder, "bin"))
        os.remove(os.path.join(self.folder, "given"))
        self.start_dashboard()
        self.assertEqual(stat.S_IMODE(os.stat(self.given[0]).st_mode), 0o600)
        self.assertEqual(stat.S_IMODE(os.stat(os.path.dirname(self.given[0])).st_mode), 0o700)


class RealPages(InBrowser):
    """What-if and the slab, with the real solver."""
    worker = "dccast-worker"
    files = (os.path.join(CASES, "start-2d-thickness.toml"),)

    def test_what_if_by_a_slider(self):
        self.go("what-if")
        self.wait_for("As it is: corner", seconds=60)
        slider = self.find("#schedule-water_flow-scale")
        for _ in range(20):
            slider.send_keys(Keys.ARROW_LEFT)
        self.wait_for("Changed: corner", seconds=60)
        self.assertEqual(self.text("output[for=schedule-water_flow-scale]"), "-20 %, 72 to 144 l/min/m")
        # An error has two digits and its curl as many decimals, as in the terminal.
        self.assertRegex(self.text(".what-if strong"), r"corner \d\.\d\d ± 0\.\d\d mm")

        self.wait_for("run 2", "#difference")
        self.assertRegex(self.text("#difference"), r" at 145 s(: .* mm, (real|within its error))?\.")
        self.assertIn("less 1, mm", self.text("#difference table"))

        # While the next key press is computed, only the case as it is has bands.
        self.wait_up_to(60).until(
            lambda browser: len(browser.find_elements(By.CSS_SELECTOR, "path.band")) == 6)
        [b for b in self.browser.find_elements(By.CSS_SELECTOR, ".bar button")
         if b.text == "Keep as a job"][0].click()
        self.wait_for("Queued as")
        job = self.text("p[role=status] a")
        changes = {change.key: change.value for change in self.client.job(job).changes}
        self.assertEqual(changes["schedule.water_flow.scale"], "0.80")
        self.assertEqual(self.complaints(), [])

    def test_a_study_shows_its_answer(self):
        made = self.dccast("uncertainty", os.path.join(CASES, "start-2d-thickness.toml"), "--set",
                           "time.end=20 s", "--only", "alloy.conductivity", "--only",
                           "cooling.water.temperature", "--runs", "10")
        self.go("study/" + re.search(r"study ([0-9a-f-]{36})", made)[1])
        self.wait_for("9 of 10 castings have", "#answer", seconds=30)
        self.assertIn("alone, %", self.text("#answer table"))
        self.assertEqual(len(self.browser.find_elements(By.CSS_SELECTOR, "#answer figure svg")), 2)
        self.assertEqual(self.complaints(), [])

    def pixels(self):
        """Of the canvas: pixels drawn, colours, and the shares of its width and height that they span."""
        return self.browser.execute_async_script("""
            const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(() => {
              const c = document.querySelector('canvas'), gl = c.getContext('webgl'), p = new Uint8Array(4 * c.width * c.height);
              gl.readPixels(0, 0, c.width, c.height, gl.RGBA, gl.UNSIGNED_BYTE, p);
              const seen = new Set(); let filled = 0, left = c.width, right = 0, low = c.height, high = 0;
              for (let i = 0; i < p.length; i += 4) if (p[i + 3]) {
                const x = (i / 4) % c.width, y = Math.floor(i / 4 / c.width);
                filled++; seen.add(p[i] << 16 | p[i + 1] << 8 | p[i + 2]);
                left = Math.min(left, x); right = Math.max(right, x); low = Math.min(low, y); high = Math.max(high, y);
              }
              done([filled, seen.size, (right - left) / c.width, (high - low) / c.height]); }));""")

    def submit_case(self, name, *changes):
        words = [word for change in changes for word in ("--set", change)]
        return self.dccast("submit", *words, os.path.join(CASES, name)).strip()

    def save_files_in(self, name):
        folder = os.path.join(self.folder, name)
        self.browser.execute_cdp_cmd("Browser.setDownloadBehavior",
                                     {"behavior": "allow", "downloadPath": folder})
        os.makedirs(folder)

        def saved(ending):
            # Chromium reserves a file's name by an empty file before it moves the content there.
            until(lambda: not any(name.endswith(".crdownload") for name in os.listdir(folder))
                  and content(ending), 20)
            return content(ending)

        def content(ending):
            for name in os.listdir(folder):
                if name.endswith(ending):
                    with open(os.path.join(folder, name), "rb") as file:
                        return file.read()
            return b""
        return saved

    def test_a_study_with_too_few_runs_says_so_without_an_error(self):
        self.dccast("sweep", os.path.join(CASES, "start-2d-thickness.toml"), "--set", "quality=draft",
                    "--set", "time.end=5 s", "--grid", "schedule.water_flow.scale=0.8,1.2")
        self.go("studies")
        self.wait_for("answered, 2 of 2 runs succeeded", seconds=40)
        self.find("a[href^='#/study/']").click()
        self.wait_for("needs", ".card", seconds=30)
        self.assertEqual(self.complaints(), [])
        self.on_phone()
        self.assertEqual(self.hidden_sideways(), [])

    def test_the_slab_is_drawn_cut_and_probed(self):
        job = self.submit_case("start-3d.toml", "quality=draft", "time.end=10 s")
        self.client.until_state(job, job_pb2.SUCCEEDED, seconds=60)
        self.go(f"job/{job}")
        canvas = self.find("canvas[aria-label^='Temperature of the slab at 10.0 s']", 40)
        self.wait_for("Temperature, °C", "svg.colours")
        whole, colours, across, up = self.pixels()
        self.assertGreater(whole, 20000)
        self.assertGreater(colours, 20)
        self.assertGreater(max(across, up), 0.85)
        self.assertRegex(self.text(".ruler"), r"^\d+ mm$")
        self.wait_for("Least ", ".card")
        self.assertRegex(self.text("main"), r"Least \d+ °C at [-\d., ]+ mm, largest 6\d\d °C at ")

        # A cut that is seen from where the eye is leaves the camera: the slab stays as large.
        self.find(".cuts option[value='0']").click()
        cut = self.pixels()
        self.assertNotEqual(cut[0], whole)
        scale = self.text(".ruler"), self.find(".ruler").rect["width"]
        self.find(".cuts option[value='-1']").click()
        self.assertEqual(self.pixels()[0], whole)
        self.assertEqual((self.text(".ruler"), self.find(".ruler").rect["width"]), scale)

        # What is colder than a value, closed by the surface on which the field has it.
        self.find(".cuts option[value='3']").click()
        self.wait_for(" °C", ".cuts output")
        slider, drawn = self.find(".cuts input[type=range]"), []
        for key, times in ((Keys.END, 1), (Keys.ARROW_LEFT, 5), (Keys.ARROW_LEFT, 90)):
            for _ in range(times):
                slider.send_keys(key)
            drawn.append(self.pixels()[0])
        self.assertEqual(drawn, sorted(set(drawn), reverse=True))
        self.assertLess(drawn[2], 0.5 * whole)
        self.find(".cuts option[value='-1']").click()
        self.assertEqual(self.pixels()[0], whole)

        # The gap to the block is seen from below at once.
        self.find("select[aria-label=Field] option[value=gap_m]").click()
        self.wait_for("Gap to the block, mm", "svg.colours")
        shown = "return [...document.querySelectorAll('select')].map(s => s.value)"
        self.assertIn("From below", self.browser.execute_script(shown))
        self.find("select[aria-label=Field] option[value=temperature_c]").click()

        canvas.click()
        self.wait_for("°C, moved", ".probe")
        self.assertIn("10.0 s", self.text(".probe"))
        self.find(".stage .marker:not([hidden])")
        time_slider = self.find(".levers.row input[type=range]")
        time_slider.send_keys(Keys.ARROW_LEFT)
        self.wait_for(" 0.0 s: ", ".probe")  # the value follows time
        time_slider.send_keys(Keys.ARROW_RIGHT)
        self.wait_for(" 10.0 s: ", ".probe")

        # From the first frame to the last.
        self.browser.execute_script("""
            window.seen = []; const shown = document.querySelector('.levers.row output');
            new MutationObserver(() => seen.push(shown.textContent)).observe(shown, {childList: true});""")
        self.press("Play")
        self.wait_up_to(10).until(
            lambda _: self.browser.execute_script("return seen") == [f"{t}.0 s" for t in range(-60, 20, 10)])
        self.press("Play")  # it has ended
        self.press("Stop")
        canvas.send_keys(Keys.ARROW_LEFT)
        self.assertNotEqual(self.pixels()[0], cut[0])
        self.assertEqual(self.complaints(), [])

    def test_slabs_that_are_compared_stand_side_by_side_and_turn_together(self):
        jobs = [self.submit_case("start-3d.toml", "quality=draft", "time.end=10 s", f"time.step={step} s")
                for step in (2, 5)]
        for job in jobs:
            self.client.until_state(job, job_pb2.SUCCEEDED, seconds=60)
        self.go("compare/" + "/".join(jobs))
        self.wait_up_to(60).until(lambda _: len(self.browser.find_elements(By.CSS_SELECTOR, ".ruler")) == 2)
        scales = lambda: [ruler.rect["width"] for ruler in self.browser.find_elements(By.CSS_SELECTOR, ".ruler")]
        until(lambda: len(set(scales())) == 1 and scales()[0] > 1, 20)
        before = scales()[0]
        self.find("canvas").send_keys("+")
        until(lambda: len(set(scales())) == 1 and scales()[0] != before, 5)
        self.assertEqual(self.complaints(), [])

    def test_fields_curves_and_files_of_the_slab(self):
        job = self.submit_case("start-2d-thickness.toml", "quality=draft", "time.end=60 s")
        self.client.until_state(job, job_pb2.SUCCEEDED, seconds=60)
        self.go(f"job/{job}")
        self.find("canvas[aria-label^='Temperature']", 40)
        titles = [option.text for option in self.browser.find_elements(
            By.CSS_SELECTOR, "select[aria-label=Field] option")]
        for title in ("Temperature", "Solid fraction", "Stress, von Mises", "Strain, viscoplastic",
                      "Gap to the block", "Hot tears, pressure drop"):
            self.assertIn(title, titles)
        pictures = {self.pixels()[1]}
        for name in ("solid_fraction", "gap_m", "tear_pressure_pa", "von_mises_pa"):
            self.find(f"select[aria-label=Field] option[value={name}]").click()
            title = titles[[o.get_attribute("value") for o in self.browser.find_elements(
                By.CSS_SELECTOR, "select[aria-label=Field] option")].index(name)]
            self.find(f"canvas[aria-label^='{title} of']")
            self.wait_for(title, "svg.colours")
            pictures.add(self.pixels()[1])
        self.assertIn("MPa", self.text("svg.colours"))
        self.assertGreater(len(pictures), 2)

        point, end = (self.find(f"input[aria-label^='{label}']") for label in ("Point", "End of"))
        point.send_keys("10, 20")
        self.press("Over time", "main")
        self.wait_for("Stress, von Mises at 10.0, 20.0 mm", "figcaption")
        self.wait_for("MPa", ".probe")
        end.send_keys("200, 20")
        self.press("Along the line", "main")
        self.wait_for("from 10.0, 20.0 to 200.0, 20.0 mm at 60.0 s", "figcaption")
        stress = max(self.client.ask("QueryResult", id=job, frame=True,
                                     field="von_mises_pa").frame.field.values)

        saved = self.save_files_in("slab")
        self.press("Data (CSV)", "main")
        lines = saved(".csv").decode().splitlines()
        self.assertIn("Stress, von Mises [MPa]", lines[0])
        nodes = len(self.client.ask("QueryResult", id=job, frame=True).frame.temperature_c)
        self.assertEqual(len(lines), nodes + 1)
        largest = max(float(line.split(",")[-1]) for line in lines[1:])
        # Means of the elements around a node, in MPa.
        self.assertGreater(largest, 0.5e-6 * stress)
        self.assertLess(largest, 1e-6 * stress * (1 + 1e-6))
        self.press("Picture (PNG)", "main")
        self.assertEqual(saved(".png")[:8], b"\x89PNG\r\n\x1a\n")
        chart = self.save_files_in("chart")
        for text in ("CSV", "PNG"):
            self.press(text, ".job-parts figcaption")
        self.assertEqual(len(chart(".csv").decode().splitlines()), 102)
        self.assertEqual(chart(".png")[:8], b"\x89PNG\r\n\x1a\n")
        self.assertEqual(self.complaints(), [])

        self.on_phone()
        self.assertEqual(self.hidden_sideways(), [])

    def test_the_slab_of_a_running_job(self):
        job = self.submit_case("start-2d-thickness.toml", "quality=fine", "output.frame_interval=1 s")
        self.client.until_step(job, 20, seconds=60)
        self.go(f"job/{job}")
        self.find("canvas[aria-label^='Temperature']", 40)
        self.assertEqual(self.client.job(job).state, job_pb2.RUNNING)
        slider = lambda: self.read(".levers.row input[type=range]", lambda box: [
            int(box.get_attribute(name)) for name in ("value", "max")])
        shown = lambda: slider()[1]
        before = shown()
        self.wait_up_to(40).until(lambda _: shown() > before)
        value, last = slider()
        self.assertEqual(value, last)
        self.client.cancel(job)
        self.assertEqual(self.complaints(), [])

    def test_a_case_is_uploaded(self):
        with open(os.path.join(CASES, "start-2d-thickness.toml"), encoding="utf-8") as file:
            text = file.read()
        own, faulty = (os.path.join(self.folder, name) for name in ("my line 3.toml", "faulty.toml"))
        with open(own, "w", encoding="utf-8") as file:
            file.write(text)
        with open(faulty, "w", encoding="utf-8") as file:
            file.write(text.replace("casting_speed", "casting_sped", 1)
                       + '\n[mesh2]\nfile = "/etc/passwd"\n')
        self.go("new")
        self.find("#found svg.casting", 40)  # of the form
        upload = self.find("#new-file")
        upload.send_keys(faulty)
        self.wait_for("casting_sped", "#found")
        self.assertNotIn("root:", self.text("#found"))
        self.browser.execute_script("arguments[0].value = ''", upload)  # else the new file is one more
        upload.send_keys(own)
        self.wait_up_to(20).until(
            lambda b: "casting_sped" not in b.find_element(By.ID, "found").text)
        self.find("#found svg.casting")
        self.press("Queue as a job", "#found")
        self.wait_for("Queued as", "#found")
        job = self.text("#found p[role=status] a")
        self.client.until_state(job, job_pb2.SUCCEEDED, job_pb2.RUNNING, seconds=60)
        self.press("What-if with it", "#found")
        self.wait_for("As it is: corner", seconds=60)
        self.assertEqual(self.find("#base").get_attribute("value"), "page: my line 3.toml")
        self.assertNotIn("/", "".join(option.text for option in self.browser.find_elements(
            By.CSS_SELECTOR, "#base option")))
        self.assertEqual(self.complaints(), [])

    def test_a_case_with_its_mesh_and_card_is_uploaded(self):
        names = ("case.toml", "cells.msh", "own.toml")
        case, mesh, card = (os.path.join(self.folder, name) for name in names)
        own_mesh_test.writers_of_the_page()[0](mesh, 0.28, 0.10, 0.02)
        shutil.copy(os.path.join(CASES, "alloys", "aa5182.toml"), card)
        text = own_mesh_test.CASE.replace("\n[mesh]", '\n[mesh]\nfile = "cells.msh"\ngrowth = false')
        text = text.replace('card = "paper"', 'card = "./own.toml"').replace('end = "145 s"', 'end = "20 s"')
        text = re.sub("casting_speed = .*", 'casting_speed = "0 mm/min"', text)
        with open(case, "w", encoding="utf-8") as file:
            file.write(text)
        self.go("new")
        self.find("#found svg.casting", 40)
        upload = self.find("#new-file")
        upload.send_keys(case)
        self.wait_for("choose these files together", "#found")
        upload.send_keys("\n".join((card, mesh, case)))
        self.wait_for("of one processor", "#found", seconds=60)
        self.press("Queue as a job", "#found")
        self.wait_for("Queued as", "#found", seconds=60)
        job = self.text("#found p[role=status] a")
        self.client.until_state(job, job_pb2.SUCCEEDED, seconds=120)

        # The server has mesh and card with the job: they come along.
        self.go(f"job/{job}")
        self.press("What-if with it")
        self.wait_for("As it is: ", seconds=60)
        self.assertEqual(self.complaints(), [])

    def test_a_case_by_a_form(self):
        self.go("new")
        self.find("#found svg.casting", 40)
        box = self.find("#new-slab")
        box.clear()
        box.send_keys("1200mm", Keys.TAB)
        self.wait_for("1200mm", "#found .bad")
        box.clear()
        box.send_keys("1600x500mm", Keys.TAB)
        self.wait_for("1600", "#found p")
        self.assertGreater(self.find("#found svg.casting").size["width"], 100)
        self.press("Queue as a job", "#found")
        self.wait_for("Queued as", "#found", seconds=60)
        job = self.text("#found p[role=status] a")
        case = self.client.ask("QueryResult", id=job).case
        self.assertAlmostEqual(case.section.half_width_m, 0.8)
        self.client.cancel(job)
        self.assertEqual(self.complaints(), [])

    def test_a_sweep_is_begun(self):
        self.go("studies")
        self.find("main summary").click()
        self.wait_for("start-2d-thickness.toml", "#study-case")
        self.press("Begin")
        self.find("#study-axes").send_keys("quality")
        self.press("Begin")
        self.wait_for("write KEY = VALUE", "main .bad")
        self.find("#study-axes").send_keys("= draft\ntime.end = 10 s, 20 s\n")
        self.press("Begin")
        self.wait_for("2 of 2 runs succeeded", seconds=120)
        self.wait_for("time.end", "main table")
        for kind in ("uncertainty", "sensitivity"):
            self.go("studies")
            self.read("main summary", lambda summary: summary.click())
            self.wait_for("start-2d-thickness.toml", "#study-case")
            self.find("#kind").send_keys(kind)
            self.assertEqual(self.browser.find_elements(By.ID, "study-axes"), [])
            self.press("Begin")
            self.wait_for(kind, "main p[role=status]", seconds=30)
            study = self.browser.current_url.split("/")[-1]
            self.client.ask("CancelStudy", id=study)

    def test_a_former_job_is_marked_taken_up_fetched_and_deleted(self):
        with open(os.path.join(CASES, "start-2d-thickness.toml"), encoding="utf-8") as file:
            read = self.client.ask("ReadCase", text=file.read(),
                                   changes=[job_pb2.CaseChange(key="quality", value="draft"),
                                            job_pb2.CaseChange(key="time.end", value="20 s")])
        job = self.client.submit(read.case).id
        self.client.until_state(job, job_pb2.SUCCEEDED, seconds=60)
        self.go(f"job/{job}")
        self.wait_for("since the block started", "p.answer")
        for name in ("curl.csv", "results.h5"):
            size = self.browser.execute_async_script(
                "fetch(arguments[0]).then(r => r.blob()).then(b => arguments[1](b.size))",
                self.find(f"a[href$='{name}']").get_attribute("href"))
            self.assertGreater(size, 500, name)

        self.find("#label").send_keys("line=3")
        self.press("Add")
        self.wait_for("line=3", ".label")
        self.find("main input[type=checkbox]").click()
        until(lambda: self.client.job(job).pinned, 10)
        self.assertEqual(list(self.client.job(job).labels), ["line=3"])
        self.read("[aria-label='Remove the label line=3']", lambda button: button.click())
        until(lambda: not self.client.job(job).labels, 10)

        self.press("What-if with it")
        self.wait_for("As it is: corner", seconds=60)
        self.go(f"job/{job}")
        self.press("Delete")
        self.press("Delete it", "dialog")
        self.wait_for("No jobs yet")
        self.assertEqual(self.complaints(), [])


if __name__ == "__main__":
    main()
