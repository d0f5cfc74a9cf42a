#!/usr/bin/python3
"""dccast top: the page, once and redrawn, and a terminal that is left as it was."""
import os
import pty
import select
import signal
import subprocess
import termios
import time

from dccast.v1 import job_pb2
from support import ServiceTest, fake_case, main
from waiting import until

ENTER, LEAVE = b"\033[?1049h\033[?25l", b"\033[?25h\033[?1049l"


class TopTest(ServiceTest):
    settings = {"workers__count": 1, "workers__stop_grace": "0.5 s"}

    def setUp(self):
        super().setUp()
        self.running = self.client.submit(fake_case("steps=1000 wait_at=100")).id
        self.client.until_step(self.running, 100)
        self.waiting = [self.client.submit(fake_case("steps=5")).id for _ in range(3)]
        self.owner = self.client.job(self.running).owner

    def test_once(self):
        page = self.dccast("top", "--once")
        for part in ("1 of 1 running, 3 queued, 0 paused", "memory: daemon", self.running[:8],
                     "] 10 %", "steps=1000", "OWNER", "#1"):
            self.assertIn(part, page)
        self.assertNotIn("\033", page)
        self.client.cancel(self.running)
        for job in (self.running, *self.waiting):
            self.client.until_state(job, job_pb2.SUCCEEDED, job_pb2.CANCELLED)
        page = self.dccast("top", "--once")
        self.assertIn("no job runs", page)

    def on_a_terminal(self, leave):
        """Runs top on a terminal of 60 columns and 12 lines. Returns what it wrote there."""
        terminal, child_end = pty.openpty()
        termios.tcsetwinsize(child_end, (12, 60))
        before = termios.tcgetattr(child_end)
        environment = {**os.environ, "TERM": "xterm"}
        environment.pop("COLUMNS", None)
        top = subprocess.Popen(self.client_command("top", "--interval", "1"), stdin=child_end,
                               stdout=child_end, stderr=child_end, env=environment)
        self.addCleanup(os.close, terminal)
        self.addCleanup(os.close, child_end)
        written = b""

        def read_for(seconds):
            nonlocal written
            end = time.monotonic() + seconds
            while time.monotonic() < end:
                if select.select([terminal], [], [], 0.1)[0]:
                    written += os.read(terminal, 65536)

        def pages():
            read_for(0.1)
            return written.count(b"\033[H")
        until(lambda: pages() >= 2, 30)
        leave(top, terminal)
        until(lambda: pages() >= 0 and top.poll() is not None, 20)
        read_for(0.3)
        self.assertEqual(termios.tcgetattr(child_end), before)
        self.assertTrue(written.startswith(ENTER), written[:80])
        self.assertTrue(written.endswith(LEAVE), written[-80:])
        self.assertEqual(top.returncode, 0)
        for page in written.split(b"\033[H")[1:]:
            lines = page.split(b"\033[J")[0].decode().split("\033[K\r\n")
            self.assertLessEqual(len(lines) - 1, 11)
            self.assertLessEqual(max(map(len, lines)), 60)

    def test_q_leaves(self):
        self.on_a_terminal(lambda top, terminal: os.write(terminal, b"q"))

    def test_an_interrupt_leaves(self):
        self.on_a_terminal(lambda top, terminal: top.send_signal(signal.SIGINT))


if __name__ == "__main__":
    main()
