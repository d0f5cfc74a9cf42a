#!/usr/bin/python3
"""dccast --server ssh://HOST: by a stand-in for ssh, and by a real sshd on loopback."""
import getpass
import os
import shutil
import signal
import socket
import subprocess
import threading

from dccast.v1 import job_pb2
from support import BIN, ServiceTest, fake_case, main, start_ticks
from waiting import until

STAND_IN = """#!/usr/bin/python3
import os, signal, socket, sys, threading, time
def carry(source, target):
    while data := source.recv(65536):
        target.sendall(data)
    target.shutdown(socket.SHUT_WR)
with open({notes!r}, "a") as notes:
    print(*[word.replace(os.environ["TMPDIR"], "TMP") for word in sys.argv[1:]], os.getpid(), file=notes)
if "nowhere" in sys.argv:
    sys.exit("ssh: Could not resolve hostname nowhere")
listener = socket.socket(socket.AF_UNIX)
listener.bind(sys.argv[sys.argv.index("-L") + 1].split(":")[0])
time.sleep({pause_s})  # as a slow login
listener.listen()
while True:
    client = listener.accept()[0]
    peer = socket.socket(socket.AF_UNIX)
    peer.connect({path!r})
    for pair in ((client, peer), (peer, client)):
        threading.Thread(target=carry, args=pair, daemon=True).start()
"""
OPTIONS = "-N -T -S none -o ServerAliveInterval=15 -L TMP/dccast-ssh-"


class SshTest(ServiceTest):
    def setUp(self):
        super().setUp()
        self.temporary = self.in_folder("tmp")
        os.mkdir(self.temporary)
        self.programs = self.folder + ":" + os.environ["PATH"]
        self.socket = self.daemon.address.removeprefix("unix:")

    def write_ssh(self, text):
        os.chmod(self.write_file("ssh", text), 0o700)

    def start_dccast(self, server, *words):
        environment = {**os.environ, "PATH": self.programs, "TMPDIR": self.temporary, "HOME": self.folder}
        return subprocess.Popen([os.path.join(BIN, "dccast"), "--server", server, *words], text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                env=environment, stdin=subprocess.DEVNULL)

    def dccast(self, server, *words, code=0):
        ended = self.start_dccast(server, *words)
        out, err = ended.communicate(timeout=90)
        self.assertEqual(ended.returncode, code, err)
        self.assertEqual(os.listdir(self.temporary), [], "the socket is left")
        return out if code == 0 else out + err

    def doctor(self, server, cause, remedy):
        """One sentence about the cause, one remedy, each with these texts."""
        said = self.dccast(server, "doctor", "--timeout", "1", code=4).splitlines()
        said = [line for line in said if not line.startswith("ok ")]
        self.assertEqual([line.split()[0] for line in said], ["cause", "remedy"], said)
        for line, texts in zip(said, (cause, remedy)):
            for text in texts:
                self.assertIn(text, line)


class StandIn(SshTest):
    def setUp(self):
        super().setUp()
        self.notes = self.in_folder("notes")
        self.stand_in(pause_s=0)

    def stand_in(self, pause_s):
        """@param pause_s  from the making of the socket until it listens"""
        self.write_ssh(STAND_IN.format(notes=self.notes, path=self.socket, pause_s=pause_s))

    def calls(self):
        """Words of each ssh without the name of its folder, and its process id."""
        with open(self.notes, encoding="utf-8") as file:
            lines = file.read().splitlines()
        for line in lines:
            self.assertTrue(line.startswith(OPTIONS), line)
        return [line.removeprefix(OPTIONS).split(":", 1)[1].rsplit(" ", 1) for line in lines]

    def test_a_job_is_submitted_and_followed(self):
        job = self.client.submit(fake_case("steps=50 sleep_ms=10")).id
        self.assertIn("succeeded", self.dccast("ssh://anna@casthouse:2222/run/user/7/dccastd.sock",
                                               "wait", job))
        self.dccast("ssh://casthouse", "info")
        self.assertEqual([words for words, _ in self.calls()],
                         ["/run/user/7/dccastd.sock -p 2222 -- anna@casthouse",
                          "/run/dccast/dccastd.sock -- casthouse"])

    def test_a_connection_that_breaks_is_made_again(self):
        job = self.client.submit(fake_case("steps=400 sleep_ms=10")).id
        watch = self.start_dccast("ssh://casthouse", "wait", job)
        until(lambda: os.path.exists(self.notes) and self.calls(), 10)
        self.client.until_step(job, 20)
        os.kill(int(self.calls()[0][1]), signal.SIGKILL)
        until(lambda: len(self.calls()) == 2, 20)
        self.assertIn("succeeded", watch.communicate(timeout=60)[0])

    def test_no_ssh_outlives_a_client_that_was_killed(self):
        job = self.client.submit(fake_case("steps=100000 sleep_ms=10")).id
        watch = self.start_dccast("ssh://casthouse", "wait", job)
        until(lambda: os.path.exists(self.notes) and self.calls(), 10)
        process = int(self.calls()[0][1])
        watch.kill()
        watch.communicate(timeout=10)
        until(lambda: start_ticks(process) == 0, 10)
        self.client.cancel(job)

    def test_what_ssh_says_is_shown(self):
        self.assertIn("Could not resolve", self.dccast("ssh://nowhere", "info", code=4))

    def test_doctor_knows_what_ssh_itself_does_not_do(self):
        self.doctor("ssh://nowhere:2222", ["ssh ended with exit code 1: ssh: Could not resolve"],
                    ["ssh -p 2222 nowhere alone"])
        self.write_ssh("#!/bin/sh\nprintf 'be \\033[2Jwarned\\n' >&2\nexit 255\n")
        self.doctor("ssh://casthouse", ["exit code 255: be \\u{1B}[2Jwarned"], ["ssh casthouse alone"])
        self.write_ssh("#!/bin/sh\nexec sleep 60\n")
        self.doctor("ssh://casthouse", ["no answer in time"], ["there dccast doctor"])
        os.remove(self.in_folder("ssh"))
        self.programs = self.folder
        self.doctor("ssh://casthouse", ["ssh cannot be started"], ["openssh-client"])

    def test_a_socket_that_does_not_listen_yet_is_waited_for(self):
        self.stand_in(pause_s=0.3)
        self.dccast("ssh://casthouse", "info")

    def test_no_option_gets_through_as_a_host(self):
        for server in ("ssh://-oProxyCommand=id", "ssh://a@-oProxyCommand=id", "ssh://", "ssh://a b",
                       "ssh://host:port", "ssh://host;id", "ssh://host/a:/b", "ssh://host/" + "x" * 107):
            self.assertIn("write ssh://", self.dccast(server, "info", code=2))
        self.assertFalse(os.path.exists(self.notes))

    def test_a_port_of_earlier_versions_is_answered_with_the_remedy(self):
        said = self.dccast("ssh://casthouse/7117", "info", code=2)
        for text in ("PATH", "Unix socket", "/run/dccast/dccastd.sock"):
            self.assertIn(text, said)


class RealSsh(SshTest):
    """A real sshd of this user's own on a free loopback port, with keys made for this test."""

    def setUp(self):
        super().setUp()
        if not os.path.exists("/usr/sbin/sshd"):
            self.skipTest("openssh-server is not installed: deploy/install_packages test")
        for name in ("host", "user"):
            subprocess.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", self.path(name)],
                           check=True, timeout=20)
        shutil.copy(self.path("user.pub"), self.path("authorized"))
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.ssh_port = free.getsockname()[1]
        os.makedirs("/run/sshd", exist_ok=True)
        self.start_sshd()
        self.addCleanup(self.end_sshd)
        # The user's own settings of ssh, which has no option for another HOME.
        self.ssh_with("user")

    def start_sshd(self, *options):
        with open(self.path("sshd.log"), "wb") as log:
            self.sshd = subprocess.Popen(
                ["/usr/sbin/sshd", "-D", "-e", "-f", "/dev/null", "-h", self.path("host"),
                 "-p", str(self.ssh_port), "-o", "ListenAddress=127.0.0.1",
                 "-o", f"AuthorizedKeysFile={self.path('authorized')}", "-o", "StrictModes=no",
                 "-o", "PermitRootLogin=yes", "-o", "PidFile=none", "-o", "UsePAM=no", *options],
                stderr=log)
        until(self.listens, 10)

    def ssh_with(self, key):
        self.write_ssh(f'#!/bin/sh\nexec /usr/bin/ssh -F /dev/null -i {self.path(key)} '
                       '-o UserKnownHostsFile=/dev/null -o StrictHostKeyChecking=no '
                       '-o IdentitiesOnly=yes -o BatchMode=yes "$@"\n')

    def listens(self):
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", self.ssh_port)) == 0

    def server(self, path):
        return f"ssh://{getpass.getuser()}@127.0.0.1:{self.ssh_port}{path}"

    def path(self, name):
        return self.in_folder(name)

    def end_sshd(self):
        self.sshd.terminate()
        self.sshd.wait(10)

    def test_the_owner_is_the_user_of_the_other_machine(self):
        server = self.server(self.socket)
        job = self.client.submit(fake_case("steps=50 sleep_ms=10")).id
        self.assertIn("succeeded", self.dccast(server, "wait", job))
        self.assertIn(getpass.getuser(), self.dccast(server, "whoami"))
        self.assertEqual(self.client.job(job).state, job_pb2.SUCCEEDED)

    def test_doctor(self):
        sound = self.dccast(self.server(self.socket), "doctor")
        self.assertIn(f"ok      ssh reaches {self.socket} on the other machine\n", sound)
        self.assertIn(f"ok      you are {getpass.getuser()}, ", sound)
        missing = self.path("missing")
        self.doctor(self.server(missing), [f"makes no connection to {missing} there", "open failed"],
                    ["start dccastd there", "ssh://HOST/PATH"])
        with socket.socket(socket.AF_UNIX) as listener:
            listener.bind(self.path("other"))
            listener.listen()
            threading.Thread(target=greet_and_close, args=(listener,), daemon=True).start()
            self.doctor(self.server(self.path("other")), ["does not speak gRPC"], ["ssh://HOST/PATH"])
        self.ssh_with("host")
        self.doctor(self.server(self.socket), ["ssh ended with exit code 255: ", "Permission denied"], [" alone"])
        self.ssh_with("user")
        self.end_sshd()
        self.doctor(self.server(self.socket), ["exit code 255: ", "Connection refused"],
                    [f"ssh -p {self.ssh_port} "])

    def test_doctor_where_forwarding_is_forbidden(self):
        self.end_sshd()
        self.start_sshd("-o", "AllowStreamLocalForwarding=no")
        self.doctor(self.server(self.socket), ["makes no connection", "open failed"],
                    ["AllowStreamLocalForwarding", "over TLS"])


def greet_and_close(listener):
    peer = listener.accept()[0]
    with peer:
        peer.sendall(b"220 some other program\r\n")
        peer.recv(1000)


if __name__ == "__main__":
    main()
