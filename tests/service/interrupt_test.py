#!/usr/bin/python3
"""Ctrl-C and SIGTERM end a command of the client at once; jobs go on, and there is a way back."""
import fcntl
import json
import os
import pty
import re
import signal
import socket
import struct
import subprocess
import termios
import threading
import unittest

from dccast.v1 import job_pb2
from support import BIN, SANITIZED, ServiceTest, connected, fake_case, main
from waiting import WAIT_FACTOR, until

CASE = os.path.join(os.path.dirname(__file__), "..", "..", "cases", "start-2d-thickness.toml")
LONG = "steps=100000 sleep_ms=5"


def waiting_bytes(pipe):
    return struct.unpack("i", fcntl.ioctl(pipe, termios.FIONREAD, bytes(4)))[0]


def has_socket(process):
    folder = f"/proc/{process}/fd"
    try:
        return any(os.readlink(os.path.join(folder, name)).startswith("socket:")
                   for name in os.listdir(folder))
    except OSError:
        return False  # a descriptor was closed meanwhile


class StallingProxy:
    """Between client and daemon; holds back what the daemon sends beyond so many bytes."""

    def __init__(self, address, most, path):
        self.daemon = connected(address, timeout=None)
        self.listener = socket.socket(socket.AF_UNIX)
        self.listener.bind(path)
        self.listener.listen()
        self.address = f"unix:{path}"
        self.most = most
        self.stalled = threading.Event()  # the client gets no more
        self.ends = [self.daemon, self.listener]
        threading.Thread(target=self.take_one, daemon=True).start()

    def take_one(self):
        client, _ = self.listener.accept()
        self.ends.append(client)
        threading.Thread(target=self.pump, args=(client, self.daemon, 1 << 40),
                         daemon=True).start()
        self.pump(self.daemon, client, self.most)
        self.stalled.set()

    @staticmethod
    def pump(source, target, most):
        try:
            while most > 0:
                block = source.recv(min(65536, most))
                if not block:
                    break
                target.sendall(block)
                most -= len(block)
        except OSError:
            pass  # the other side has gone

    def close(self):
        for end in self.ends:
            end.close()


class Interrupt(ServiceTest):
    def command(self, *words, address=None):
        return [os.path.join(BIN, "dccast"), "--server", address or self.daemon.address, *words]

    def begin(self, *words, address=None, stdout=subprocess.PIPE, stderr=subprocess.PIPE):
        """A pipe that is not read must not fill: a command that waits in its write does nothing
        else. A test that does not read one of the two gives it a file."""
        process = subprocess.Popen(self.command(*words, address=address), text=True,
                                   stdout=stdout, stderr=stderr, cwd=self.folder)
        # A command that hangs fails its test, instead of holding it until the limit of the script.
        limit = threading.Timer(60 * WAIT_FACTOR, process.kill)
        limit.daemon = True
        limit.start()
        self.addCleanup(self.end, process, limit)
        return process

    @staticmethod
    def end(process, limit):
        limit.cancel()
        if process.poll() is None:
            process.kill()
            process.wait()
        for pipe in (process.stdout, process.stderr):
            if pipe:
                pipe.close()

    def interrupted(self, process, number=signal.SIGINT):
        """Sends the signal. Returns what the command said: its own last words, not the generic
        ones of a command that did not leave by itself."""
        process.send_signal(number)
        out, err = (pipe.read() if pipe else "" for pipe in (process.stdout, process.stderr))
        self.assertEqual(process.wait(timeout=10), 130, err)
        self.assertIn("dccast: interrupted", err)
        self.assertNotIn("a job that was submitted goes on", err)
        return out, err

    def long_job(self):
        job = self.client.submit(fake_case(LONG))
        self.client.until_step(job.id, 3)
        return job

    def case_file(self, title):
        path = self.in_folder("case.toml")
        with open(CASE, encoding="utf-8") as shipped, open(path, "w", encoding="utf-8") as file:
            file.write(re.sub(r'^title = .*$', f'title = "{title}"', shipped.read(), flags=re.M))
        return path

    def assert_goes_on(self, job_id):
        reached = self.client.job(job_id).last_step.step
        self.client.until_step(job_id, reached + 2)
        self.assertEqual(self.client.job(job_id).state, job_pb2.RUNNING)

    def assert_way_back(self, job_id, err, seen):
        """The command it names shows the event after the last one seen."""
        back = re.search(r"Come back: dccast (watch --from (\d+) (\S+))\n", err)
        self.assertIsNotNone(back, err)
        self.assertEqual((int(back[2]), back[3]), (seen + 1, job_id))
        again = self.begin(*back[1].split(), "--json")
        self.assertEqual(json.loads(again.stdout.readline())["sequence"], seen + 1)
        self.interrupted(again)

    def test_watch_for_scripts_ends_with_a_whole_line_and_the_way_back(self):
        job = self.long_job()
        for number in (signal.SIGINT, signal.SIGTERM):
            with self.subTest(signal=number):
                process = self.begin("watch", "--json", job.id)
                out = "".join(process.stdout.readline() for _ in range(5))
                rest, err = self.interrupted(process, number)
                out += rest
                self.assertTrue(out.endswith("}\n"))
                self.assert_way_back(job.id, err, json.loads(out.splitlines()[-1])["sequence"])
                self.assert_goes_on(job.id)

    def test_submit_and_watch(self):
        process = self.begin("submit", "--watch", self.case_file(LONG))
        job_id = process.stdout.readline().strip()
        self.client.until_step(job_id, 3)
        out, err = self.interrupted(process)
        self.assertEqual(out, "")
        self.assertIn(f"job {job_id} goes on. Come back: dccast watch --from ", err)
        self.assert_goes_on(job_id)

    def test_ctrl_c_on_a_terminal_leaves_it_clean(self):
        job = self.long_job()
        terminal, theirs = pty.openpty()
        self.addCleanup(os.close, terminal)
        # setsid gives it the terminal as its own, so that the key becomes a signal.
        process = subprocess.Popen(["setsid", "--ctty", *self.command("watch", job.id)],
                                   stdin=theirs, stdout=theirs, stderr=theirs,
                                   env={**os.environ, "TERM": "xterm"})
        os.close(theirs)
        shown = b""
        while shown.count(b"eta ") < 2:
            shown += os.read(terminal, 65536)
        os.write(terminal, b"\x03")
        try:
            while piece := os.read(terminal, 65536):
                shown += piece
        except OSError:
            pass  # its last holder has gone
        self.assertEqual(process.wait(timeout=10), 130)

        text = shown.decode()
        lines = text.split("\r\n")
        self.assertEqual(lines[-1], "")  # the prompt of the shell begins a line
        self.assertRegex(lines[-2], rf"^dccast: interrupted; job {job.id} goes on\. Come back: ")
        self.assertNotIn("\x1b[?25l", text)  # the cursor was never hidden
        self.assertFalse(set(re.findall(r"\x1b[^A-Za-z]*[A-Za-z]", text)) - {"\x1b[K"}, text)
        self.assert_goes_on(job.id)

    def test_fetch_leaves_a_part_that_the_same_command_continues(self):
        job = self.client.submit(fake_case("steps=3 big=4000000"))
        self.client.until_state(job.id, job_pb2.SUCCEEDED)
        proxy = StallingProxy(self.daemon.address, 1500000, self.in_folder("proxy"))
        self.addCleanup(proxy.close)
        part = self.in_folder("r.h5.part")
        process = self.begin("fetch", job.id, "-o", "r.h5", address=proxy.address)
        self.assertTrue(proxy.stalled.wait(20 * WAIT_FACTOR))
        until(lambda: os.path.exists(part) and os.path.getsize(part) > 0, 10)
        _, err = self.interrupted(process)
        bytes_there = os.path.getsize(part)
        self.assertGreater(bytes_there, 0)
        self.assertLess(bytes_there, 1500000)
        self.assertIn(f"r.h5.part keeps {bytes_there} bytes", err)
        self.assertFalse(os.path.exists(self.in_folder("r.h5")))

        # The fake casting has no sidecar: only the file itself is fetched again.
        again = self.begin("fetch", "--json", job.id, "-o", "r.h5")
        _, err = again.communicate(timeout=20)
        self.assertIn(f"going on after the {bytes_there} bytes in r.h5.part", err)
        with open(self.in_folder("r.h5"), "rb") as file:
            self.assertEqual(file.read(), b"".join(c.data for c in self.client.fetch(job.id)))

    def test_convergence_names_the_study_to_come_back_to(self):
        process = self.begin("convergence", self.case_file(LONG))
        jobs = []
        while len(jobs) < 3:
            line = process.stderr.readline()
            self.assertTrue(line, "the command has ended")
            jobs += re.findall(r"^refinement \d+: job (\S+)", line)
        self.client.until_step(jobs[0], 3)
        _, err = self.interrupted(process)
        self.assertIn("the jobs go on. Come back: dccast convergence --study "
                      + self.client.job(jobs[0]).study, err)
        self.assert_goes_on(jobs[0])

    def test_a_daemon_that_does_not_answer_holds_nobody(self):
        job = self.long_job()
        self.daemon.process.send_signal(signal.SIGSTOP)
        self.addCleanup(self.daemon.process.send_signal, signal.SIGCONT)
        for words in (["show", job.id], ["submit", self.case_file(LONG)], ["fetch", job.id]):
            with self.subTest(words=words):
                process = self.begin(*words)
                until(lambda: has_socket(process.pid), 10)  # it is in its first call
                self.assertIsNone(process.poll())
                self.interrupted(process)
        self.assertEqual(os.listdir(self.folder).count("results.h5.part"), 0)

    def test_between_two_attempts(self):
        job = self.long_job()
        events = self.in_folder("events.json")
        with open(events, "w", encoding="utf-8") as file:
            process = self.begin("watch", "--json", job.id, stdout=file)
        until(lambda: os.path.getsize(events) > 0, 10)
        self.daemon.kill()
        for line in process.stderr:
            if "attempt 3" in line:
                break
        _, err = self.interrupted(process)
        self.assertIn(f"job {job.id} goes on. Come back", err)

    @unittest.skipIf(SANITIZED, "ThreadSanitizer's _exit flushes standard output first")
    def test_pipes_that_no_one_reads_hold_nobody(self):
        job = self.client.submit(fake_case("steps=100000 sleep_ms=1"))
        reader, writer = os.pipe()
        self.addCleanup(os.close, reader)
        fcntl.fcntl(writer, fcntl.F_SETPIPE_SZ, 4096)
        process = self.begin("watch", job.id, stdout=writer, stderr=writer)
        os.close(writer)
        # Less room than a line of progress needs.
        until(lambda: waiting_bytes(reader) > 4000, 20)
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(timeout=10 * WAIT_FACTOR), 130)


if __name__ == "__main__":
    main()
