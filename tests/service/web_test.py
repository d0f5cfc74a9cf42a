#!/usr/bin/python3
"""dccast-web: users sign in with a line, and ask with the rights of their token and no others."""
import base64
import contextlib
import getpass
import hashlib
import http.client
import json
import os
import re
import signal
import socket
import ssl
import stat
import struct
import subprocess
import tempfile
import threading
import time
import unittest
import uuid

from google.protobuf import json_format
from selenium import webdriver
from selenium.common.exceptions import StaleElementReferenceException
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait

from access_test import AccessTest
from certificates import TestCa
from support import BIN, SANITIZED, SocketConnection, fake_case, main
from waiting import WAIT_FACTOR, turns, until

SERVICE = "/dccast.v1.SimulationService/"
JSON = {"Content-Type": "application/json"}


class Browser:
    """What a page of the server sends, with the cookie that it was given."""

    def __init__(self, web, cookie=""):
        self.web, self.cookie = web, cookie

    def ask(self, method, path, body=None, **headers):
        headers = {name.replace("_", "-"): value for name, value in headers.items()}
        if self.cookie:
            headers.setdefault("Cookie", self.cookie)
        if method != "GET":
            headers = {"Origin": self.web.origin, **JSON, **headers}
        connection = self.web.connection()
        connection.request(method, path, body, headers)
        response = connection.getresponse()
        text = response.read()
        connection.close()
        return response, text

    def post(self, path, body, **headers):
        response, text = self.ask("POST", path, json.dumps(body), **headers)
        return response.status, json.loads(text or "{}")

    def call(self, method, body=None, **headers):
        return self.post(SERVICE + method, body or {}, **headers)

    def sign_in(self, line):
        response, text = self.ask("POST", "/session/in", json.dumps({"secret": line}))
        if response.status == 200:
            self.set_cookie = response.getheader("Set-Cookie")
            self.cookie = self.set_cookie.split(";")[0]
        return response.status, json.loads(text)

    def stream(self, method, body):
        """The connection and the response of a stream."""
        text = json.dumps(body).encode()
        connection = self.web.connection()
        connection.request("POST", SERVICE + method, struct.pack(">BI", 0, len(text)) + text,
                           {"Origin": self.web.origin, "Cookie": self.cookie,
                            "Content-Type": "application/connect+json"})
        response = connection.getresponse()
        assert response.status == 200, response.status
        return connection, response


def message(response):
    """The next message of a stream: flags and content."""
    flags, size = struct.unpack(">BI", response.read(5))
    return flags, json.loads(response.read(size))


class Web:
    """The program, with a certificate of a CA of the tests or behind a proxy."""

    def __init__(self, folder, daemon, *options, port=None, path=None):
        self.words = [os.path.join(BIN, "dccast-web"), "serve", "--socket", daemon.address, "--state",
                      os.path.join(folder, "web"), *options]
        self.is_behind = "--behind" in options
        self.ca = os.path.join(folder, "ca.pem")
        self.port, self.path = port, path
        self.start()

    def start(self):
        self.process = subprocess.Popen(
            [*self.words, "--listen",
             f"unix:{self.path}" if self.path else f"127.0.0.1:{self.port or 0}"],
            stderr=subprocess.PIPE, text=True)
        line = self.process.stderr.readline()
        found = re.search(r"serving at (?:unix:.*|.*port (\d+))$", line)
        assert found, line
        self.port = int(found[1] or 0)
        self.origin = "https://dccast.test" if self.is_behind else f"https://127.0.0.1:{self.port}"

    def stop(self):
        self.process.send_signal(signal.SIGTERM)
        code = self.process.wait(timeout=10)
        self.process.stderr.close()
        return code

    def connection(self):
        if self.path:
            return SocketConnection(self.path)
        if self.is_behind:
            return http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        return http.client.HTTPSConnection("127.0.0.1", self.port, timeout=60,
                                           context=ssl.create_default_context(cafile=self.ca))


class WebTest(AccessTest):
    def setUp(self):
        super().setUp()
        # The user of this test is the one of dccast-web, too.
        self.start(access__web_user=getpass.getuser(), access__web_address="https://dccast.test")
        self.ca = TestCa(self.folder)
        self.options = ["--certificate", self.ca.issue("web.pem"), "--key", self.ca.key]
        self.web = Web(self.folder, self.daemon, *self.options)
        self.browser = Browser(self.web)

    def tearDown(self):
        self.web.stop()
        super().tearDown()

    def line_for(self, name, role="submitter"):
        return re.search(r"\S+/sign-in.html#\S+",
                         self.admin("user", "add", name, "--role", role))[0]

    def signed_in(self, name, role="submitter"):
        browser = Browser(self.web)
        self.assertEqual(browser.sign_in(self.line_for(name, role)), (200, {"user": name}))
        return browser

    def submit(self, browser, words="steps=3", **headers):
        body = {"case": json.loads(json_format.MessageToJson(fake_case(words))),
                "request_id": str(uuid.uuid4())}
        return browser.call("SubmitJob", body, **headers)


class Signing(WebTest):
    def test_a_link_signs_in_once(self):
        link = self.line_for("anna")
        self.assertEqual(self.browser.call("WhoAmI")[0], 401)
        self.assertEqual(self.browser.sign_in(link), (200, {"user": "anna"}))
        cookie = self.browser.set_cookie
        self.assertTrue(cookie.startswith("__Host-dccast="))
        for attribute in ("Path=/", "Secure", "HttpOnly", "SameSite=Strict"):
            self.assertIn("; " + attribute, cookie)
        self.assertNotIn("dccast-token", cookie)

        status, who = self.browser.call("WhoAmI")
        self.assertEqual((status, who["name"], who["proof"]), (200, "anna", "token"))
        server = json.loads(self.browser.ask("GET", "/server/")[1])
        self.assertEqual((server["user"], server["shared"]), ("anna", True))
        self.assertIn(" on web, until", self.admin("user", "list"))

        status, answer = Browser(self.web).sign_in(link)
        self.assertEqual(status, 401)
        self.assertIn("one-time secret", answer["message"])
        self.assertIn("no line or link", Browser(self.web).sign_in("nonsense")[1]["message"])

    def test_files_are_for_everybody(self):
        for path in ("/", "/app.js", "/sign-in.html", "/sign_in.js"):
            self.assertEqual(self.browser.ask("GET", path)[0].status, 200, path)
        for path in ("/server/", "/cases/", "/job/last", "/jobs/last/report"):
            self.assertEqual(self.browser.ask("GET", path)[0].status, 401, path)

    def test_restart_keeps_sessions_and_sign_out_ends_them(self):
        anna = self.signed_in("anna")
        copied = Browser(self.web, anna.cookie)
        self.assertEqual(self.web.stop(), 0)
        self.web.start()
        self.assertEqual(anna.call("WhoAmI")[1]["name"], "anna")

        response, _ = anna.ask("POST", "/session/out", "{}")
        self.assertEqual(response.status, 200)
        self.assertIn("Max-Age=0", response.getheader("Set-Cookie"))
        status, error = copied.call("WhoAmI")
        self.assertEqual((status, error["code"]), (401, "unauthenticated"))
        self.assertNotIn(" on web, until", self.admin("user", "list"))

    def test_exchanged_keys(self):
        anna = self.signed_in("anna")
        exchange = [os.path.join(BIN, "dccast-web"), "exchange-key", "--state",
                    os.path.join(self.folder, "web")]
        for status in (200, 401):
            subprocess.run(exchange, check=True, timeout=30)
            self.web.stop()
            self.web.start()
            self.assertEqual(anna.call("WhoAmI")[0], status)

    def test_attempts_are_limited(self):
        statuses = [self.browser.sign_in("dccast-enrol-x")[0] for _ in range(12)]
        self.assertEqual(statuses[0], 401)
        # A minute may begin between them: two parts of at most ten.
        self.assertTrue(429 in statuses or
                        429 in [self.browser.sign_in("dccast-enrol-x")[0] for _ in range(12)])


class Rights(WebTest):
    def test_a_job_by_json_and_its_stream(self):
        anna, bert = self.signed_in("anna"), self.signed_in("bert")
        status, job = self.submit(anna)
        self.assertEqual((status, job["owner"]), (200, "anna"))
        connection, response = anna.stream("WatchJob", {"id": job["id"], "from_sequence": 1})
        flags, last = 0, {}
        while flags != 2:
            event, (flags, last) = last, message(response)
        connection.close()
        self.assertEqual(last, {})
        self.assertIn("terminal", json.dumps(event))

        status, error = bert.call("CancelJob", {"id": job["id"]})
        self.assertEqual((status, error["code"]), (403, "permission_denied"))
        entry = self.audit("--job", job["id"])[0]
        self.assertEqual((entry["user"], entry["from"]), ("anna", "ipv4:127.0.0.1:0"))

    def test_a_viewer_looks(self):
        wall = self.signed_in("wall", "viewer")
        self.assertEqual(json.loads(wall.ask("GET", "/server/")[1])["role"], "VIEWER")
        self.assertEqual(wall.call("ListJobs")[0], 200)
        status, error = self.submit(wall)
        self.assertEqual((status, error["code"]), (403, "permission_denied"))
        self.assertIn("viewer", error["message"])

    def test_bearer_wins_over_the_cookie(self):
        anna = self.signed_in("anna")
        bearer = "Bearer " + self.token_of("bert")
        self.assertEqual(anna.call("WhoAmI", Authorization=bearer)[1]["name"], "bert")
        # A program sends no Origin.
        program = Browser(self.web)
        status, who = program.call("WhoAmI", Authorization=bearer, Origin="")
        self.assertEqual((status, who["name"]), (200, "bert"))
        self.assertEqual(program.call("WhoAmI", Authorization="Bearer nonsense")[0], 401)
        self.assertEqual(anna.call("WhoAmI", Authorization="Bearer dccast-token-0-0")[0], 401)

    def test_cookies_that_do_not_count(self):
        anna = self.signed_in("anna")
        name, value = anna.cookie.split("=")
        forged = value[:40] + ("0" if value[40] != "0" else "1") + value[41:]
        for cookie in (f"{name}={forged}", f"{name}=", f"{name}=zz", f"dccast={value}"):
            self.assertEqual(Browser(self.web, cookie).call("WhoAmI")[0], 401, cookie)
        self.assertEqual(anna.call("WhoAmI", Origin="https://evil.test")[0], 401)
        self.assertEqual(anna.call("WhoAmI", Content_Type="text/plain")[0], 401)
        foreign = anna.ask("GET", "/server/", Origin="https://evil.test")[0]
        self.assertEqual(foreign.status, 401)
        self.assertIsNone(foreign.getheader("Access-Control-Allow-Origin"))
        self.assertEqual(anna.call("WhoAmI")[0], 200)

    def test_a_token_in_an_address_is_refused(self):
        token = self.token_of("bert")
        for query in ("token=" + token, "key=" + token, "access_token=x"):
            response, text = self.browser.ask("GET", f"/server/?{query}")
            self.assertEqual(response.status, 400)
            self.assertIn("Authorization", json.loads(text)["message"])

    def test_disabled_users_lose_their_streams_within_a_second(self):
        anna = self.signed_in("anna")
        _, job = self.submit(anna, "steps=1000000 sleep_ms=50")
        connection, response = anna.stream("WatchJob", {"id": job["id"], "from_sequence": 1})
        message(response)
        self.admin("user", "disable", "anna")
        begin, flags, last = time.monotonic(), 0, {}
        while flags != 2:
            flags, last = message(response)
        self.assertLess(time.monotonic() - begin, WAIT_FACTOR)
        connection.close()
        self.assertEqual(last["error"]["code"], "unauthenticated")
        self.assertEqual(anna.call("WhoAmI")[0], 401)

    def test_requests_of_a_session_beyond_the_limit_are_refused_by_name(self):
        anna, bert = self.signed_in("anna"), self.signed_in("bert")
        _, job = self.submit(anna, "steps=1000000 sleep_ms=50")
        streams = [anna.stream("WatchJob", {"id": job["id"], "from_sequence": 1})
                   for _ in range(32)]
        status, error = anna.call("WhoAmI")
        self.assertEqual((status, error["code"]), (429, "resource_exhausted"))
        self.assertIn("32 requests", error["message"])
        self.assertEqual(bert.call("WhoAmI")[0], 200)
        for connection, response in streams:
            response.close()
            connection.close()
        until(lambda: anna.call("WhoAmI")[0] == 200, 20)


class Resources(WebTest):
    """What programs fetch and send by plain HTTP."""
    RESOURCES = ("report", "results.h5", "curl.csv", "frame")

    def setUp(self):
        super().setUp()
        self.token = self.token_of("anna")
        self.bearer = {"Authorization": "Bearer " + self.token}
        self.anna = Browser(self.web)

    def start(self, **settings):
        return super().start(access__read="own", workers__program=os.path.join(BIN, "dccast-worker"),
                             **settings)

    def get(self, path, **headers):
        return self.anna.ask("GET", path, **{**self.bearer, **headers})

    def finished(self):
        read = self.anna.call("ReadCase", {
            "shipped": "start-2d-thickness",
            "changes": [{"key": "quality", "value": "draft"}, {"key": "time.end", "value": "20 s"},
                        {"key": "title", "value": "=HYPERLINK(1)"}]}, **self.bearer)[1]
        _, job = self.anna.call("SubmitJob", {"request_id": str(uuid.uuid4()), "case": read["case"]},
                                **self.bearer)
        until(lambda: self.anna.call("GetJob", {"id": job["id"]}, **self.bearer)[1]["state"]
              == "SUCCEEDED", 60)
        return job["id"]

    def test_each_is_that_of_its_job_and_of_its_owner(self):
        job = self.finished()
        fetched = {name: self.get(f"/jobs/{job}/{name}") for name in self.RESOURCES}
        for name, (response, _) in fetched.items():
            self.assertEqual(response.status, 200, name)
        report, page = fetched["report"]
        self.assertIn(b"<h1>", page)
        self.assertIn("sandbox", report.getheader("Content-Security-Policy"))
        table = fetched["curl.csv"][1].decode().splitlines()
        self.assertRegex(table[0], "^time_s,cast_length_m,.*_curl_m,.*beyond_validity$")
        self.assertGreater(len(table), 5)
        nodes = struct.unpack_from("<i", fetched["frame"][1])[0]
        name = json.loads(self.get(f"/frames/{job}")[1])["fields"][0]["name"]
        field = self.get(f"/jobs/{job}/frame?field={name}")
        self.assertEqual((field[0].status, len(field[1])), (200, 4 * nodes), name)

        response, whole = fetched["results.h5"]
        stored = os.path.join(self.daemon.settings["data_directory"], "jobs", job, "results.h5")
        with open(stored, "rb") as file:
            self.assertEqual(whole, file.read())
        tag = response.getheader("ETag")
        self.assertEqual(tag.strip('"'), hashlib.sha256(whole).hexdigest())
        again, nothing = self.get(f"/jobs/{job}/results.h5", If_None_Match=tag)
        self.assertEqual((again.status, nothing), (304, b""))
        part, rest = self.get(f"/jobs/{job}/results.h5", Range="bytes=100-")
        self.assertEqual((part.status, rest), (206, whole[100:]))
        self.assertEqual(part.getheader("Content-Range"),
                         f"bytes 100-{len(whole) - 1}/{len(whole)}")

        _, jobs = self.get("/jobs.csv")
        head, line = jobs.decode().splitlines()
        self.assertTrue(head.startswith("id,title,state,"))
        self.assertTrue(line.startswith(f"{job},'=HYPERLINK(1),SUCCEEDED,anna,"), line)
        self.assertEqual(len(self.get("/jobs.csv?state=queued")[1].decode().splitlines()), 1)
        self.assertEqual(self.get(f"/jobs/last/curl.csv")[1], fetched["curl.csv"][1])

        bert = self.signed_in("bert")  # reads their own jobs alone
        for name in self.RESOURCES:
            response, text = bert.ask("GET", f"/jobs/{job}/{name}")
            self.assertEqual((name, response.status), (name, 404))
            self.assertEqual(json.loads(text)["code"], "not_found")
        self.assertEqual(len(bert.ask("GET", "/jobs.csv")[1].decode().splitlines()), 1)

    def test_faults_are_named(self):
        nothing = "/jobs/00000000-0000-4000-8000-000000000000/"
        for name in self.RESOURCES:
            self.assertEqual(self.get(nothing + name)[0].status, 404, name)
        for path, permitted in ((nothing + "frame?number=x", "0 to"), ("/jobs.csv?limit=-1", "0 to"),
                                ("/jobs.csv?state=lost", "queued, running")):
            response, text = self.get(path)
            self.assertEqual(response.status, 400, path)
            self.assertIn(permitted, json.loads(text)["message"])
        _, text = self.get(nothing + "report")
        self.assertEqual(json.loads(text)["details"][0]["debug"]["reason"], "NOT_FOUND")
        self.assertEqual(self.get("/jobs/x/y/report")[0].status, 404)
        case = {"section": {"half_width_m": -1}}
        status, error = self.anna.call("SubmitJob", {"request_id": str(uuid.uuid4()), "case": case},
                                       **self.bearer)
        self.assertEqual((status, error["code"]), (400, "invalid_argument"))
        self.assertIn("section.half_width", [fault["field"] for fault in
                                             error["details"][1]["debug"]["faults"]])

    def test_who_may_ask(self):
        def basic(user, token):
            return "Basic " + base64.b64encode(f"{user}:{token}".encode()).decode()

        def status(path, **headers):
            return Browser(self.web).ask("GET", path, **headers)[0].status

        response = Browser(self.web).ask("GET", "/jobs.csv")[0]
        self.assertEqual((response.status, response.getheader("WWW-Authenticate")),
                         (401, 'Basic realm="dccast"'))
        self.assertEqual(status("/jobs.csv", Authorization=basic("anna", self.token)), 200)
        self.assertEqual(self.signed_in("bert").ask("GET", "/jobs.csv")[0].status, 200)
        for wrong in (basic("bert", self.token), basic("anna", self.token + "0"), basic("anna", "x"),
                      basic("anna", self.token)[:-4], "Basic ", "Basic =", "Basic " + 5000 * "x"):
            self.assertEqual(status("/jobs.csv", Authorization=wrong), 401, wrong)
        for path in ("/server/", "/jobs/last/report", "/jobs/last/frame", "/nonsense"):
            response = Browser(self.web).ask("GET", path, Authorization=basic("anna", self.token))[0]
            self.assertEqual((response.status, response.getheader("WWW-Authenticate")), (401, None))
        for path in (f"/jobs.csv?token={self.token}", f"/jobs/{self.token}/report"):
            self.assertEqual(self.get(path)[0].status, 400)

    def put(self, content, sha256=None, browser=None, **headers):
        sha256 = sha256 or hashlib.sha256(content).hexdigest()
        response, text = (browser or self.anna).ask("PUT", f"/attachments/{sha256}?name=slab.msh",
                                                    content, **{**self.bearer, **headers})
        return response.status, json.loads(text)

    def test_attachments_are_streamed(self):
        content = os.urandom(1000) * 20_000  # 20 MB
        self.assertEqual(self.put(content), (200, {"was_there": False}))
        self.assertEqual(self.put(content), (200, {"was_there": True}))
        if not SANITIZED:
            self.assertLess(self.peak_memory(), 100_000)
        status, error = self.put(b"else", hashlib.sha256(b"this").hexdigest())
        self.assertEqual((status, error["code"]), (400, "invalid_argument"))
        self.assertIn("upload it again", error["message"])
        self.assertIn("sha256sum", self.put(b"x", "X")[1]["message"])

        chunked = self.anna.ask("PUT", "/attachments/" + 64 * "0", iter([b"x"]),
                                Transfer_Encoding="chunked", **self.bearer)
        self.assertIn("Content-Length", json.loads(chunked[1])["message"])
        bert = self.signed_in("bert")
        self.bearer = {}
        self.assertEqual(self.put(b"of bert", browser=bert)[0], 200)
        self.assertEqual(self.put(b"of bert", browser=bert, Origin="https://evil.test")[0], 401)
        viewer = self.signed_in("wall", "viewer")
        self.assertEqual(self.put(b"x", browser=viewer)[0], 403)

    def peak_memory(self):
        with open(f"/proc/{self.web.process.pid}/status", encoding="ascii") as file:
            return int(re.search(r"VmHWM:\s+(\d+) kB", file.read())[1])


class Strangers(WebTest):
    def page(self):
        response, _ = self.browser.ask("GET", "/")
        self.assertEqual(response.status, 200)

    def are_others_served(self, seconds):
        for _ in turns(seconds, 0.1):
            begin = time.monotonic()
            self.page()
            self.assertLess(time.monotonic() - begin, 2)

    def test_they_neither_fill_it_nor_silence_it(self):
        port, context = self.web.port, ssl.create_default_context(cafile=self.web.ca)

        def send_without_end(end):
            while time.monotonic() < end:
                with contextlib.suppress(OSError), \
                        socket.create_connection(("127.0.0.1", port), 5) as plain, \
                        context.wrap_socket(plain, server_hostname="127.0.0.1") as peer:
                    peer.sendall(b"GET / HTTP/1.1\r\nHost: localhost\r\n")
                    while time.monotonic() < end:
                        peer.sendall(1000 * (b"X-Filling: " + 100 * b"y" + b"\r\n"))

        peers = [threading.Thread(target=send_without_end, args=(time.monotonic() + 3,))
                 for _ in range(4)]
        for peer in peers:
            peer.start()
        self.are_others_served(3)
        for peer in peers:
            peer.join()
        with contextlib.ExitStack() as silent:
            for number in range(100):  # before, within and behind the handshake
                peer = silent.enter_context(socket.create_connection(("127.0.0.1", port), 5))
                if number % 4 == 0:
                    peer.sendall(b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03")
                elif number % 4 > 1:
                    with contextlib.suppress(OSError):
                        peer = silent.enter_context(
                            context.wrap_socket(peer, server_hostname="127.0.0.1"))
                        peer.sendall(b"GET / HTTP/1.1\r\n")
            self.are_others_served(1)
        with open(f"/proc/{self.web.process.pid}/status", encoding="ascii") as file:
            peak = int(re.search(r"VmHWM:\s+(\d+) kB", file.read())[1])
        if not SANITIZED:  # AddressSanitizer keeps what is freed for a while
            self.assertLess(peak, 150_000)

    def test_other_names_of_the_server_are_refused(self):
        self.assertEqual(self.browser.ask("GET", "/", Host=f"evil.test:{self.web.port}")[0].status, 403)


class Page(WebTest):
    """Signing in and out in a real Chromium."""

    def setUp(self):
        super().setUp()
        options = webdriver.ChromeOptions()
        for word in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage",
                     "--ignore-certificate-errors", f"--user-data-dir={self.folder}/chromium"):
            options.add_argument(word)
        self.chromium = webdriver.Chrome(options=options)

    def tearDown(self):
        self.chromium.quit()
        super().tearDown()

    def find(self, selector, text=""):
        """The element that is shown, once it has this text."""
        def found(driver):
            return next((element for element in driver.find_elements(By.CSS_SELECTOR, selector)
                         if element.is_displayed() and text in element.text), None)
        return WebDriverWait(self.chromium, 20 * WAIT_FACTOR,
                             ignored_exceptions=[StaleElementReferenceException]).until(found)

    def test_a_link_leads_to_the_page_that_was_asked_for(self):
        self.chromium.get(self.web.origin + "/#/studies")
        self.find("#sign-in button")
        fragment = self.line_for("anna").split("#")[1]
        self.chromium.get(f"{self.web.origin}/sign-in.html?again#{fragment}")
        self.find("#sign-in button", "Sign in").click()
        self.find("#server", "anna")
        self.assertTrue(self.chromium.current_url.endswith("/#/studies"))

        self.find("#sign-out").click()
        self.find("#sign-in button")
        self.assertEqual(self.chromium.get_cookies(), [])
        self.find("#line").send_keys(f"host:7118/sha256:00/{fragment}")
        self.find("#sign-in button").click()
        self.find("#fault", "used before")


class RenewedCertificate(WebTest):
    def served(self):
        with socket.create_connection(("127.0.0.1", self.web.port), 10) as plain, \
                ssl.create_default_context(cafile=self.web.ca).wrap_socket(
                    plain, server_hostname="127.0.0.1") as peer:
            return peer.getpeercert(True)

    def said(self, text):
        line = self.web.process.stderr.readline()
        self.assertIn(text, line)

    def test_it_is_taken_without_a_restart_and_connections_stay(self):
        anna = self.signed_in("anna")
        _, job = self.submit(anna, "steps=1000000 sleep_ms=50")
        connection, response = anna.stream("WatchJob", {"id": job["id"], "from_sequence": 1})
        message(response)

        first = self.served()
        self.ca.issue("web.pem")
        self.said("is in use")
        second = self.served()
        self.assertNotEqual(first, second)

        other = TestCa(tempfile.mkdtemp(dir=self.folder))  # its key is not that of the server
        os.replace(other.issue("web.pem"), self.options[1])
        self.said("the former one stays")
        self.assertEqual(self.served(), second)
        for name, code in (("IP:127.0.0.1", 200), ("DNS:other.test", 403)):
            self.ca.issue("web.pem", name=name)
            self.said("is in use")
            context = ssl.create_default_context(cafile=self.web.ca)
            context.check_hostname = False
            asked = http.client.HTTPSConnection("127.0.0.1", self.web.port, context=context)
            asked.request("GET", "/")
            self.assertEqual(asked.getresponse().status, code, name)
            asked.close()

        message(response)  # the stream goes on
        connection.close()


class BehindProxy(WebTest):
    def setUp(self):
        super().setUp()
        self.web.stop()
        self.web = Web(self.folder, self.daemon, "--behind", "https://dccast.test",
                       path=self.path())

    def path(self):
        """Of the Unix socket; None: a port."""

    def test_the_proxy_states_the_address(self):
        anna = self.signed_in("anna")
        _, job = self.submit(anna, X_Forwarded_For="198.51.100.1, 2001:db8::7")
        self.assertEqual(self.audit("--job", job["id"])[0]["from"], "ipv6:%5B2001:db8::7%5D:0")
        self.assertEqual(anna.call("WhoAmI", Origin="https://127.0.0.1")[0], 401)
        _, job = self.submit(anna)  # a proxy that does not state it
        self.assertEqual(self.audit("--job", job["id"])[0]["from"], "ipv4:127.0.0.1:0")


class BehindProxyAtSocket(BehindProxy):
    """The same at a Unix socket, which file permissions guard."""

    def path(self):
        return os.path.join(self.folder, "web.socket")

    def test_it_is_for_user_and_group_and_goes_with_its_server(self):
        self.assertEqual(stat.S_IMODE(os.stat(self.path()).st_mode), 0o660)
        self.web.process.kill()
        self.web.process.wait(10)
        self.web.process.stderr.close()
        self.web.start()  # in the place of the one that was killed
        self.assertEqual(Browser(self.web).ask("GET", "/")[0].status, 200)
        self.web.stop()
        self.assertFalse(os.path.exists(self.path()))
        self.web.start()


class Options(unittest.TestCase):
    def refusal(self, *words):
        done = subprocess.run([os.path.join(BIN, "dccast-web"), "serve", *words], text=True,
                              capture_output=True, timeout=30, check=False)
        self.assertEqual(done.returncode, 2, done.stderr)
        return done.stderr

    def test_others_are_served_by_https_alone(self):
        self.assertIn("--certificate and --key", self.refusal("--listen", ":0"))
        self.assertIn("127.0.0.1:PORT",
                      self.refusal("--listen", "0.0.0.0:0", "--behind", "https://dccast.test"))
        self.assertIn("https://NAME",
                      self.refusal("--listen", "127.0.0.1:0", "--behind", "http://dccast.test"))
        for port in ("", ":7x", ":65536", ":-1"):
            self.assertIn("0 to 65535",
                          self.refusal("--listen", "127.0.0.1" + port, "--behind", "https://x"))
        self.assertIn("--behind", self.refusal("--listen", "unix:/x", "--certificate", "x", "--key", "x"))
        self.assertIn("no other program listens",
                      self.refusal("--listen", "unix:/nowhere/x", "--behind", "https://x"))
        with tempfile.NamedTemporaryFile() as file:
            self.assertIn("PEM files", self.refusal("--listen", "127.0.0.1:0", "--certificate",
                                                    file.name, "--key", file.name))


if __name__ == "__main__":
    main()
