#!/usr/bin/python3
"""The image of deploy/image, run by buildah: it serves a job as the user of the service."""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import tomllib
import unittest

from packages import ROOT, made, run
from waiting import until

NAME = "dccast-test"
CASE = "cases/start-2d-thickness.toml"


def descendants(process):
    """Of all its threads: a child is that of the thread which started it."""
    lists = pathlib.Path(f"/proc/{process}/task").glob("*/children")
    children = [int(child) for one in lists for child in one.read_text(encoding="ascii").split()]
    return children + [below for child in children for below in descendants(child)]


class Image(unittest.TestCase):
    def setUp(self):
        for program in ("buildah", "mmdebstrap"):
            if not shutil.which(program):
                self.skipTest(f"{program} is not installed: deploy/install_packages nightly")
        if os.geteuid() != 0:
            self.skipTest("deploy/image needs root")
        folder = tempfile.TemporaryDirectory(prefix="dccast-image-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        # Images of this test's own, in plain folders: neither a kernel's overlay nor namespaces are needed.
        storage = self.folder / "storage.conf"
        storage.write_text(f'[storage]\ndriver = "vfs"\ngraphroot = "{self.folder}/images"\n'
                           f'runroot = "{self.folder}/run"\n', encoding="utf-8")
        self.environment = {**os.environ, "CONTAINERS_STORAGE_CONF": str(storage), "BUILDAH_ISOLATION": "chroot"}
        made(self.folder / "packages", "1.2.3")
        run(ROOT / "deploy/image", self.folder / "packages", NAME, env=self.environment, timeout=900)
        self.container = self.buildah("from", "--pull-never", f"localhost/{NAME}").split()[-1]

    def buildah(self, *words):
        return run("buildah", *words, env=self.environment, timeout=300)

    def inside(self, *command):
        return self.buildah("run", self.container, "--", *command)

    def start(self, config):
        command = ["buildah", "run", self.container, "--", *config["Entrypoint"], *config.get("Cmd", ()),
                   "--set", "listen.tls=127.0.0.1:0",
                   "--set", "listen.port_file=/var/lib/dccast/port"]
        runner = subprocess.Popen(command, env=self.environment)
        self.addCleanup(self.end, runner)

        def address():
            self.assertIsNone(runner.poll(), "the daemon has ended")
            found = subprocess.run(["buildah", "run", self.container, "--", "cat", "/var/lib/dccast/port"],
                                   env=self.environment, capture_output=True, text=True, check=False, timeout=60)
            return found.stdout.split()
        return runner, until(address, 60)

    def end(self, runner):
        """SIGTERM to the daemon, which buildah does not hand on."""
        if runner.poll() is None:
            for process in descendants(runner.pid):
                if pathlib.Path(f"/proc/{process}/comm").read_text(encoding="utf-8").strip() == "dccastd":
                    os.kill(process, signal.SIGTERM)
        return runner.wait(timeout=60)

    def test_it_serves_a_job(self):
        config = json.loads(self.buildah("inspect", "--type", "image", f"localhost/{NAME}"))["OCIv1"]["config"]
        self.assertEqual(config["User"], "dccast")
        self.assertIn("/var/lib/dccast", config["Volumes"])
        self.assertIn("7118/tcp", config["ExposedPorts"])
        settings = tomllib.loads(self.inside("cat", "/etc/dccast/dccastd.toml"))
        self.assertEqual(settings["listen"]["tls"], "0.0.0.0:7118")
        runner, (local, _over_tls) = self.start(config)
        self.buildah("copy", self.container, ROOT / CASE, "/tmp/case.toml")
        self.inside("dccast", "--server", local, "submit", "--watch", "--set", "quality=draft", "/tmp/case.toml")
        job = json.loads(self.inside("dccast", "--server", local, "show", "last", "--json"))
        self.assertEqual((job["state"], job["owner"]), ("SUCCEEDED", "dccast"))
        line = self.inside("dccastd", "user", "add", "anna", "--role", "submitter", "--set",
                           "listen.public_address=casthouse:7118", "--config", "/etc/dccast/dccastd.toml")
        self.assertIn("dccast login casthouse:7118/sha256:", line)
        self.assertEqual(self.end(runner), 0)


if __name__ == "__main__":
    unittest.main()
