"""A Slurm of one machine for tests, without systemd: munged, slurmctld and slurmd as children, with
configuration, key, state and logs in one folder, on free ports of loopback."""
import os
import pwd
import shutil
import signal
import socket
import subprocess
import time
from waiting import until


PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scancel", "scontrol")
# Every started process ends with the test, even if the test is killed.
TIED = ("setpriv", "--pdeathsig", "KILL")
SBIN = os.environ.get("PATH", "") + os.pathsep + "/usr/sbin"

CONFIGURATION = """\
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
SlurmctldPort={controller_port}
SlurmdPort={node_port}
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SlurmdParameters=config_overrides
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerType=sched/backfill
SchedulerParameters=bf_interval=1,sched_interval=2,batch_sched_delay=1
MpiDefault=none
SwitchType=switch/none
ReturnToService=2
MinJobAge=60
KillWait=5
SlurmdTimeout=30
JobRequeue=1
NodeName={host} NodeAddr=127.0.0.1 CPUs={cores} RealMemory=2000 State=UNKNOWN
PartitionName=batch Nodes={host} Default=YES MaxTime=01:00:00 State=UP
"""


def missing_programs():
    return [name for name in PROGRAMS if not shutil.which(name, path=SBIN)]


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for each in sockets:
        each.bind(("127.0.0.1", 0))
    ports = [each.getsockname()[1] for each in sockets]
    for each in sockets:
        each.close()
    return ports


class Cluster:
    """Slurm in a folder. After start(), SLURM_CONF is in the environment of this process."""

    def __init__(self, folder, cores=4):
        self.folder = folder
        self.cores = cores
        self.host = socket.gethostname().split(".")[0]
        self.processes = {}

    def start(self):
        for name in ("state", "spool"):
            os.makedirs(os.path.join(self.folder, name))
        ports = free_ports(2)
        with open(self.path("slurm.conf"), "w", encoding="ascii") as file:
            file.write(CONFIGURATION.format(
                folder=self.folder, host=self.host, user=pwd.getpwuid(os.getuid()).pw_name,
                controller_port=ports[0], node_port=ports[1], cores=self.cores))
        with open(self.path("munge.key"), "wb") as file:
            os.fchmod(file.fileno(), 0o600)
            file.write(os.urandom(128))
        os.environ["SLURM_CONF"] = self.path("slurm.conf")
        for name in ("munged", "slurmctld", "slurmd"):
            self.start_program(name)
        until(self.node_is_ready, 30)
        return self

    def path(self, name):
        return os.path.join(self.folder, name)

    def words(self, name):
        if name == "munged":
            options = [f"--{option}={self.path('munge.' + end)}" for option, end in (
                ("key-file", "key"), ("socket", "socket"), ("pid-file", "pid"),
                ("log-file", "log"), ("seed-file", "seed"))]
            return ["--foreground", "--force", *options]
        return ["-D"]

    def start_program(self, name):
        with open(self.path(name + ".out"), "ab") as out:
            self.processes[name] = subprocess.Popen(
                [*TIED, shutil.which(name, path=SBIN), *self.words(name)], stdin=subprocess.DEVNULL,
                stdout=out, stderr=out, cwd=self.folder, start_new_session=True)
        if name == "munged":
            until(lambda: os.path.exists(self.path("munge.socket")), 10)

    def kill(self, name, number=signal.SIGKILL):
        process = self.processes.pop(name, None)
        if process is None:
            return
        process.send_signal(number)
        try:
            process.wait(timeout=20)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()

    def stop(self):
        """Ends what was started; jobs are the concern of who submitted them."""
        for name in ("slurmctld", "slurmd", "munged"):
            self.kill(name, signal.SIGTERM)
        os.environ.pop("SLURM_CONF", None)

    def run(self, *words):
        ended = subprocess.run(words, capture_output=True, text=True, timeout=60, check=False)
        return ended.stdout if ended.returncode == 0 else ""

    def node_is_ready(self):
        state = self.run("sinfo", "--noheader", "--format=%T").strip()
        if state.startswith(("down", "drain")):  # of a slurmd that was away; what an admin does
            self.resume_node()
        # "*": slurmctld, just started, has not reached it yet; its jobs wait as long.
        return state.rstrip("*") in ("idle", "mixed", "allocated", "completing")

    def resume_node(self):
        self.run("scontrol", "update", f"NodeName={self.host}", "State=RESUME")

    def jobs(self, *options):
        return self.run("squeue", "--noheader", "--format=%i %T %j %r", *options).splitlines()

    def until_empty(self, seconds=60):
        until(lambda: not self.jobs(), seconds)

    def restart(self, name, away=0.0):
        """kill -9, and started again."""
        self.kill(name)
        time.sleep(away)  # for so long nothing answers
        self.start_program(name)
