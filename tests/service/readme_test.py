#!/usr/bin/python3
"""What README has a newcomer type works as it stands, and pages show what the program prints."""
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

from support import BIN, SANITIZED
from waiting import WAIT_FACTOR, until

ROOT = pathlib.Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def typed_lines():
    """The command lines of README after the two that set up, without what a comment says."""
    lines = re.findall(r"^ {4}((?:dccast|dccastd) .*)$", README, re.MULTILINE)
    return [re.sub(r" +# .*", "", line) for line in lines]


class NextCommands(unittest.TestCase):
    """README's commands after `deploy/quickstart --install`, with a worker that computes nothing."""

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="dccast-readme-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        for name in ("cases", "deploy"):
            os.symlink(ROOT / name, self.folder / name)
        # A plant's own measurement is the one thing that README cannot bring.
        (self.folder / "curl.csv").write_text("time [s],curl corner [mm]\n10,0.2\n60,2\n100,3\n140,4\n")
        self.environment = {"HOME": str(self.folder / "home"), "PATH": "/usr/bin:/bin",
                            "DCCAST_BUILD": str(pathlib.Path(BIN).parent), "BROWSER": "true",
                            "LC_ALL": "C.UTF-8"}
        self.daemon = None

    def tearDown(self):
        if self.daemon is not None:
            self.daemon.send_signal(signal.SIGTERM)
            self.daemon.wait(60)

    def install(self):
        prefix = self.folder / "prefix"
        shown = subprocess.run([ROOT / "deploy/at_hand", "--install", prefix], text=True, timeout=120,
                               capture_output=True, check=True, env=self.environment).stdout
        path = re.search(r'export PATH="(.*):\$PATH"', shown).group(1)
        self.assertEqual(path, str(prefix / "bin"))
        self.environment["PATH"] = f"{path}:{self.environment['PATH']}"
        shutil.copy(pathlib.Path(BIN) / "dccast-worker-fake", prefix / "bin/dccast-worker")

    def start_daemon(self, line):
        """The line as it stands, but at a socket that nothing else on this machine uses."""
        port_file = self.folder / "port"
        command = line.removesuffix(" &")
        self.assertNotEqual(command, line, "the daemon of README keeps the terminal")
        self.daemon = subprocess.Popen(
            [*command.split(), "--set", f"listen.socket=unix:{self.folder}/socket",
             "--set", f"listen.port_file={port_file}"],
            cwd=self.folder, env=self.environment, stderr=subprocess.DEVNULL)
        until(lambda: port_file.exists() or self.daemon.poll() is not None, 15)
        self.environment["DCCAST_SERVER"] = port_file.read_text(encoding="ascii").split()[0]

    def run_line(self, line):
        return subprocess.run(["bash", "-c", line], cwd=self.folder, env=self.environment, text=True,
                              capture_output=True, timeout=120 * WAIT_FACTOR, check=False)

    def show_dashboard(self, line):
        """It serves until it is interrupted."""
        dashboard = subprocess.Popen(line.split(), cwd=self.folder, env=self.environment, text=True,
                                     stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.addCleanup(dashboard.stdout.close)
        self.assertIn("http://", dashboard.stdout.readline())
        dashboard.send_signal(signal.SIGINT)
        dashboard.wait(30)

    def test_they_work_as_they_stand(self):
        self.install()
        for line in typed_lines():
            with self.subTest(line=line):
                self.assertNotIn("...", line)
                if line.startswith("dccastd"):
                    self.start_daemon(line)
                elif "dashboard" in line:
                    self.show_dashboard(line)
                else:
                    ended = self.run_line(line)
                    # The worker computes no castings: no design is confirmed (3), no finding raised (6).
                    also = 3 if "design-" in line else 6 if "remedy" in line else 0
                    self.assertIn(ended.returncode, (0, also), ended.stderr)
        self.assertIsNotNone(self.daemon, "README starts no daemon")

    def test_readme_sets_up_with_two_commands(self):
        section = README.split("## Two commands")[1].split("\n## ")[0]
        self.assertEqual(re.findall(r"^ {4}(\S+)", section, re.MULTILINE),
                         ["./deploy/quickstart", "./tests/run"])

    def test_programs_that_are_not_installed_are_named_where_they_were_built(self):
        shown = subprocess.run([ROOT / "deploy/at_hand"], text=True, timeout=30, capture_output=True,
                               check=True, env=self.environment).stdout
        self.assertIn(f'export PATH="{os.path.realpath(BIN)}:$PATH"', shown)
        for line in re.findall(r"^ {4}(dccast.*)", shown, re.MULTILINE):
            program = line.split()[0]
            self.assertTrue(os.access(os.path.join(BIN, program), os.X_OK), line)


class Samples(unittest.TestCase):
    """docs/samples without --check brings the pages up to date."""

    slow = False

    @unittest.skipIf(SANITIZED, "the figures are those of the release")
    def test_pages_show_what_the_program_prints(self):
        command = [ROOT / "docs/samples", "--check", *([] if self.slow else ["--quick"])]
        ended = subprocess.run(command, capture_output=True, text=True, check=False)
        self.assertEqual(ended.returncode, 0, ended.stdout + ended.stderr)


if __name__ == "__main__":
    Samples.slow = "--nightly" in sys.argv
    unittest.main(argv=[word for word in sys.argv if word != "--nightly"])
