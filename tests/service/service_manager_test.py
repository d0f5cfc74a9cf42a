#!/usr/bin/python3
"""What dccastd reports to a service manager like systemd, which is a socket here."""
import os
import signal
import socket

from adoption import SUCCEEDED, AdoptionTest
from support import BIN, main
from waiting import until


class Manager:
    """Receives what a service reports, sd_notify(3)."""

    def __init__(self, address):
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.socket.bind(address.replace("@", "\0", 1))
        self.socket.settimeout(20)

    def next(self):
        """The next message, by its variables."""
        text = self.socket.recv(4096).decode()
        return dict(line.split("=", 1) for line in text.split("\n"))

    def until(self, variable):
        """The next message with this variable, for example READY."""
        while variable not in (message := self.next()):
            pass
        return message

    def waiting(self):
        """What was sent and is not read yet."""
        messages = []
        self.socket.settimeout(0)
        try:
            while True:
                messages.append(self.next())
        except BlockingIOError:
            return messages
        finally:
            self.socket.settimeout(20)


class ServiceManagerTest(AdoptionTest):
    address = "@dccast-test-%d" % os.getpid()
    environment = {"WATCHDOG_USEC": "400000"}

    def setUp(self):
        self.manager = Manager(self.address)
        self.addCleanup(self.manager.socket.close)
        os.environ.update(self.environment, NOTIFY_SOCKET=self.address)
        try:
            super().setUp()
        finally:
            for name in ("NOTIFY_SOCKET", *self.environment):
                del os.environ[name]


class Reports(ServiceManagerTest):
    def test_ready_signs_of_life_with_the_queue_and_the_end(self):
        self.assertEqual(self.manager.next(), {"READY": "1", "STATUS": "0 queued, 0 running"})
        self.assertEqual(self.manager.next(), {"WATCHDOG": "1", "STATUS": "0 queued, 0 running"})
        self.running_job()
        until(lambda: self.manager.next()["STATUS"] == "0 queued, 1 running", 20)
        self.daemon.process.send_signal(signal.SIGTERM)
        self.assertIn("stop at a checkpoint", self.manager.until("STOPPING")["STATUS"])
        self.assertEqual(self.daemon.wait(), 0)
        self.assertEqual(self.manager.waiting(), [])

    def test_workers_do_not_answer_for_the_daemon(self):
        _, worker = self.running_job()
        with open(f"/proc/{worker}/environ", "rb") as file:
            variables = file.read()
        self.assertNotIn(b"NOTIFY_SOCKET", variables)
        self.assertNotIn(b"WATCHDOG_USEC", variables)


class SocketInAFolder(ServiceManagerTest):
    address = "/tmp/dccast-test-%d" % os.getpid()
    # The variable belongs to another process: no heartbeat is expected of this one.
    environment = {"WATCHDOG_USEC": "400000", "WATCHDOG_PID": "1"}

    def setUp(self):
        self.addCleanup(os.remove, self.address)
        super().setUp()

    def test_a_manager_that_does_not_read_holds_up_nothing(self):
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as filler:
            filler.setblocking(False)
            with self.assertRaises(BlockingIOError):
                while True:
                    filler.sendto(b"STATUS=", self.address)
        self.assertEqual(self.daemon.terminate(), 0)

    def test_without_a_watchdog_only_the_state(self):
        self.assertEqual(self.manager.next(), {"READY": "1", "STATUS": "0 queued, 0 running"})
        self.daemon.process.send_signal(signal.SIGUSR1)
        self.assertEqual([*self.manager.next()], ["STOPPING", "STATUS"])
        self.assertEqual(self.daemon.wait(), 0)


class QueueThatHangs(ServiceManagerTest):
    """A disk takes 2 s to sync the events of a job, tests/faults/README.md."""

    def setUp(self):
        self.order = f"/tmp/dccast-test-order-{os.getpid()}"
        preloaded = {"LD_PRELOAD": os.path.join(BIN, "failing_disk.so"),
                     "DCCAST_FAULT_FILE": self.order, "DCCAST_FAULT_FOLDER": "/tmp"}
        self.environment = {**self.environment, **preloaded}
        super().setUp()

    def silences(self):
        return self.daemon.said().count("watchdog ping withheld")

    def test_no_sign_of_life_until_it_turns_again(self):
        job_id, _ = self.running_job()
        with open(self.order, "w", encoding="ascii") as file:
            file.write("0 s -1 events.log")
        self.addCleanup(os.remove, self.order)
        self.let_go(job_id)
        until(lambda: self.manager.waiting() == [] and self.silences() > 0, 30)
        silences = self.silences()
        until(lambda: self.silences() > silences, 30)
        self.assertEqual(self.manager.waiting(), [])
        with open(self.order, "w", encoding="ascii"):
            pass
        self.manager.until("WATCHDOG")
        self.client.until_state(job_id, SUCCEEDED)


if __name__ == "__main__":
    main()
