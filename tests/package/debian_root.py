"""A Debian of its own in a folder, made from the mirror of this machine."""
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import tempfile

from packages import run


def sources_of_this_machine():
    """The files of apt that name Debian itself."""
    files = [pathlib.Path("/etc/apt/sources.list"), *pathlib.Path("/etc/apt/sources.list.d").glob("*")]
    return [file for file in files
            if file.is_file() and "debian-archive-keyring" in file.read_text(encoding="utf-8")] or files[:1]


class DebianRoot:
    """Needs root. Without a service manager: a Unit does what the unit file asks of one."""

    def __init__(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="dccast-root-"))
        self.folder.chmod(0o755)
        self.path = self.folder / "root"
        run("mmdebstrap", "--variant=apt", "--mode=root", "bookworm", self.path,
            *sources_of_this_machine(), timeout=900)
        shutil.copy("/etc/resolv.conf", self.path / "etc/resolv.conf")
        run("chroot", self.path, "apt-get", "update", "-q", timeout=300)
        run("mount", "-t", "proc", "proc", self.path / "proc")
        run("mount", "--rbind", "/dev", self.path / "dev")

    def close(self):
        for folder in ("proc", "dev"):
            subprocess.run(["umount", "--lazy", "--recursive", self.path / folder], check=False)
        if os.path.ismount(self.path / "dev"):
            raise RuntimeError(f"{self.path}/dev is still mounted")
        shutil.rmtree(self.folder)

    def run(self, *command, **rest):
        return run("chroot", self.path, "env", "DEBIAN_FRONTEND=noninteractive", "LC_ALL=C.UTF-8", *command,
                   **rest)

    def install(self, *packages):
        for package in packages:
            shutil.copy(package, self.path / "tmp")
        return self.run("apt-get", "install", "-y", "-q", "--no-install-recommends", "--allow-downgrades",
                        *(f"/tmp/{package.name}" for package in packages), timeout=900)

    def has(self, path):
        return (self.path / path).exists()


class Unit:
    """Runs a unit's ExecStart as its user in its folder, and waits until it is ready."""

    def __init__(self, root, name):
        self.root = root
        text = (root.path / "usr/lib/systemd/system" / f"{name}.service").read_text(encoding="utf-8")
        self.settings = dict(line.split("=", 1) for line in text.splitlines() if "=" in line and line[0] != "#")
        self.process = None

    def start(self):
        socket_path = self.root.path / "run/notify"
        socket_path.unlink(missing_ok=True)
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
            manager.bind(str(socket_path))
            socket_path.chmod(0o666)
            manager.settimeout(60)
            user = self.settings["User"]
            self.process = subprocess.Popen(
                ["chroot", self.root.path, "setpriv", f"--reuid={user}", f"--regid={self.settings['Group']}",
                 "--init-groups", "--no-new-privs", "--bounding-set=-all", "env",
                 f"--chdir={self.settings['WorkingDirectory']}", "NOTIFY_SOCKET=/run/notify",
                 *self.settings["ExecStart"].split()])
            if not manager.recv(4096).startswith(b"READY=1\n"):
                raise AssertionError("the first message is not READY=1")
        return self

    def stop(self):
        """What systemctl stop does."""
        self.end(signal.SIGTERM)

    def restart(self):
        """What systemctl restart does."""
        self.end(getattr(signal, self.settings["RestartKillSignal"]))
        return self.start()

    def end(self, number):
        self.process.send_signal(number)
        if self.process.wait(timeout=float(self.settings["TimeoutStopSec"])) != 0:
            raise AssertionError(f"dccastd ended with {self.process.returncode}")

    def kill(self):
        if self.process and self.process.poll() is None:
            self.process.kill()
            self.process.wait()
