#!/usr/bin/python3
"""dccast --server ssh://HOST: by a stand-in for ssh, and by a real sshd on loopback."""
import getpass
import os
import shutil
import socket
import subprocess

from dccast.v1 import job_pb2
from support import BIN, ServiceTest, fake_case, main, until

STAND_IN = """#!/usr/bin/python3
import os, select, socket, sys
with open({notes!r}, "a") as notes:
    print(*sys.argv[1:], file=notes)
if "nowhere" in sys.argv:
    sys.exit("ssh: Could not resolve hostname nowhere")
peer = socket.create_connection(("127.0.0.1", {port}))
while True:
    for ready in select.select([0, peer], [], [])[0]:
        data = os.read(0, 65536) if ready == 0 else peer.recv(65536)
        if not data:
            sys.exit(0)
        peer.sendall(data) if ready == 0 else os.write(1, data)
"""


class SshTest(ServiceTest):
    def setUp(self):
        super().setUp()
        self.temporary = os.path.join(self.folder, "tmp")
        os.mkdir(self.temporary)
        self.programs = self.folder + ":" + os.environ["PATH"]
        self.port = self.daemon.address.rsplit(":", 1)[1]

    def write_ssh(self, text):
        with open(os.path.join(self.folder, "ssh"), "w", encoding="utf-8") as file:
            file.write(text)
        os.chmod(file.name, 0o700)

    def dccast(self, server, *words, code=0):
        environment = {**os.environ, "PATH": self.programs, "TMPDIR": self.temporary, "HOME": self.folder}
        ended = subprocess.run([os.path.join(BIN, "dccast"), "--server", server, *words],
                               capture_output=True, text=True, timeout=90, check=False,
                               env=environment, stdin=subprocess.DEVNULL)
        self.assertEqual(ended.returncode, code, ended.stderr)
        self.assertEqual(os.listdir(self.temporary), [], "the socket is left")
        return ended.stdout if code == 0 else ended.stdout + ended.stderr

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
        self.notes = os.path.join(self.folder, "notes")
        self.write_ssh(STAND_IN.format(notes=self.notes, port=self.port))

    def calls(self):
        with open(self.notes, encoding="utf-8") as file:
            return file.read().splitlines()

    def test_a_job_is_submitted_and_followed(self):
        job = self.client.submit(fake_case("steps=50 sleep_ms=10")).id
        self.assertIn("succeeded", self.dccast("ssh://anna@casthouse:2222/7200", "wait", job))
        self.assertEqual(self.calls(), ["-T -W 127.0.0.1:7200 -p 2222 -- anna@casthouse"])
        self.dccast("ssh://casthouse", "info")
        self.assertEqual(self.calls()[1:], ["-T -W 127.0.0.1:7117 -- casthouse"])

    def test_what_ssh_says_is_shown(self):
        self.assertIn("Could not resolve", self.dccast("ssh://nowhere", "info", code=4))

    def test_doctor_knows_what_ssh_itself_does_not_do(self):
        self.doctor("ssh://nowhere:2222", ["ssh ended with exit code 1: ssh: Could not resolve"],
                    ["ssh -p 2222 nowhere alone"])
        self.write_ssh("#!/bin/sh\nprintf 'be \\033[2Jwarned\\n' >&2\nexit 255\n")
        self.doctor("ssh://casthouse", ["exit code 255: be \\u{1B}[2Jwarned"], ["ssh casthouse alone"])
        self.write_ssh("#!/bin/sh\nexec sleep 60\n")
        self.doctor("ssh://casthouse", ["no answer in time"], ["there dccast doctor"])
        os.remove(os.path.join(self.folder, "ssh"))
        self.programs = self.folder
        self.doctor("ssh://casthouse", ["ssh cannot be started"], ["openssh-client"])

    def test_no_option_gets_through_as_a_host(self):
        for server in ("ssh://-oProxyCommand=id", "ssh://a@-oProxyCommand=id", "ssh://", "ssh://a b",
                       "ssh://host:port", "ssh://host;id"):
            self.assertIn("write ssh://", self.dccast(server, "info", code=2))
        self.assertFalse(os.path.exists(self.notes))


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

    def server(self, port):
        return f"ssh://{getpass.getuser()}@127.0.0.1:{self.ssh_port}/{port}"

    def path(self, name):
        return os.path.join(self.folder, name)

    def end_sshd(self):
        self.sshd.terminate()
        self.sshd.wait(10)

    def test_the_owner_is_the_user_of_the_other_machine(self):
        server = self.server(self.port)
        job = self.client.submit(fake_case("steps=50 sleep_ms=10")).id
        self.assertIn("succeeded", self.dccast(server, "wait", job))
        self.assertIn(getpass.getuser(), self.dccast(server, "whoami"))
        self.assertEqual(self.client.job(job).state, job_pb2.SUCCEEDED)

    def test_doctor(self):
        sound = self.dccast(self.server(self.port), "doctor")
        self.assertIn(f"ok      ssh reaches 127.0.0.1:{self.port} on the other machine\n", sound)
        self.assertIn(f"ok      you are {getpass.getuser()}, ", sound)

        with socket.socket() as closed:
            closed.bind(("127.0.0.1", 0))
            port = closed.getsockname()[1]
            self.doctor(self.server(port), [f"nothing takes connections at 127.0.0.1:{port}", "Connection refused"],
                        ["start dccastd there"])
        self.doctor(self.server(self.ssh_port), ["does not speak gRPC"], ["port of dccastd"])
        self.ssh_with("host")
        self.doctor(self.server(self.port), ["ssh ended with exit code 255: ", "Permission denied"], [" alone"])
        self.ssh_with("user")
        self.end_sshd()
        self.doctor(self.server(self.port), ["exit code 255: ", "Connection refused"],
                    [f"ssh -p {self.ssh_port} "])

    def test_doctor_where_forwarding_is_forbidden(self):
        elsewhere = "PermitOpen=127.0.0.1:" + str(self.ssh_port)
        for forbidden in ("AllowTcpForwarding=no", elsewhere):
            self.end_sshd()
            self.start_sshd("-o", forbidden)
            self.doctor(self.server(self.port), ["forbids forwarding", "administratively prohibited"],
                        ["AllowTcpForwarding", "over TLS"])

    def test_doctor_at_the_port_of_others(self):
        self.daemon.terminate()
        self.daemon.settings["listen_tls"] = "127.0.0.1:0"
        self.daemon.start()
        port = self.daemon.tls_address.rsplit(":", 1)[1]
        self.doctor(self.server(port), ["without an answer"], ["not that of listen_tls"])


if __name__ == "__main__":
    main()
