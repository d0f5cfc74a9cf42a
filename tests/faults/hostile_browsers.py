"""What a hostile browser tries at dccast-web: nothing of it is answered as if it were permitted, others are
answered meanwhile."""
import contextlib
import os
import resource
import socket
import ssl
import time

from browsers import ORIGIN, SERVICE, Browser, WebFault, json_of
from cases import fake
from clients import ANSWER, memory_of
from scene import limit
from waiting import turns

MOST_MEMORY = 150e6
LONG = "steps=100000 sleep_ms=100"


class HostileBrowser(WebFault):
    """A hostile browser tries one thing."""
    short = long = 1
    settings = {**WebFault.settings, "access__read": "own"}

    def begin(self, scene):
        super().begin(scene)
        self.job = scene.submit(fake("steps=3"))
        self.of_anna = self.browser("anna").call("SubmitJob", {
            "request_id": "of-anna", "case": json_of(fake(LONG))})[1]["id"]
        scene.foreign_jobs.add(self.of_anna)

    def disturb(self, scene, count):
        honest = self.browser("anna", "192.0.2.7")
        self.tried = 0
        for said, answers in self.attempts(scene):
            self.tried += 1
            for status in answers:
                if status not in self.refusals:
                    count.found("wrong", f"{said} was answered with {status}")
            begin = time.monotonic()
            honest.close()
            if honest.call("WhoAmI", {})[1].get("name") != "anna":
                count.found("wrong", f"after {said} an honest browser was not answered")
            if time.monotonic() - begin > ANSWER:
                count.found("wrong", f"after {said} an honest browser waited")
        peak = memory_of(self.web.process.pid, "VmHWM")
        if peak > MOST_MEMORY:
            count.found("wrong", f"dccast-web took {peak / 1e6:.0f} MB")
        count.measured("attempts", self.tried)
        count.measured("MB", peak / 1e6)

    def look(self, scene, count):
        self.browser("anna").call("CancelJob", {"id": self.of_anna})

    refusals = ()  # the permitted statuses

    def attempts(self, scene):
        """Pairs of what is tried, and the statuses that came."""
        raise NotImplementedError

    def raw(self, request, seconds=10.0):
        """The status of a request as it stands; 0: the connection was closed without one."""
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as peer:
            peer.settimeout(seconds)
            peer.connect(self.web.place)
            with contextlib.suppress(BrokenPipeError, ConnectionResetError):
                peer.sendall(request)
            with contextlib.suppress(ConnectionResetError):
                return int((peer.recv(4096).split() + [b"0", b"0"])[1])
        return 0


class HostileCookies(HostileBrowser):
    """Hostile browser: forged, stale and copied cookies, and those of another page"""
    refusals = (401, 431)

    def attempts(self, scene):
        session = self.browser()
        session.sign_in(self.line(scene, "anna"))
        name, value = session.headers["Cookie"].split("=", 1)
        yield "a sound session elsewhere", [401 if self.of(name, value) == 200 else 0]
        for place in range(0, len(value), max(1, len(value) // 64)):
            letter = "0" if value[place] != "0" else "1"
            yield "a forged cookie", [self.of(name, value[:place] + letter + value[place + 1:])]
        for other in (value[:-2], value[2:], value + "00", value * 50, "", "zz", "00" * 100):
            yield "a cut cookie", [self.of(name, other)]
        yield "another name", [self.of("dccast", value), self.of("__Secure-dccast", value)]
        copied = (name, value)
        session.ask("POST", "/session/out", "{}")
        yield "a cookie of a session that has ended", [self.of(*copied)]
        unknown = self.browser(Authorization="Bearer dccast-token-" + 32 * "0")
        for method, path in (("POST", SERVICE + "WhoAmI"), ("POST", "/recipe"), ("PUT", "/measured/x.csv")):
            yield "an unknown token", [unknown.ask(method, path, "{}")[0]]

    def of(self, name, value):
        return self.browser(Cookie=f"{name}={value}").ask("POST", SERVICE + "WhoAmI", "{}")[0]


class HostileOrigins(HostileBrowser):
    """Hostile browser: requests with a session from pages of other sites"""
    refusals = (401,)

    def attempts(self, scene):
        session = self.browser()
        session.sign_in(self.line(scene, "anna"))
        for origin in ("https://evil.test", "null", "http://dccast.test", ORIGIN + ".evil.test",
                       ORIGIN + ":444", "https://evil.test/" + ORIGIN, ""):
            yield origin, [session.call("CancelJob", {"id": self.of_anna}, Origin=origin)[0],
                           session.ask("PUT", "/attachments/" + 64 * "0", b"x", Origin=origin)[0]]
            if origin:
                yield origin, [session.ask("GET", path, Origin=origin)[0]
                               for path in ("/jobs.csv", f"/jobs/{self.of_anna}/report", "/server/")]
        for kind in ("text/plain", "application/x-www-form-urlencoded", "multipart/form-data", ""):
            yield kind, [session.call("CancelJob", {"id": self.of_anna}, Content_Type=kind)[0]]


class JobsOfOthers(HostileBrowser):
    """Hostile browser: every call and resource of another user's job"""
    refusals = (400, 403, 404)

    def attempts(self, scene):
        mallory = self.browser("mallory")
        for name in ("GetJob", "CancelJob", "PauseJob", "ResumeJob", "DeleteJob", "QueryResult"):
            yield name, [mallory.call(name, {"id": self.of_anna})[0]]
        yield "UpdateJob", [mallory.call("UpdateJob", {"id": self.of_anna, "priority": "HIGH"})[0]]
        taken = {"case": {"mesh": {"file": "slab.msh"}},
                 "attachments": [{"name": "slab.msh", "sha256": 64 * "a", "job": self.of_anna}]}
        for name, rest in (("ValidateCase", {}), ("SubmitJob", {"request_id": "x"}),
                           ("CreateStudy", {"request_id": "x", "refinement": {"levels": 2}})):
            yield f"a file of the job in {name}", [mallory.call(name, {**taken, **rest})[0]]
        last = list(mallory.stream("QueryButtCurl", taken))[-1][1]
        yield "a file of the job in QueryButtCurl", [404 if last["error"]["code"] == "not_found" else 200]
        anna = self.browser("anna")
        recipe, record = {"job": self.of_anna}, {"outcome": "SOUND", "count": 1}
        castings = {"id": "pit-3", "recipes": [recipe], "castings": [{"recipe": 0, "record": record}]}
        assert anna.call("AddCastings", castings)[0] == 200
        yield "AddCastings with the job", [mallory.call("AddCastings", castings)[0]]
        for name, rest in (("EditCasting", {"casting": "1", "record": record}),
                           ("ForgetCastings", {"castings": ["1"]}), ("RestartLine", {}), ("DeleteLine", {})):
            yield name, [mallory.call(name, {"id": "pit-3", **rest})[0]]
        for name in ("report", "results.h5", "curl.csv", "frame"):
            yield name, [mallory.ask("GET", f"/jobs/{self.of_anna}/{name}")[0]]
        for name in ("job", "frames", "sketch", "report", "frame", "field"):
            if name != "frames":  # which states the reason in its answer
                yield name, [mallory.ask("GET", f"/{name}/{self.of_anna}")[0]]
        last = list(mallory.stream("WatchJob", {"id": self.of_anna}))[-1][1]
        yield "WatchJob", [404 if last["error"]["code"] == "not_found" else 200]
        table = mallory.ask("GET", "/jobs.csv")[1]
        yield "a table", [200 if self.of_anna.encode() in table else 404]


class HostileBodies(HostileBrowser):
    """Hostile browser: bodies that are too long, come byte by byte, or are JSON of depth 10,000"""
    refusals = (0, 400, 413, 415, 431)

    def attempts(self, scene):
        head = (f"{{}} {{}} HTTP/1.1\r\nHost: dccast.test\r\nOrigin: {ORIGIN}\r\n"
                f"Authorization: Bearer {self.tokens['mallory']}\r\nContent-Type: application/json\r\n")

        def begin(method, path, *lines):
            return (head.format(method, path) + "\r\n".join(lines) + "\r\n\r\n").encode()
        call = SERVICE + "ListJobs"
        for size in (3_000_000, 10 ** 12, 10 ** 25):
            for method, path in (("POST", call), ("PUT", "/attachments/" + 64 * "a")):
                if (method, size) != ("PUT", 3_000_000):
                    yield "a length", [self.raw(begin(method, path, f"Content-Length: {size}") + b"x" * 9)]
        chunk = b"10000\r\n" + 65536 * b"x" + b"\r\n"
        yield "chunks", [self.raw(begin("POST", call, "Transfer-Encoding: chunked") + 60 * chunk)]
        yield "chunks of a file", [self.raw(begin("PUT", "/attachments/" + 64 * "a",
                                                  "Transfer-Encoding: chunked") + 60 * chunk)]
        for text in ('{"case":' + 10_000 * '{"mesh":' + 10_000 * "}" + "}", "[" * 2_000_000,
                     '{"a":' * 10_000, '{"since":' + 10_000 * '{"seconds":' + 10_000 * "}" + "}"):
            for method, path in (("POST", call), ("POST", "/recipe"), ("PUT", "/measured/x.csv")):
                yield f"{text[:20]} at {path}", [self.browser("mallory").ask(method, path, text)[0]]
        yield "a long table", [self.browser("mallory").ask("PUT", "/measured/x.csv", "1, 2\n" * 2_000_000)[0]]
        for method, path in (("POST", call), ("PUT", "/attachments/" + 64 * "a")):
            yield "a slow body", [self.slow(begin(method, path, "Content-Length: 100000"))]

    def slow(self, begin):
        """The status that comes in place of more than a byte each tenth of a second."""
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as peer:
            peer.connect(self.web.place)
            peer.sendall(begin)
            with contextlib.suppress(OSError):
                for _ in turns(15, 0.1):
                    peer.sendall(b"x")
                return 200  # it was waited for
            return 0


class HostilePaths(HostileBrowser):
    """Hostile browser: path tricks, and tokens in addresses"""
    refusals = (0, 400, 401, 403, 404, 405)

    def attempts(self, scene):
        names = ("../../etc/passwd", "..%2f..%2fetc%2fpasswd", "%2e%2e/%2e%2e/", "%00", "a%00b", "%", "%zz",
                 "....//", "\\..\\", "*", "?", "//", "a/b/c", "'; DROP TABLE jobs", "\x7f", "é",
                 "x" * 4000)
        own = f"\r\nHost: dccast.test\r\nAuthorization: Bearer {self.tokens['mallory']}\r\n\r\n"
        for name in names:
            for path in (f"/jobs/{name}/report", f"/jobs/{name}/results.h5", f"/job/{name}", f"/{name}",
                         f"/attachments/{name}", f"{SERVICE}{name}"):
                for method in ("GET", "PUT") if path != "/?" else ():
                    yield path, [self.raw(f"{method} {path} HTTP/1.1{own}".encode())]
        for line in ("GET http://evil.test/jobs.csv", "GET jobs.csv", "OPTIONS *", "CONNECT a:443",
                     "TRACE /", "DELETE /jobs.csv", "PATCH /jobs.csv"):
            yield line, [self.raw(f"{line} HTTP/1.1{own}".encode())]
        token = self.tokens["mallory"]
        for query in (f"token={token}", f"x={token}", f"{token}=1", "access_token=1", "secret=1",
                      f"a=b&key=%64{token[1:]}"):
            yield "a token", [self.browser("mallory").ask("GET", f"/jobs.csv?{query}")[0],
                              self.browser("mallory").ask("POST", f"{SERVICE}WhoAmI?{query}", "{}")[0]]
        yield "a token", [self.browser("mallory").ask("GET", f"/jobs/{token}/report")[0]]


class HostileSignIns(HostileBrowser):
    """Hostile browser: lines are guessed, from one address and from many"""
    refusals = (401, 429)

    def attempts(self, scene):
        answers = [self.guess("203.0.113.1", turn) for turn in range(30)]
        yield "guesses from an address", answers
        yield "more than ten in a minute", [429 if answers.count(401) <= 20 else 200]
        answers = [self.guess(f"203.0.113.{number}", 0) for number in range(2, 250)]
        yield "guesses from many", answers
        # A minute may begin between them.
        yield "more than a hundred in a minute", [429 if answers.count(401) <= 200 else 200]
        by_call = [self.browser().call("Enrol", {"secret": f"dccast-enrol-{turn}"})[0]
                   for turn in range(30)]
        yield "guesses by the call", by_call

    def guess(self, address, number):
        return Browser(self.web.place, address).sign_in(f"dccast-enrol-{number:032x}")


class Silence(HostileBrowser):
    """Connections that are silent."""
    connections, begins = 2000, ()

    def begin(self, scene):
        limit(os.getpid(), resource.RLIMIT_NOFILE, 4096)  # dccast-web inherits it, as from its unit
        super().begin(scene)

    def attempts(self, scene):
        with contextlib.ExitStack() as silent:
            for number in range(self.connections):
                peer = silent.enter_context(self.peer(number))
                with contextlib.suppress(OSError):
                    peer.sendall(self.begins[number % len(self.begins)])
                if number % 200 == 199:
                    yield f"{number + 1} silent connections", []

    def peer(self, number):
        raise NotImplementedError


class SilentBrowsers(Silence):
    """Hostile browser: 2,000 connections that are silent before, within or behind a request"""
    begins = (b"", b"G", b"GET / HTTP/1.1\r\nHost: dccast.test\r\n",
              b"POST /session/in HTTP/1.1\r\nHost: dccast.test\r\nContent-Length: 10\r\n\r\nx",
              b"GET /app.js HTTP/1.1\r\nHost: dccast.test\r\n\r\n")

    def peer(self, number):
        peer = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        peer.settimeout(5)
        with contextlib.suppress(OSError):
            peer.connect(self.web.place)
        return peer


class SilentBrowsersAtPort(Silence):
    """Hostile browser: 2,000 connections to the port, silent before, within or behind a TLS handshake"""
    has_port = True
    begins = (b"", b"\x16", b"\x16\x03\x01\x02\x00\x01\x00", b"GET / HTTP/1.1\r\n\r\n")

    def peer(self, number):
        address = f"127.0.1.{number % 100 + 1}"
        peer = socket.create_connection(("127.0.0.1", self.web.place), 5, (address, 0))
        if number % 10 == 0:
            with contextlib.suppress(OSError):
                return ssl._create_unverified_context().wrap_socket(peer)
        return peer
