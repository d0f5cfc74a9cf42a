#!/usr/bin/python3
"""The dashboard: who gets in, what its server gives, and its pages in a real Chromium."""
import contextlib
import http.client
import json
import os
import re
import shutil
import signal
import socket
import ssl
import stat
import struct
import subprocess
import threading
import time
import urllib.parse

from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import WebDriverWait

from certificates import TestCa
from dccast.v1 import job_pb2, service_pb2
from doctor_test import ClientTest
from support import BIN, ServiceTest, fake_case, main, until

CASES = os.path.join(os.path.dirname(__file__), "..", "..", "cases")
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
        words = [os.path.join(BIN, "dccast"), "--server", self.daemon.address, "dashboard",
                 *self.files, *options]
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
                self.session = response.getheader("Set-Cookie").split(";")[0]
            headers["Cookie"] = self.session
        elif cookie:
            headers["Cookie"] = cookie
        connection.request(method, path, body, headers)
        response = connection.getresponse()
        body = response.read()
        connection.close()
        return response, body

    def own(self):
        return {"Origin": f"http://127.0.0.1:{self.url.port}"}

    def call(self, name, **request):
        response, body = self.ask(f"/call/{name}", "POST", json.dumps(request), **self.own())
        self.assertEqual(response.status, 200, body)
        return json.loads(body)

    def another(self):
        return json.loads(self.ask("/another/", "POST", "", **self.own())[1])["address"]


class Entrance(WithoutBrowser):
    """What is refused, and what is answered."""

    def test_only_the_holder_of_the_key_gets_in_and_the_key_works_once(self):
        for path in ("/", "/app.js", "/bases/", "/?key=" + 64 * "0"):
            response, body = self.ask(path, cookie=None)
            self.assertEqual(response.status, 403, path)
            self.assertNotIn(b"<script", body)
        self.assertEqual(self.ask("/")[0].status, 200)
        self.assertEqual(self.ask(f"/?{self.url.query}", cookie=None)[0].status, 403)
        name = self.session.split("=")[0]
        self.assertEqual(self.ask("/", cookie=f"{name}={64 * '0'}")[0].status, 403)
        another = urllib.parse.urlsplit(self.another())
        self.assertEqual(self.ask(f"/?{another.query}", cookie=None)[0].status, 302)

    def test_other_sites_cannot_use_the_session(self):
        evil = {"Host": f"evil.example:{self.url.port}"}  # a name that its owner points at 127.0.0.1
        self.assertEqual(self.ask("/", **evil)[0].status, 403)
        for origin in ({}, {"Origin": "http://evil.example"}, {"Origin": "null"},
                       {"Origin": "http://127.0.0.1:1"}):
            self.assertEqual(self.ask("/call/ListJobs", "POST", "{}", **origin)[0].status, 403, origin)
        self.assertEqual(self.ask("/bases/", Origin="http://evil.example")[0].status, 403)
        head = self.ask("/")[0]
        self.assertIn("default-src 'none'", head.getheader("Content-Security-Policy"))
        self.assertNotIn("unsafe", head.getheader("Content-Security-Policy"))
        self.assertEqual(head.getheader("Cache-Control"), "no-store")
        cookie = self.ask(f"/?{urllib.parse.urlsplit(self.another()).query}", cookie=None)[0]
        self.assertIn("HttpOnly; SameSite=Strict", cookie.getheader("Set-Cookie"))

    def test_it_listens_on_loopback_alone(self):
        with open("/proc/net/tcp", encoding="ascii") as file:
            listening = [line.split()[1] for line in file if line.split()[3] == "0A"]
        port = f"{self.url.port:04X}"
        self.assertEqual([at for at in listening if at.endswith(":" + port)], ["0100007F:" + port])

    def test_what_pages_do_not_call_is_refused(self):
        for name in ("DeleteJob", "SubmitJob", "Nonsense"):
            self.assertEqual(
                self.ask(f"/call/{name}", "POST", "{}", **self.own())[0].status, 404, name)
        for path in ("/case/?case=/etc/passwd", "/ask/?case=../x", "/ask/..%2Fx"):
            self.assertNotIn(b"root:", self.ask(path)[1])
        nothing = "00000000-0000-4000-8000-000000000000"
        response, body = self.ask("/call/GetJob", "POST", json.dumps({"id": nothing}), **self.own())
        self.assertEqual(response.status, 404)
        self.assertIn(nothing, json.loads(body)["error"])
        self.assertEqual(self.ask("/call/GetJob", "POST", "{", **self.own())[0].status, 400)
        self.assertIn(self.ask("/call/ListJobs", "POST", "x" * 3_000_000, **self.own())[0].status,
                      (400, 413))

    def test_a_job_as_pages_see_it(self):
        job = self.finished_job("steps=30")
        seen = json.loads(self.ask(f"/job/{job}")[1])
        steps = self.client.steps(job)
        self.assertEqual(seen["history"]["time_s"], [step.time_s for step in steps])
        self.assertEqual(seen["history"]["monitors"][0]["curl_m"],
                         [step.monitors[0].displacement_m[1] for step in steps])
        self.assertEqual(self.call("ListJobs")["jobs"][0]["id"], job)
        report, page = self.ask(f"/report/{job}")
        self.assertIn(b"<h1>", page)
        self.assertIn("sandbox", report.getheader("Content-Security-Policy"))
        other = self.finished_job("steps=31")
        self.assertIn(b"comparison", self.ask(f"/compare/?job={job}&job={other}")[1])

    def test_a_watch_ends_when_its_page_is_left(self):
        job = self.client.submit(fake_case("steps=100000 sleep_ms=5"))
        threads = lambda: len(os.listdir(f"/proc/{self.process.pid}/task"))
        self.ask("/")
        before = threads()
        for _ in range(5):
            connection = http.client.HTTPConnection("127.0.0.1", self.url.port, timeout=30)
            connection.request("GET", f"/watch/{job.id}", headers={"Cookie": self.session})
            self.assertTrue(connection.getresponse().readline().startswith(b"data: "))
            connection.close()
        until(lambda: threads() <= before + 2, 20)
        self.client.cancel(job.id)


class Others(ClientTest):
    """Served to other machines: by HTTPS, for a certificate's name, by a viewer's login."""

    def setUp(self):
        super().setUp()
        self.start()
        os.makedirs(os.path.join(self.folder, "pki"))
        self.ca = TestCa(os.path.join(self.folder, "pki"))
        self.words = ("--certificate", self.ca.issue(name="DNS:localhost"), "--key", self.ca.key)

    def test_what_is_refused(self):
        self.log_in("anna")
        without = self.dccast("dashboard", "--listen", "localhost")
        self.assertEqual(without.returncode, 2)
        self.assertIn("--certificate", without.stderr)

        more = self.dccast("dashboard", "--listen", "localhost", *self.words)
        self.assertEqual(more.returncode, 2)
        self.assertIn("as anna, who may do more than look", more.stderr)

        self.log_in("wall", "viewer", "--name", "wall", "--default")
        other_name = self.dccast("dashboard", "--listen", "127.0.0.1", *self.words)
        self.assertEqual(other_name.returncode, 2)
        self.assertIn("is not for 127.0.0.1", other_name.stderr)

        for port in ("7x", "65536", "-1"):
            refused = self.dccast("dashboard", "--listen", "localhost:" + port, *self.words)
            self.assertEqual(refused.returncode, 2)
            self.assertIn("1 to 65535", refused.stderr)
        wrong_key = self.dccast("dashboard", "--listen", "localhost", "--certificate",
                                self.ca.key, "--key", self.ca.key)
        self.assertEqual(wrong_key.returncode, 2)
        self.assertIn("PEM files", wrong_key.stderr)

    def start_for_others(self):
        """A dashboard that serves other machines, with the settings of the user who logged in."""
        return subprocess.Popen(
            [os.path.join(BIN, "dccast"), "dashboard", "--listen", "localhost", *self.words],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
            env={"XDG_CONFIG_HOME": os.path.join(self.folder, "settings"),
                 "PATH": os.environ["PATH"]})

    def test_strangers_neither_fill_it_nor_silence_it(self):
        self.log_in("wall", "viewer")
        process = self.start_for_others()
        context = ssl.create_default_context(cafile=self.ca.certificate)
        try:
            port = urllib.parse.urlsplit(process.stdout.readline().strip()).port

            def page():
                connection = http.client.HTTPSConnection("localhost", port, timeout=30,
                                                         context=context)
                connection.request("GET", "/")
                self.assertEqual(connection.getresponse().status, 403)
                connection.close()

            def send_without_end(end):
                while time.monotonic() < end:
                    with contextlib.suppress(OSError), \
                            socket.create_connection(("localhost", port), 5) as plain, \
                            context.wrap_socket(plain, server_hostname="localhost") as peer:
                        peer.sendall(b"GET / HTTP/1.1\r\nHost: localhost\r\n")
                        while time.monotonic() < end:
                            peer.sendall(1000 * (b"X-Filling: " + 100 * b"y" + b"\r\n"))

            def others_are_served(seconds):
                end = time.monotonic() + seconds
                while time.monotonic() < end:
                    begin = time.monotonic()
                    page()
                    self.assertLess(time.monotonic() - begin, 2)
                    time.sleep(0.1)

            peers = [threading.Thread(target=send_without_end, args=(time.monotonic() + 3,))
                     for _ in range(4)]
            for peer in peers:
                peer.start()
            others_are_served(3)
            for peer in peers:
                peer.join()
            with contextlib.ExitStack() as silent:
                for number in range(100):  # before, within and behind the handshake
                    peer = silent.enter_context(socket.create_connection(("localhost", port), 5))
                    if number % 4 == 0:
                        peer.sendall(b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03")
                    elif number % 4 > 1:
                        with contextlib.suppress(OSError):
                            peer = silent.enter_context(
                                context.wrap_socket(peer, server_hostname="localhost"))
                            peer.sendall(b"GET / HTTP/1.1\r\n")
                others_are_served(1)
            with open(f"/proc/{process.pid}/status", encoding="ascii") as file:
                peak = int(re.search(r"VmHWM:\s+(\d+) kB", file.read())[1])
            self.assertLess(peak, 150_000)
        finally:
            process.send_signal(signal.SIGINT)
            self.assertIn(process.wait(timeout=10), (0, 130))
            process.stdout.close()

    def test_a_viewer_looks(self):
        self.log_in("wall", "viewer")
        process = self.start_for_others()
        try:
            url = urllib.parse.urlsplit(process.stdout.readline().strip())
            self.assertEqual((url.scheme, url.hostname), ("https", "localhost"))

            def ask(method, path, body=None, **headers):
                connection = http.client.HTTPSConnection(
                    "localhost", url.port, timeout=30,
                    context=ssl.create_default_context(cafile=self.ca.certificate))
                connection.request(method, path, body, headers)
                response = connection.getresponse()
                text = response.read()
                connection.close()
                return response, text

            self.assertEqual(ask("GET", "/")[0].status, 403)
            entered = ask("GET", "/?" + url.query)[0]
            self.assertIn("; Secure", entered.getheader("Set-Cookie"))
            cookie = {"Cookie": entered.getheader("Set-Cookie").split(";")[0]}
            own = {**cookie, "Origin": f"https://localhost:{url.port}"}
            self.assertEqual(ask("GET", "/", **cookie, Host=f"evil.example:{url.port}")[0].status, 403)
            self.assertEqual(ask("POST", "/call/ListJobs", "{}", **own)[0].status, 200)
            plain = {**cookie, "Origin": f"http://localhost:{url.port}"}
            self.assertEqual(ask("POST", "/call/ListJobs", "{}", **plain)[0].status, 403)
            self.assertEqual(json.loads(ask("GET", "/server/", **cookie)[1])["role"], "VIEWER")
            response, text = ask("POST", "/keep/?case=start-2d-thickness", "", **own)
            self.assertEqual(response.status, 404, text)
            self.assertIn("viewer", json.loads(text)["error"])
        finally:
            process.send_signal(signal.SIGINT)
            self.assertIn(process.wait(timeout=10), (0, 130))
            process.stdout.close()


class RealRuns(WithoutBrowser):
    """What comes from a real solver."""
    worker = "dccast-worker"

    def events(self, path):
        body = self.ask(path)[1].decode()
        return [json.loads(line[6:]) for line in body.splitlines() if line.startswith("data: ")]

    def test_what_if_and_frames(self):
        case = "?case=start-2d-thickness&" + "&".join(
            "set=" + urllib.parse.quote(change) for change in ("quality=draft", "time.end=20 s"))
        answer = self.events(f"/ask/{case}")[-1]["answer"]
        self.assertEqual(answer["state"], "SUCCEEDED")
        self.assertGreater(answer["relative_curl_error"], 0)

        fault = self.events(f"/ask/{case}&set=schedule.casting_sped%3D1")[-1]
        self.assertIn("casting_sped", fault["error"])

        text = self.ask(f"/case/{case}")[1].decode()
        self.assertIn('end = "20 s"', text)

        job = json.loads(self.ask(f"/keep/{case}", "POST", "", **self.own())[1])["job"]
        self.client.until_state(job, job_pb2.SUCCEEDED)
        times = json.loads(self.ask(f"/frames/{job}")[1])
        self.assertGreater(len(times), 1)

        raw = self.ask(f"/frame/{job}?number={len(times)}")[1]
        nodes, elements, per, triangles, edges, dimension = struct.unpack("<6i", raw[:24])
        self.assertEqual(len(raw), 32 + 4 * (4 + 7 * nodes + elements * per + 3 * triangles + 2 * edges))

        frame = self.client.stub.QueryResult(
            service_pb2.QueryResultRequest(id=job, frame=True), timeout=20).frame
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

    def find(self, selector, seconds=20):
        return WebDriverWait(self.browser, seconds).until(
            lambda browser: browser.find_element(By.CSS_SELECTOR, selector))

    def wait_for(self, text, selector="main", seconds=20):
        def there(browser):
            found = browser.find_elements(By.CSS_SELECTOR, selector)
            return any(text in element.text for element in found)
        WebDriverWait(self.browser, seconds, ignored_exceptions=[Exception]).until(there)

    def another(self):
        return self.browser.execute_async_script(
            "const done = arguments[0];"
            "fetch('/another/', {method: 'POST'}).then(r => r.json()).then(r => done(r.address));")

    def complaints(self):
        return [entry["message"] for entry in self.browser.get_log("browser")
                if entry["level"] == "SEVERE" and "favicon" not in entry["message"]
                and "/frames/" not in entry["message"]]  # the fake worker has none


class Pages(InBrowser):
    def test_jobs_by_mouse_and_keyboard(self):
        jobs = [self.finished_job(f"steps=20 number={n}") for n in range(3)]
        self.wait_for("3 jobs: 0 running, 0 queued, 3 succeeded")
        self.assertEqual(len(self.browser.find_elements(By.CSS_SELECTOR, "tbody tr")), 3)

        self.find("td.sketch svg")
        box = self.find("input[type=search]")
        box.send_keys("number=1")
        WebDriverWait(self.browser, 10).until(
            lambda b: len(b.find_elements(By.CSS_SELECTOR, "tbody tr")) == 1)
        box.send_keys(Keys.CONTROL, "a", Keys.DELETE)
        for checkbox in self.browser.find_elements(By.CSS_SELECTOR, "tbody input")[:2]:
            checkbox.send_keys(Keys.SPACE)
        self.find(".bar button").send_keys(Keys.ENTER)
        self.wait_for("2 jobs compared")
        self.wait_for("run 2, corner: ")
        self.assertTrue(self.find("figure svg").get_attribute("aria-label").startswith("Curl of"))

        self.go("jobs")
        self.find(f"a[href='#/job/{jobs[0]}']").click()
        WebDriverWait(self.browser, 20).until(lambda browser: browser.title == "Job · dccast")
        self.wait_for("succeeded")
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
        WebDriverWait(self.browser, 20).until(lambda _: drawn() not in (first, None))
        [button for button in self.browser.find_elements(By.CSS_SELECTOR, ".bar button")
         if button.text == "Cancel"][0].click()
        self.wait_for("cancelled")
        self.client.until_state(job.id, job_pb2.CANCELLED)

    def test_hostile_names_are_inert(self):
        job = self.finished_job("steps=20 " + HOSTILE)
        self.wait_for("onerror", "tbody")
        for page in ("jobs", f"job/{job}", f"compare/{job}/{job}", "wall", "studies"):
            self.go(page)
            time.sleep(0.5)
            self.assertNotIn("broken", self.browser.title)
            self.assertEqual(self.browser.find_elements(By.CSS_SELECTOR, "main img"), [])

    def test_a_thousand_jobs(self):
        for n in range(1000):
            self.client.submit(fake_case(f"sleep_ms=50 steps=1000 number={n}"), request_id=f"r{n}")
        self.browser.get(self.another())
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
        WebDriverWait(self.browser, 30).until(
            lambda b: "bad" in b.find_element(By.ID, "server").get_attribute("class"))
        self.daemon.settings["listen"] = self.daemon.address
        self.restart()
        WebDriverWait(self.browser, 30).until(
            lambda b: "bad" not in b.find_element(By.ID, "server").get_attribute("class"))
        self.stop_dashboard()
        WebDriverWait(self.browser, 30).until(
            lambda b: "start dccast dashboard again" in b.find_element(By.ID, "server").text)
        self.start_dashboard(self.url.port)  # another session: the page asks for its key
        WebDriverWait(self.browser, 30).until(
            lambda b: "key in the address" in b.find_element(By.ID, "server").text)
        self.browser.get(self.address)
        self.wait_for("No jobs yet")

    def test_screen_readers_and_small_screens(self):
        self.finished_job("steps=20")
        for page in ("jobs", "studies", "what-if", "wall"):
            self.go(page)
            time.sleep(1)
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
            time.sleep(0.5)
            wide = self.browser.execute_script("return document.documentElement.scrollWidth")
            self.assertLessEqual(wide, 360, page)
            ink, paper = (self.browser.execute_script(
                f"return getComputedStyle(document.body).{name}") for name in ("color", "backgroundColor"))
            self.assertGreater(sum(map(int, ink[4:-1].split(","))),
                               sum(map(int, paper[4:-1].split(","))))


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
        self.assertIn("±", self.find(".what-if strong").text)

        self.wait_for("run 2, corner: ", "#difference")
        self.assertRegex(self.find("#difference").text, r"± \d[.\d]* mm, (real|within its error)\.")
        self.assertIn("less 1, mm", self.find("#difference table").text)

        # While the next key press is computed, only the case as it is has bands.
        WebDriverWait(self.browser, 60).until(
            lambda browser: len(browser.find_elements(By.CSS_SELECTOR, "path.band")) == 6)
        [b for b in self.browser.find_elements(By.CSS_SELECTOR, ".bar button")
         if b.text == "Keep as a job"][0].click()
        self.wait_for("Queued as")
        job = self.find("p[role=status] a").text
        changes = {change.key: change.value for change in self.client.job(job).changes}
        self.assertEqual(changes["schedule.water_flow.scale"], "0.80")
        self.assertEqual(self.complaints(), [])

    def test_a_study_shows_its_answer(self):
        made = subprocess.run(
            [os.path.join(BIN, "dccast"), "--server", self.daemon.address, "uncertainty",
             os.path.join(CASES, "start-2d-thickness.toml"), "--set", "time.end=20 s", "--only",
             "alloy.conductivity", "--only", "cooling.water.temperature", "--runs", "10"],
            capture_output=True, text=True, timeout=90, check=True)
        self.go("study/" + re.search(r"study ([0-9a-f-]{36})", made.stdout)[1])
        self.wait_for("9 of 10 castings have", "#answer", seconds=30)
        self.assertIn("alone, %", self.find("#answer table").text)
        self.assertEqual(len(self.browser.find_elements(By.CSS_SELECTOR, "#answer figure svg")), 2)
        self.assertEqual(self.complaints(), [])

    def test_the_slab_is_drawn_cut_and_probed(self):
        path = os.path.join(CASES, "start-3d.toml")
        submitted = subprocess.run(
            [os.path.join(BIN, "dccast"), "--server", self.daemon.address, "submit", path, "--set",
             "quality=draft", "--set", "time.end=10 s"], capture_output=True, text=True, timeout=60,
            check=True)
        job = submitted.stdout.strip()
        self.client.until_state(job, job_pb2.SUCCEEDED)
        self.go(f"job/{job}")
        canvas = self.find("canvas", 40)
        self.wait_for("Colours from 20")
        pixels = lambda: self.browser.execute_async_script("""
            const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(() => {
              const c = document.querySelector('canvas'), gl = c.getContext('webgl'), p = new Uint8Array(4 * c.width * c.height);
              gl.readPixels(0, 0, c.width, c.height, gl.RGBA, gl.UNSIGNED_BYTE, p);
              const seen = new Set(); let filled = 0;
              for (let i = 0; i < p.length; i += 4) if (p[i + 3]) { filled++; seen.add(p[i] << 16 | p[i + 1] << 8 | p[i + 2]); }
              done([filled, seen.size]); }));""")
        whole, colours = pixels()

        self.assertGreater(whole, 20000)
        self.assertGreater(colours, 20)

        self.find(".cuts option[value='0']").click()
        cut, _ = pixels()
        self.assertLess(cut, whole)
        self.assertGreater(cut, 0.3 * whole)

        canvas.click()
        self.wait_for("°C, moved")
        canvas.send_keys(Keys.ARROW_LEFT)
        self.assertNotEqual(pixels()[0], cut)
        self.assertEqual(self.complaints(), [])


if __name__ == "__main__":
    main()
