#!/usr/bin/python3
"""What is in the Debian packages."""
import gzip
import pathlib
import re
import subprocess
import tempfile
import unittest

from packages import BUILD, ROOT, made, run

UNIT = ROOT / "deploy/debian/dccastd.service"
WORST_EXPOSURE = 2.0  # of 10, as systemd-analyze counts


class Unit(unittest.TestCase):
    def test_exposure(self):
        for unit in (UNIT, UNIT.with_name("dccast-web.service")):
            text = run("systemd-analyze", "security", "--offline=true", f"--threshold={WORST_EXPOSURE * 10:.0f}", unit)
            self.assertLessEqual(float(re.search(r"exposure level for \S+: ([\d.]+)", text)[1]), WORST_EXPOSURE)

    def test_longer_to_stop_than_workers_have(self):
        settings = (ROOT / "deploy/config/dccastd.toml").read_text(encoding="utf-8")
        grace = float(re.search(r'^stop_grace = "([\d.]+) s"', settings, re.MULTILINE)[1])
        stop = float(re.search(r"^TimeoutStopSec=(\d+)$", UNIT.read_text(encoding="utf-8"), re.MULTILINE)[1])
        self.assertGreater(stop, grace)


class Packages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="dccast-packages-")
        cls.addClassCleanup(folder.cleanup)
        cls.packages = made(folder.name, "1.2.3")
        cls.root = pathlib.Path(folder.name) / "root"
        for package in cls.packages.values():
            run("dpkg-deb", "--extract", package, cls.root)

    def control(self, package, field):
        return run("dpkg-deb", "--field", self.packages[package], field).strip()

    def test_there_are_four_of_one_version(self):
        self.assertEqual(sorted(self.packages), ["dccast", "dccast-worker", "dccastd", "python3-dccast"])
        self.assertEqual({self.control(name, "Version") for name in self.packages}, {"1.2.3"})
        self.assertIn("dccast-worker (= 1.2.3)", self.control("dccastd", "Depends"))

    def test_lintian_finds_nothing(self):
        self.assertEqual(run("lintian", "--fail-on", "error,warning", "--allow-root", *self.packages.values()), "")

    def test_libraries_are_dependencies(self):
        for name, library in (("dccastd", "libgrpc"), ("dccast-worker", "libhdf5"), ("dccast", "libssl")):
            self.assertIn(library, self.control(name, "Depends"))

    def test_files(self):
        for path in ("usr/bin/dccast", "usr/bin/dccastd", "usr/bin/dccast-worker", "etc/dccast/dccastd.toml",
                     "usr/bin/dccast-web", "usr/lib/systemd/system/dccast-web.service", "etc/default/dccast-web",
                     "usr/share/dccast/openapi.json", "usr/share/dccast/record/record.py",
                     "usr/share/dccast/record/entries/slab-aa3104-curl.json",
                     "usr/lib/systemd/system/dccastd.service", "usr/lib/sysusers.d/dccastd.conf",
                     "usr/lib/tmpfiles.d/dccastd.conf", "usr/share/bash-completion/completions/dccast",
                     "etc/logrotate.d/dccastd", "usr/share/doc/dccastd/monitoring/alerts.yml",
                     "usr/share/doc/dccastd/monitoring/dashboard.json",
                     "usr/share/doc/dccastd/pages/operations.md", "usr/share/doc/dccast/pages/README.md",
                     "usr/lib/python3/dist-packages/dccast/__init__.py",
                     "usr/lib/python3/dist-packages/dccast/v1/service_pb2.py"):
            self.assertTrue((self.root / path).is_file(), path)
        self.assertFalse((self.root / "usr/bin/dccast-verify").exists())
        settings = (self.root / "etc/dccast/dccastd.toml").read_text(encoding="utf-8")
        self.assertIn('\ndata_directory = "/var/lib/dccast"\n', settings)

    def test_every_command_has_a_page_with_its_options(self):
        commands = re.findall(r"^  ([a-z][a-z-]*) {2,}\S", run(BUILD / "bin/dccast", "--help"), re.M)
        self.assertIn("submit", commands)
        man = self.root / "usr/share/man"
        for command in commands:
            page = gzip.decompress((man / f"man1/dccast-{command}.1.gz").read_bytes()).decode()
            for option in re.findall(r"^  (?:-\w,)?(--[a-z-]+)", run(BUILD / "bin/dccast", command, "--help"), re.M):
                self.assertIn(option.replace("-", r"\-"), page)
        for page in ("man1/dccast.1.gz", "man8/dccastd.8.gz", "man8/dccastd-user-add.8.gz",
                     "man8/dccast-web.8.gz", "man8/dccast-web-serve.8.gz"):
            self.assertTrue((man / page).is_file(), page)

    def test_pages_are_sound(self):
        for page in (self.root / "usr/share/man").glob("*/*.gz"):
            checked = subprocess.run(["man", "--warnings", "-l", page], capture_output=True, text=True, check=True,
                                     env={"PATH": "/usr/bin:/bin", "MANWIDTH": "80", "LC_ALL": "C.UTF-8"})
            self.assertEqual(checked.stderr, "", page.name)


if __name__ == "__main__":
    unittest.main()
