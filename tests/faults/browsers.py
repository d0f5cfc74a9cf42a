"""dccast-web with browsers at it: many, hostile ones, and some amid kills. It runs as another user of this
machine, behind a proxy that these faults play."""
import contextlib
import hashlib
import http.client
import json
import os
import re
import shutil
import signal
import ssl
import statistics
import struct
import subprocess
import sys
import threading
import time

from google.protobuf import json_format

from access import RemoteFault, admin
from cases import fake
from certificates import TestCa
from clients import memory_of
from hostile import environment
from oracle import must
from support import BIN, SocketConnection
from waiting import pause, turns, until

SERVICE = "/dccast.v1.SimulationService/"
ORIGIN = "https://dccast.test"
NOBODY = 65534
# Of a server or daemon that was killed: the request is sent again.
PASSING = ("unavailable", "aborted", "canceled", "deadline_exceeded")


def json_of(case):
    return json_format.MessageToDict(case, preserving_proto_field_name=True)


def connection_to(place, timeout):
    """@param place  path of a Unix socket, or the port of 127.0.0.1 for HTTPS"""
    if isinstance(place, str):
        return SocketConnection(place, timeout)
    return http.client.HTTPSConnection("127.0.0.1", place, timeout=timeout,
                                       context=ssl._create_unverified_context())


class Browser:
    """What a page or a program sends, over one connection as long as it lasts."""

    def __init__(self, place, address="192.0.2.1", timeout=30, **headers):
        self.place, self.timeout = place, timeout
        self.headers = {"Origin": ORIGIN, "X-Forwarded-For": address,
                        "Content-Type": "application/json", **headers}
        self.connection = None

    def response(self, method, path, body=None, **headers):
        headers = {name.replace("_", "-"): value for name, value in headers.items()}
        if self.connection is None:
            self.connection = connection_to(self.place, self.timeout)
        self.connection.request(method, path, body, {**self.headers, **headers})
        return self.connection.getresponse()

    def ask(self, method, path, body=None, **headers):
        """@return status and body"""
        try:
            response = self.response(method, path, body, **headers)
            return response.status, response.read()
        except (OSError, http.client.HTTPException):
            self.close()
            raise

    def call(self, name, request, **headers):
        status, text = self.ask("POST", SERVICE + name, json.dumps(request), **headers)
        return status, json.loads(text)

    def stream(self, name, request):
        """Each message of a stream, until it ends: {} or {"error": ...} at last."""
        body = json.dumps(request).encode()
        response = self.response("POST", SERVICE + name, struct.pack(">BI", 0, len(body)) + body,
                                 Content_Type="application/connect+json")
        while prefix := response.read(5):
            flags, size = struct.unpack(">BI", prefix)
            yield flags, json.loads(response.read(size))

    def sign_in(self, secret):
        response = self.response("POST", "/session/in", json.dumps({"secret": secret}))
        response.read()
        if response.status == 200:
            self.headers["Cookie"] = response.getheader("Set-Cookie").split(";")[0]
        return response.status

    def close(self):
        if self.connection:
            self.connection.close()
        self.connection = None


class WebServer:
    """dccast-web of a scene: at a Unix socket behind a proxy, or with a certificate at a port."""

    def __init__(self, scene, has_port=False):
        self.folder = os.path.join(scene.folder, "web")
        self.place = os.path.join(self.folder, "socket")
        program = os.path.join(self.folder, "dccast-web")
        if not os.path.exists(program):  # where its user can reach it
            os.mkdir(self.folder)
            shutil.copy(os.path.join(BIN, "dccast-web"), program)
            os.chown(self.folder, NOBODY, NOBODY)
        listening = ["--listen", f"unix:{self.place}", "--behind", ORIGIN]
        if has_port:
            ca = TestCa(self.folder)
            listening = ["--listen", "127.0.0.1:0", "--certificate", ca.issue("web.pem"), "--key", ca.key]
            os.chown(ca.key, NOBODY, NOBODY)
        self.command = ["setpriv", "--pdeathsig", "KILL", f"--reuid={NOBODY}", f"--regid={NOBODY}",
                        "--clear-groups", program, "serve", *listening, "--socket",
                        scene.daemon.address, "--state", self.folder]
        self.start()

    def start(self):
        self.process = subprocess.Popen(self.command, stderr=subprocess.PIPE, text=True)
        line = self.process.stderr.readline()
        if "serving at" not in line:
            raise RuntimeError(line)
        if port := re.search(r"port (\d+)$", line):
            self.place = int(port[1])

    def close(self):
        self.process.kill()
        self.process.wait(10)
        self.process.stderr.close()


class WebFault(RemoteFault):
    """A daemon with dccast-web before it, and two users who have tokens."""
    settings = {"access__web_user": "nobody"}
    has_port = False

    def prepare(self, scene):
        os.chmod(scene.folder, 0o711)  # of the sockets, for dccast-web

    def begin(self, scene):
        self.web = WebServer(scene, self.has_port)
        scene.clients.append(self.web)
        self.tokens = {name: self.enrol(scene, name) for name in ("anna", "mallory")}

    def browser(self, name=None, address="192.0.2.1", **headers):
        """Of a user by token; of nobody without a name."""
        if name:
            headers["Authorization"] = "Bearer " + self.tokens[name]
        return Browser(self.web.place, address, **headers)

    def line(self, scene, name):
        return re.search(r"dccast-enrol-\w+-\w+", admin(scene, "user", "line", name))[0]


# ---- Kills

class Watcher(threading.Thread):
    """Follows a job to its end, as a page does: a stream that breaks is taken up again."""

    def __init__(self, browser, job_id):
        super().__init__(daemon=True)
        self.browser, self.job_id = browser, job_id
        self.numbers, self.fault, self.has_ended = [], None, False
        self.start()

    def run(self):
        while not self.has_ended and not self.fault:
            try:
                for flags, answer in self.browser.stream("WatchJob", {
                        "id": self.job_id, "from_sequence": len(self.numbers) + 1}):
                    self.take(flags, answer)
            except (OSError, http.client.HTTPException, struct.error, ValueError):
                pass
            self.browser.close()
            time.sleep(0.05)  # the pace at which a page connects again

    def take(self, flags, answer):
        if flags != 2:
            self.numbers.append(int(answer["sequence"]))
        elif not answer:
            self.has_ended = True
        elif answer["error"]["code"] not in PASSING:
            self.fault = answer["error"]


class KillAmidBrowsers(WebFault):
    """Kills something amid uploads, streams and submissions of browsers."""
    short, long = 2, 40
    at_once = 2
    clients, jobs, longest = 3, 4, 60.0

    def begin(self, scene):
        super().begin(scene)
        self.contents = {}  # of the file of a request

    def disturb(self, scene, count):
        watchers = [Watcher(self.browser("anna"), self.send(scene, count, self.browser("anna"),
                                                            "steps=200 sleep_ms=10"))
                    for _ in range(2)]
        senders = [threading.Thread(target=self.send_some, args=(scene, count), daemon=True)
                   for _ in range(self.clients)]
        for sender in senders:
            sender.start()
        pause(scene.chance, 0.5)
        self.kill(scene)
        for thread in senders + watchers:
            thread.join(self.longest)
        for watcher in watchers:
            if watcher.fault or not watcher.has_ended:
                count.found("wrong", f"a stream did not go on: {watcher.fault}")
            if watcher.numbers != list(range(1, len(watcher.numbers) + 1)):
                count.found("duplicated", "a stream had an event twice, or not at all")

    def kill(self, scene):
        raise NotImplementedError

    def send_some(self, scene, count):
        browser = self.browser("anna")
        for _ in range(self.jobs):
            self.send(scene, count, browser, "steps=3")

    def send(self, scene, count, browser, title):
        """Uploads a file and submits a job with it, until it is acknowledged. @return its id"""
        expected = scene.next_request(fake(title), None)
        content = self.contents[expected.request_id] = os.urandom(300_000)
        sha256 = hashlib.sha256(content).hexdigest()
        request = {"request_id": expected.request_id, "case": json_of(expected.case),
                   "attachments": [{"name": "slab.msh", "sha256": sha256, "size_bytes": len(content)}]}
        request["case"].setdefault("mesh", {})["file"] = "slab.msh"

        for _ in turns(self.longest, 0.05):
            with contextlib.suppress(OSError, http.client.HTTPException):
                status, text = browser.ask("PUT", f"/attachments/{sha256}?name=slab.msh", content)
                if status == 200:
                    status, text = browser.ask("POST", SERVICE + "SubmitJob", json.dumps(request))
                answer = json.loads(text)
                if status == 200:
                    scene.acknowledged[answer["id"]] = expected
                    return answer["id"]
                if answer["code"] not in PASSING:
                    count.found("wrong", f"a request was refused: {answer}")
                    return None
        count.found("wrong", "a request was not answered")
        return None

    def look_back(self, scene, count):
        for job_id, expected in scene.acknowledged.items():
            with open(scene.data("jobs", job_id, "attachments", "slab.msh"), "rb") as file:
                if file.read() != self.contents[expected.request_id]:
                    count.found("lost", f"job {job_id}: its file")


class KillWeb(KillAmidBrowsers):
    """kill -9 of dccast-web amid uploads, streams and submissions of browsers, which send them again"""

    def kill(self, scene):
        self.web.close()
        pause(scene.chance, 0.3)
        self.web.start()


class KillDaemonBehindWeb(KillAmidBrowsers):
    """kill -9 of the daemon behind dccast-web amid uploads, streams and submissions of browsers"""

    def kill(self, scene):
        scene.tell_daemon(signal.SIGKILL)
        pause(scene.chance, 0.3)
        scene.come_back()


# ---- Load

def timed(seconds, acts):
    """How long each of the acts takes, done in turn, each as often first [s]."""
    times, names = {name: [] for name in acts}, list(acts)
    for _ in turns(seconds, 0.02):
        for name in names:
            begin = time.monotonic()
            acts[name]()
            times[name].append(time.monotonic() - begin)
        names.reverse()
    return times


class CrowdFault(WebFault):
    """A running job that many browsers follow."""
    short = long = 1
    users = 20
    most_delay = 0.015  # [s]

    def begin(self, scene):
        super().begin(scene)
        self.job = scene.submit(fake("steps=100000 sleep_ms=500"))
        self.crowd_tokens = [self.enrol(scene, f"user{number}") for number in range(self.users)]

    def crowd(self, streams, senders):
        """A process of browsers, once all streams are open. A line ends it."""
        # Browsers compute on other machines: here they give way.
        load = subprocess.Popen(
            ["setpriv", "--pdeathsig", "KILL", "nice", "-n", "15", sys.executable, __file__,
             self.web.place, self.job, str(streams), str(senders), *self.crowd_tokens],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment())
        load.stdout.readline()
        return load

    def look(self, scene, count):
        scene.client.cancel(self.job)
        scene.acknowledged.pop(self.job)
        scene.foreign_jobs.add(self.job)
        must(count, lambda: scene.ended(self.job), "the job did not end", 30)


class CommandsBesideBrowsers(CrowdFault):
    """Commands while 50 browsers watch are answered as without dccast-web, in pairs"""
    pairs, commands, streams = 7, 20, 50

    def disturb(self, scene, count):
        command = [os.path.join(BIN, "dccast"), "--server", scene.daemon.address, "show", self.job]

        def median():
            taken = []
            for _ in range(self.commands):
                begin = time.monotonic()
                subprocess.run(command, check=True, stdout=subprocess.DEVNULL, timeout=30)
                taken.append(time.monotonic() - begin)
            return statistics.median(taken)

        beside, without = [], []
        for _ in range(self.pairs):
            load = self.crowd(self.streams, 0)
            beside.append(median())
            load.communicate("end\n", timeout=60)
            self.web.close()
            without.append(median())
            self.web.start()
        delay = statistics.median(b - w for b, w in zip(beside, without))
        count.measured("ms beside browsers (median)", 1e3 * statistics.median(beside))
        count.measured("ms without dccast-web (median)", 1e3 * statistics.median(without))
        if delay > self.most_delay:
            count.found("wrong", f"{1e3 * delay:.1f} ms slower: {beside}, {without}")


class ManyBrowsers(CrowdFault):
    """200 browsers with a stream each, 20 that submit: dccast-web answers as the daemon does"""
    streams, senders, lasts = 200, 20, 30.0
    most_memory = 200e6  # [bytes]

    def disturb(self, scene, count):
        load = self.crowd(self.streams, self.senders)
        browser = self.browser("anna")
        times = timed(self.lasts, {"web": lambda: browser.call("GetJob", {"id": self.job}),
                                   "daemon": lambda: scene.client.job(self.job)})
        said = json.loads(load.communicate("end\n", timeout=60)[0])
        for request_id, job_id in said["submitted"].items():
            expected = scene.next_request(fake("steps=3"), None)
            expected.request_id = request_id
            scene.acknowledged[job_id] = expected

        p99 = {name: sorted(taken)[int(0.99 * len(taken))] for name, taken in times.items()}
        peak = memory_of(self.web.process.pid, "VmHWM")
        count.measured("ms of the daemon (p99)", 1e3 * p99["daemon"])
        count.measured("ms of dccast-web (p99)", 1e3 * p99["web"])
        count.measured("MB", peak / 1e6)
        count.measured("requests submitted", len(said["submitted"]))
        if said["faults"] or said["open"] != self.streams:
            count.found("wrong", f"{said['open']} streams are left; {said['faults'][:3]}")
        if p99["web"] > p99["daemon"] + self.most_delay:
            count.found("wrong", f"p99 {p99}")
        if peak > self.most_memory:
            count.found("wrong", f"{peak / 1e6:.0f} MB")


def crowd(path, job, streams, senders, tokens):
    """Many browsers in a process of their own, until it is told to end by a line."""
    faults, submitted, opened, ending = [], {}, [], threading.Event()

    def browser(number):
        return Browser(path, f"198.51.100.{number % 250}",
                       Authorization="Bearer " + tokens[number % len(tokens)])

    def watch(number):
        messages = browser(number).stream("WatchJob", {"id": job, "from_sequence": 1})
        flags, answer = next(messages)
        if flags == 2:
            faults.append(answer)
        opened.append(messages)
        while not ending.is_set() and flags != 2:
            flags, answer = next(messages)
        if flags == 2:
            opened.remove(messages)

    def send(number):
        own, turn = browser(number), 0
        while not ending.wait(0.5):
            request_id, turn = f"crowd-{number}-{turn}", turn + 1
            status, answer = own.call("SubmitJob", {"request_id": request_id,
                                                    "case": json_of(fake("steps=3"))})
            if status == 200:
                submitted[request_id] = answer["id"]
            else:
                faults.append(answer)

    threads = [threading.Thread(target=watch, args=(number,), daemon=True) for number in range(streams)]
    for thread in threads:
        thread.start()
    until(lambda: len(opened) + len(faults) >= streams, 120)
    senders = [threading.Thread(target=send, args=(number,)) for number in range(senders)]
    for thread in senders:
        thread.start()
    print("open", flush=True)
    sys.stdin.readline()
    still_open = len(opened)
    ending.set()
    for thread in senders:
        thread.join()
    print(json.dumps({"open": still_open, "submitted": submitted, "faults": faults}), flush=True)


if __name__ == "__main__":
    crowd(sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4]), sys.argv[5:])
