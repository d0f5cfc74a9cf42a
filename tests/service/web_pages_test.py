#!/usr/bin/python3
"""The pages of dccast-web in a real Chromium: sessions, many tabs, keyboard, screens, axe-core, a lost connection."""
import functools
import os
import re
import shutil
import subprocess
import tempfile
import urllib.parse
import urllib.request
import uuid

from selenium import webdriver
from selenium.common.exceptions import StaleElementReferenceException
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import WebDriverWait

from dccast.v1 import job_pb2, line_pb2, service_pb2, study_pb2
from support import BIN, fake_case, main
from web_test import Browser, WebTest
from waiting import WAIT_FACTOR, stays, until

AXE = "axe-core@4.10.2"
# Each page, and what it shows last.
PAGES = {"jobs": "td.sketch svg", "job/{job}": ".colours", "compare/{job}/{other}": ".colours",
         "studies": "tbody a", "study/{study}": "figure svg", "new": "svg.casting", "lines": "tbody a",
         "line/pit-3": "tbody button", "line/pit-3/{uncertain}": "tbody button", "study/{uncertain}": "#line option",
         "what-if": "figure svg", "wall": "figure svg", "sessions": "tbody button"}


@functools.cache
def axe_core():
    """The script of axe-core, by npm; None where its registry cannot be reached."""
    if not shutil.which("npm"):
        return None
    with tempfile.TemporaryDirectory(prefix="dccast-axe-") as folder:
        done = subprocess.run(["npm", "install", "--no-audit", "--no-fund", AXE], cwd=folder,
                              capture_output=True, text=True, timeout=120, check=False)
        if done.returncode != 0:
            return None
        with open(os.path.join(folder, "node_modules/axe-core/axe.min.js"), encoding="utf-8") as file:
            return file.read()


class Hands:
    """What a user does in Chromium."""

    @staticmethod
    def chromium_in(folder):
        options = webdriver.ChromeOptions()
        for word in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage",
                     "--ignore-certificate-errors", "--use-angle=swiftshader",
                     "--enable-unsafe-swiftshader", "--window-size=1280,900",
                     f"--user-data-dir={folder}/chromium"):
            options.add_argument(word)
        return webdriver.Chrome(options=options)

    def wait(self, condition, seconds=20):
        return WebDriverWait(self.chromium, seconds * WAIT_FACTOR, ignored_exceptions=[
            StaleElementReferenceException]).until(lambda _: condition())

    def find(self, selector, text="", seconds=20):
        """The element that is shown, once it has this text."""
        return self.wait(lambda: next(
            (element for element in self.chromium.find_elements(By.CSS_SELECTOR, selector)
             if element.is_displayed() and text in element.text), None), seconds)

    def script(self, text, *arguments):
        return self.chromium.execute_script(text, *arguments)

    def go(self, page):
        self.script("location.hash = arguments[0]", "#/" + page)


class PagesTest(Hands, WebTest):
    """A user's Chromium, signed in by a link."""
    worker = "dccast-worker-fake"

    def start(self, **settings):
        return super().start(listen__metrics="127.0.0.1:0",
                             workers__program=os.path.join(BIN, self.worker), **settings)

    def setUp(self):
        super().setUp()
        self.chromium = self.chromium_in(self.folder)
        self.stub = self.remote(self.token_of("anna"))

    def tearDown(self):
        self.chromium.quit()
        super().tearDown()

    def link(self):
        """One more link for anna, at the address of this server."""
        secret = self.secret_of(self.admin("user", "line", "anna"))
        return f"{self.web.origin}/sign-in.html#{secret}"

    def enter(self):
        self.chromium.get(self.link())
        self.find("#sign-in button").click()
        self.find("#server", "anna")

    def submit_case(self, words="steps=20", **rest):
        request = service_pb2.SubmitJobRequest(case=fake_case(words), request_id=str(uuid.uuid4()), **rest)
        return self.stub.SubmitJob(request, timeout=20).id

    def until_state(self, job, state):
        until(lambda: self.stub.GetJob(service_pb2.GetJobRequest(id=job), timeout=10).state == state, 60)


class Sessions(PagesTest):
    def test_they_are_listed_made_and_ended(self):
        self.enter()
        other = Browser(self.web)
        self.find("header a[href='#/sessions']").click()
        self.find("main tbody", "this one")
        self.assertEqual(len(self.chromium.find_elements(By.CSS_SELECTOR, "tbody tr")), 2)
        self.assertIn("from 127.0.0.1", self.find("main tbody tr", "Browser").text)
        self.find("main tbody tr", "desk")

        self.find("main .bar button", "Sign in another browser").click()
        link = self.find(".copied input").get_attribute("value")
        self.assertRegex(link, "^" + re.escape(self.web.origin) + r"/sign-in\.html#dccast-enrol-\w+-\w+$")
        self.find("main tbody tr", "not used yet")
        self.assertEqual(other.sign_in(link), (200, {"user": "anna"}))
        self.assertEqual(other.call("WhoAmI")[1]["name"], "anna")
        self.assertEqual(Browser(self.web).sign_in(link)[0], 401)

        self.wait(lambda: len(self.rows("Browser")) == 2)
        added, = (row for row in self.rows("Browser") if "this one" not in row.text)
        added.find_element(By.TAG_NAME, "button").click()
        self.find("dialog button", "End it").click()
        self.wait(lambda: len(self.rows("Browser")) == 1)
        self.assertEqual(other.call("WhoAmI")[0], 401)

        own, = self.rows("this one")
        own.find_element(By.TAG_NAME, "button").click()
        self.find("dialog button", "End it").click()
        self.find("#sign-in button")
        self.assertEqual(self.chromium.get_cookies(), [])

    def rows(self, text):
        return [row for row in self.chromium.find_elements(By.CSS_SELECTOR, "tbody tr") if text in row.text]


class Streams(PagesTest):
    def start(self, **settings):
        return super().start(workers__count=8, **settings)

    def test_eight_tabs_share_one(self):
        """HTTP/1.1 permits six connections: with a stream in each tab, nothing else would be answered."""
        jobs = [self.submit_case(f"steps=1000000 sleep_ms=50 number={n}") for n in range(8)]
        for job in jobs:
            self.until_state(job, job_pb2.RUNNING)
        self.enter()
        for number in range(8):
            if number:
                self.chromium.switch_to.new_window("tab")
            self.chromium.get(f"{self.web.origin}/#/job/{jobs[number]}")
        tabs = self.chromium.window_handles
        self.assertEqual(len(tabs), 8)
        for tab in tabs:
            self.chromium.switch_to.window(tab)
            self.find("main .state", "running")
            self.find("main figure path.line")
            answered = self.chromium.execute_async_script(
                "const done = arguments[0], begin = performance.now();"
                "fetch('/server/').then(() => done(performance.now() - begin));")
            self.assertLess(answered, 2000)
            self.wait_for_growth()
        self.assertLessEqual(self.open_streams(), 1)

        # The tabs go, and with them what was followed for them.
        for tab in tabs[1:]:
            self.chromium.switch_to.window(tab)
            self.chromium.close()
        self.chromium.switch_to.window(tabs[0])
        self.wait_for_growth()
        self.go("jobs")
        until(lambda: self.open_streams() == 0, 20)

    def test_one_that_breaks_is_taken_up_again(self):
        job = self.submit_case("steps=1000000 sleep_ms=50")
        self.enter()
        self.go(f"job/{job}")
        self.find("main figure path.line")
        self.web.stop()
        self.find("#server.bad", "trying again")
        self.web.start()
        self.wait_for_growth()

    def wait_for_growth(self):
        """The curl on the page grows."""
        first = self.drawn()
        self.wait(lambda: self.drawn() not in (first, None), 10)

    def drawn(self):
        return self.script("return document.querySelector('figure path.line')?.getAttribute('d')")

    def open_streams(self):
        """Of all users, as the daemon counts them."""
        address = re.findall(r"metrics on (http://\S+)", self.daemon.said())[-1]
        with urllib.request.urlopen(address, timeout=10) as page:
            return int(re.search(r"^dccast_streams_open (\d+)", page.read().decode(), re.MULTILINE)[1])


class Screens(PagesTest):
    worker = "dccast-worker"

    def pages(self):
        """Each page, with jobs and a study of the real solver to show."""
        changes = [job_pb2.CaseChange(key="quality", value="draft"),
                   job_pb2.CaseChange(key="time.end", value="10 s")]
        case = self.stub.ReadCase(service_pb2.ReadCaseRequest(shipped="start-2d-thickness", changes=changes),
                                  timeout=20).case
        plan = study_pb2.SweepPlan(design=study_pb2.SweepPlan.GRID)
        plan.axes.add(key="schedule.water_flow.scale", values=["0.8", "0.9", "1.1", "1.2", "1.3"])
        study = self.stub.CreateStudy(study_pb2.CreateStudyRequest(
            request_id=str(uuid.uuid4()), case=case, sweep=plan), timeout=20).id
        uncertain = self.stub.CreateStudy(study_pb2.CreateStudyRequest(
            request_id=str(uuid.uuid4()), case=case, sweep=study_pb2.SweepPlan(
                purpose=study_pb2.SweepPlan.UNCERTAINTY, design=study_pb2.SweepPlan.LATIN_HYPERCUBE, runs=12,
                axes=[study_pb2.SweepPlan.Axis(key="alloy.conductivity")])), timeout=20).id
        jobs = [self.stub.SubmitJob(service_pb2.SubmitJobRequest(case=case, labels=["line=3"], request_id=name),
                                    timeout=20).id for name in ("one", "other")]
        for job in jobs:
            self.until_state(job, job_pb2.SUCCEEDED)
        sound = line_pb2.LineCasting(outcome=line_pb2.LineCasting.SOUND, count=200)
        self.stub.AddCastings(line_pb2.AddCastingsRequest(
            id="pit-3", request_id="one", recipes=[line_pb2.CastingRecipe(job=jobs[0])],
            castings=[line_pb2.AddCastingsRequest.NewCasting(record=sound)]), timeout=20)
        until(lambda: self.stub.GetStudy(study_pb2.GetStudyRequest(id=uncertain), timeout=10).state
              == study_pb2.STUDY_SUCCEEDED, 120)
        return {page.format(job=jobs[0], other=jobs[1], study=study, uncertain=uncertain): last
                for page, last in PAGES.items()}

    def test_axe_finds_nothing_on_any_page(self):
        axe = axe_core()
        if axe is None:
            self.skipTest("axe-core: npm is not installed, or its registry cannot be reached")
        pages = self.pages()
        self.chromium.get(self.web.origin + "/sign-in.html")
        self.find("#sign-in button")
        found = {"sign-in": self.findings(axe)}
        self.enter()
        for scheme in ("light", "dark"):
            self.chromium.execute_cdp_cmd("Emulation.setEmulatedMedia", {
                "features": [{"name": "prefers-color-scheme", "value": scheme}]})
            for page, last in pages.items():
                self.go(page)
                self.find(f"main {last}", seconds=30)
                found[scheme, page] = self.findings(axe)
        self.find("main tbody button", "End").click()
        self.find("dialog h2")
        found["dialog"] = self.findings(axe)
        self.assertEqual([f"{page}: {rule}" for page, rules in found.items() for rule in rules], [])

    def findings(self, axe):
        """Rules that the page breaks, each with its first place."""
        self.script(axe)
        self.script("for (const each of document.querySelectorAll('details')) each.open = true")
        result = self.chromium.execute_async_script(
            "axe.run().then(arguments[0], error => arguments[0]({error: String(error)}));")
        self.assertGreater(len(result.get("passes", [])), 10, result.get("error"))
        return [f"{rule['id']}: {rule['nodes'][0]['html']}" for rule in result["violations"]]

    def test_nothing_is_wider_than_the_screen(self):
        pages = self.pages()
        self.enter()
        for width in (360, 1280, 1920):
            self.chromium.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
                "width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 500})
            for page, last in pages.items():
                with self.subTest(width=width, page=page):
                    self.go(page)
                    self.find(f"main {last}", seconds=30)
                    self.assertLessEqual(
                        self.script("return document.documentElement.scrollWidth"), width)

    def test_all_pages_are_below_400_kB_and_of_this_server_alone(self):
        pages = self.pages()
        self.enter()
        self.chromium.execute_cdp_cmd("Network.setCacheDisabled", {"cacheDisabled": True})
        self.script("performance.setResourceTimingBufferSize(5000)")
        self.chromium.refresh()
        self.script("performance.setResourceTimingBufferSize(5000)")
        for page, last in pages.items():
            self.go(page)
            self.find(f"main {last}", seconds=30)
        loaded = self.script("""
            return performance.getEntriesByType('resource').concat(performance.getEntriesByType('navigation'))
              .map(each => ({name: each.name, bytes: each.transferSize}));""")
        other = [each["name"] for each in loaded if not each["name"].startswith(self.web.origin + "/")]
        self.assertEqual(other, [])
        files = {each["name"]: each["bytes"] for each in loaded
                 if urllib.parse.urlsplit(each["name"]).path.count("/") == 1}
        self.assertGreater(len(files), 20)
        self.assertLess(sum(files.values()), 400_000)
        print(f"\n{len(files)} files of the pages have {sum(files.values())} bytes")

    def test_something_is_painted_within_a_second_at_1_MB_a_second(self):
        self.enter()
        self.chromium.execute_cdp_cmd("Network.enable", {})
        self.chromium.execute_cdp_cmd("Network.setCacheDisabled", {"cacheDisabled": True})
        self.chromium.execute_cdp_cmd("Network.emulateNetworkConditions", {
            "offline": False, "latency": 20, "downloadThroughput": 1e6, "uploadThroughput": 1e6})
        self.chromium.refresh()
        painted = self.wait(lambda: self.script(
            "return performance.getEntriesByName('first-contentful-paint')[0]?.startTime"))
        self.assertLess(painted, 1000 * WAIT_FACTOR)
        print(f"\nfirst paint after {painted:.0f} ms")


class ByKeyboard(PagesTest):
    """From the link to a submitted job, with the real checks of a case."""
    worker = "dccast-worker"
    clicks = 0

    def press(self, selector, text):
        """Goes to an element by the Tab key, and presses it."""
        self.type_into(selector, Keys.ENTER, text)
        self.clicks += 1

    def type_into(self, selector, keys, text=""):
        wanted = self.wait(lambda: next(
            (element for element in self.chromium.find_elements(By.CSS_SELECTOR, selector)
             if text in element.text), None))
        for _ in range(60):
            if self.chromium.switch_to.active_element == wanted:
                ActionChains(self.chromium).send_keys(keys).perform()
                return
            ActionChains(self.chromium).send_keys(Keys.TAB).perform()
        self.fail(f"{selector} {text} is not reached by the Tab key")

    def test_a_job_is_submitted_in_four_presses(self):
        self.chromium.get(self.link())
        self.press("#sign-in button", "Sign in")
        self.find("#server", "anna")
        self.press("nav a", "New case")
        self.find("svg.casting")
        self.press("#found button", "Queue as a job")
        link = self.find("#found p[role=status] a")
        self.assertLessEqual(self.clicks, 4)
        print(f"\nfrom the link to a queued job: {self.clicks} presses")

        # Pressed once more, as after an answer that was lost, it is the same job.
        job = link.text
        self.assertEqual(self.stub.GetJob(service_pb2.GetJobRequest(id=job), timeout=10).owner, "anna")
        self.press("#found button", "Queue as a job")
        stays(lambda: len(self.stub.ListJobs(service_pb2.ListJobsRequest(), timeout=10).jobs) == 1, 1)
        self.stub.CancelJob(service_pb2.CancelJobRequest(id=job), timeout=10)


    def test_castings_are_typed_and_a_study_is_begun(self):
        self.enter()
        self.press("nav a", "Lines")
        self.press("main summary", "Add castings")
        self.find("#casting-recipe option")
        self.type_into("#line-name", "pit-3")
        self.type_into("#casting-recipe", "start-2d-thickness")
        self.type_into("#casting-count", "200")
        self.press("main .bar button", "Keep it")
        self.find("main td", "200 sound", seconds=30)

        self.press("nav a", "New case")
        self.find("svg.casting")
        self.press("#found button", "Study of it")
        self.find("#study-case option", "page: ")
        self.type_into("#kind", "sensitivity")
        self.press("main .bar button", "Begin")
        self.find("main p[role=status]", "sensitivity", seconds=30)
        study, = self.stub.ListStudies(study_pb2.ListStudiesRequest(), timeout=10).studies
        self.stub.CancelStudy(study_pb2.CancelStudyRequest(id=study.id), timeout=20)

    def test_the_head_is_skipped(self):
        self.enter()
        self.go("studies")
        self.find("main h1", "Studies")
        self.press(".skip", "")
        self.assertEqual(self.chromium.switch_to.active_element.get_attribute("id"), "main")
        self.assertTrue(self.chromium.current_url.endswith("#/studies"))


class LostConnection(PagesTest):
    worker = "dccast-worker"

    def test_it_shows_and_mends_itself_and_no_entry_is_lost(self):
        self.enter()
        self.go("new")
        self.find("svg.casting")
        box = self.find("#new-slab")
        box.clear()
        box.send_keys("1500x")  # half of it
        self.web.stop()
        self.find("#server.bad", "trying again")
        self.assertEqual(box.get_attribute("value"), "1500x")
        box.send_keys("600mm", Keys.TAB)  # asks for the drawing, in vain
        self.find("#found .bad")

        self.web.start()
        self.wait(lambda: "bad" not in self.find("#server").get_attribute("class"))
        self.find("#server", "anna")
        self.assertEqual(self.find("#new-slab").get_attribute("value"), "1500x600mm")
        self.find("main .levers button", "Draw it").click()
        self.find("#found p", "1500")
        self.find("#found button", "Queue as a job").click()
        job = self.find("#found p[role=status] a").text
        self.assertEqual(self.stub.GetJob(service_pb2.GetJobRequest(id=job), timeout=10).owner, "anna")
        self.stub.CancelJob(service_pb2.CancelJobRequest(id=job), timeout=10)


if __name__ == "__main__":
    main()
