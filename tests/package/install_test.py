#!/usr/bin/python3
"""The life of the packages in a Debian of their own: installed, used, upgraded, removed, purged."""
import json
import shutil
import tempfile
import unittest

from debian_root import DebianRoot, Unit
from packages import ROOT, made
from waiting import until

CASE = "cases/start-2d-thickness.toml"
LONG_CASE = "cases/start-3d.toml"  # runs longer than an upgrade takes
BEFORE, NOW = "0.0.1", "9.0.0"


class Life(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="dccast-packages-")
        self.addCleanup(folder.cleanup)
        self.versions = {version: list(made(f"{folder.name}/{version}", version).values()) for version in (BEFORE, NOW)}
        self.root = DebianRoot()
        self.addCleanup(self.root.close)

    def dccast(self, *words):
        return self.root.run("dccast", *words, "--server", self.address(), timeout=300)

    def address(self):
        return (self.root.path / "var/lib/dccast/address").read_text(encoding="utf-8").split()[0]

    def job(self, name):
        return json.loads(self.dccast("show", name, "--json"))

    def test_it(self):
        self.root.install(*self.versions[BEFORE])
        daemon = self.start_and_run_a_job()
        self.upgrade_under_a_job(daemon)
        self.remove_and_come_back(daemon)
        self.purge()

    def start_and_run_a_job(self):
        settings = self.root.path / "etc/dccast/dccastd.toml"
        text = settings.read_text(encoding="utf-8")
        self.changed = text.replace("[listen]", '[listen]\nport_file = "/var/lib/dccast/address"')
        settings.write_text(self.changed, encoding="utf-8")
        self.assertEqual((self.root.path / "var/lib/dccast").stat().st_mode & 0o777, 0o700)
        daemon = Unit(self.root, "dccastd").start()
        self.addCleanup(daemon.kill)
        self.root.run("dccastd", "user", "add", "anna", "--role", "submitter",
                      "--set", "listen.public_address=casthouse:7118",
                      "--set", "listen.tls=127.0.0.1:0", "--config", "/etc/dccast/dccastd.toml")
        users = self.root.path / "var/lib/dccast/users.toml"
        self.assertEqual(users.stat().st_uid, users.parent.stat().st_uid, "root writes for the service")
        shutil.copy(ROOT / CASE, self.root.path / "tmp/case.toml")
        self.dccast("submit", "--watch", "--set", "quality=draft", "/tmp/case.toml")
        self.assertEqual(self.job("last")["state"], "SUCCEEDED")
        self.dccast("fetch", "last", "-o", "/tmp/results.h5")
        self.assertTrue(self.root.has("tmp/results.h5"))
        return daemon

    def upgrade_under_a_job(self, daemon):
        """What the service manager does for postinst, which finds none here, is done by hand."""
        shutil.copy(ROOT / LONG_CASE, self.root.path / "tmp/long.toml")
        self.dccast("submit", "--set", "quality=engineering", "/tmp/long.toml")
        until(lambda: self.job("last").get("last_step"), 120)
        self.root.install(*self.versions[NOW])
        self.assertEqual((self.root.path / "etc/dccast/dccastd.toml").read_text(encoding="utf-8"), self.changed)
        self.assertEqual(self.job("last")["state"], "RUNNING")
        daemon.restart()
        self.assertEqual(self.job("last")["state"], "RUNNING")
        self.dccast("wait", "last")
        self.assertEqual(self.job("last")["attempts"], 1, "the worker of before went on")

    def remove_and_come_back(self, daemon):
        daemon.stop()
        self.root.run("apt-get", "remove", "-y", "dccastd")
        self.assertFalse(self.root.has("usr/bin/dccastd"))
        self.assertTrue(self.root.has("etc/dccast/dccastd.toml"))
        self.root.install(*self.versions[NOW])
        daemon.start()
        self.assertEqual(self.job("last")["state"], "SUCCEEDED")
        self.check(daemon)  # damage would be exit code 3

    def check(self, daemon):
        daemon.stop()
        return self.root.run("dccastd", "check", "--deep", "--config", "/etc/dccast/dccastd.toml")

    def purge(self):
        self.root.run("apt-get", "purge", "-y", "dccastd", "dccast-worker", "dccast", "python3-dccast")
        for path in ("etc/dccast", "var/lib/dccast", "usr/bin/dccast", "usr/bin/dccast-worker",
                     "usr/lib/python3/dist-packages/dccast"):
            self.assertFalse(self.root.has(path), path)


if __name__ == "__main__":
    unittest.main()
