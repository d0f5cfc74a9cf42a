#!/usr/bin/python3
"""A day in two network namespaces: a server with dccastd and dccast-web, and a PC that has Chromium alone.

The namespaces stand for two machines with one cable. What the user does, and how long it took, is printed.
"""
import contextlib
import ctypes
import getpass
import os
import pathlib
import re
import shutil
import subprocess
import time
import unittest

from selenium.webdriver.common.keys import Keys

from access_test import AccessTest
from certificates import TestCa
from support import BIN, Daemon, main
from web_pages_test import Hands
from waiting import until

SERVER, PC = "192.0.2.1", "192.0.2.2"  # of the documentation: in no other network
CLONE_NEWNET = 0x40000000


def run(*words):
    subprocess.run(words, check=True, capture_output=True, timeout=30)


@contextlib.contextmanager
def two_machines():
    """Names of two namespaces that reach each other and nothing else."""
    server, pc = (f"dccast-{name}-{os.getpid()}" for name in ("server", "pc"))
    try:
        for name in (server, pc):
            run("ip", "netns", "add", name)
            run("ip", "-n", name, "link", "set", "lo", "up")
        run("ip", "-n", server, "link", "add", "cable", "type", "veth", "peer", "name", "cable", "netns", pc)
        for name, address in ((server, SERVER), (pc, PC)):
            run("ip", "-n", name, "address", "add", address + "/24", "dev", "cable")
            run("ip", "-n", name, "link", "set", "cable", "up")
        yield server, pc
    finally:
        for name in (server, pc):
            subprocess.run(["ip", "netns", "del", name], check=False, capture_output=True, timeout=30)


def enter(namespace_file):
    """This thread, and what it starts, is in another namespace from now on."""
    with open(namespace_file, "rb") as file:
        libc = ctypes.CDLL(None, use_errno=True)
        if libc.setns(file.fileno(), CLONE_NEWNET) != 0:
            raise OSError(ctypes.get_errno(), "setns")


def are_namespaces_permitted():
    if os.geteuid() != 0 or not shutil.which("ip"):
        return False
    with contextlib.suppress(subprocess.CalledProcessError):
        with two_machines():
            return True
    return False


class OnServer(Daemon):
    """dccastd in the namespace of the server."""
    namespace = ""

    def command(self):
        return ["ip", "netns", "exec", self.namespace, *super().command()]


@unittest.skipUnless(are_namespaces_permitted(), "network namespaces need root, ip and their permission")
class Day(Hands, AccessTest):
    def setUp(self):
        super().setUp()
        server, pc = self.enterContext(two_machines())
        self.daemon = OnServer(self.folder, "dccast-worker", access__web_user=getpass.getuser(),
                               access__web_address=f"https://{SERVER}")
        self.daemon.namespace = server
        self.daemon.start()
        self.start_web(server)

        # From here on this process is the hands at the PC: it calls no program of the server's.
        self.link = re.search(r"\S+/sign-in.html#\S+",
                              self.admin("user", "add", "anna", "--role", "submitter"))[0]
        self.addCleanup(enter, self.own_namespace())
        enter(f"/run/netns/{pc}")
        self.chromium = self.chromium_in(self.folder)
        self.addCleanup(self.chromium.quit)

    def own_namespace(self):
        """A handle of the namespace in which the test was started."""
        handle = os.open("/proc/self/ns/net", os.O_RDONLY)
        self.addCleanup(os.close, handle)
        return f"/proc/self/fd/{handle}"

    def start_web(self, server):
        ca = TestCa(self.folder)
        certificate = ca.issue("web.pem", name=f"IP:{SERVER}")
        self.web = subprocess.Popen(
            ["ip", "netns", "exec", server, os.path.join(BIN, "dccast-web"), "serve", "--listen", f"{SERVER}:443",
             "--certificate", certificate, "--key", ca.key, "--socket", self.daemon.address, "--state",
             self.in_folder("web")], stderr=subprocess.PIPE, text=True)
        self.addCleanup(self.web.stderr.close)
        self.addCleanup(self.web.wait, 10)
        self.addCleanup(self.web.terminate)
        self.assertIn("port 443", self.web.stderr.readline())

    def step(self, name):
        """Notes that a step of the day is done, and how long it took."""
        now = time.monotonic()
        self.steps.append(f"{name}: {now - self.begin:.1f} s")
        self.begin = now

    def test_from_the_link_to_the_results(self):
        self.steps, self.begin = [], time.monotonic()
        self.chromium.get(self.link)
        self.find("#sign-in button", "Sign in").click()
        self.find("#server", "anna")
        self.step("signed in")

        self.find("nav a", "What-if").click()
        self.find("main", "As it is: corner", 90)
        self.step("what-if, the case as it is")
        slider = self.find("#schedule-water_flow-scale")
        for _ in range(20):
            slider.send_keys(Keys.ARROW_LEFT)
        self.find("main", "Changed: corner", 90)
        self.step("what-if, with a fifth less water")

        self.find("main .bar button", "Keep as a job").click()
        self.find("main p[role=status] a").click()
        self.step("submitted")
        # The state itself may be over before the page is looked at.
        self.find("main figure path.line", seconds=60)
        self.step("watched")
        self.find("main .state", "succeeded", 120)
        self.find("main p.answer", "since the block started")
        self.step("ended, with its answer")

        folder = self.in_folder("downloads")
        os.makedirs(folder)
        self.chromium.execute_cdp_cmd("Browser.setDownloadBehavior",
                                      {"behavior": "allow", "downloadPath": folder})
        self.find("main button", "Data (CSV)", 60).click()
        fetched = lambda: [path for path in pathlib.Path(folder).glob("*.csv") if path.stat().st_size]
        until(fetched, 30)
        self.assertIn("temperature", fetched()[0].read_text("utf-8").splitlines()[0])
        self.step("fetched the data of the slab")
        self.find("main a.button", "Report").click()
        self.chromium.switch_to.window(self.chromium.window_handles[-1])
        self.find("h1")
        self.step("read the report")
        print("\n" + "\n".join(self.steps))


if __name__ == "__main__":
    main()
