"""Everything at once for hours: what grows with time shows in the daemon's memory and descriptors."""
import contextlib
import os
import signal
import subprocess
import time

import grpc

from cases import REAL, coarse, failing_check
from clients import memory_of
from dccast.v1 import study_pb2
from oracle import Count, judge, undisturbed
from queries import varied
from scene import TIED, at_some_step, signal_process
from studies import KilledStudy
from support import BIN
from waiting import pause


class Soak(KilledStudy):
    """Castings, a sweep, queries and kills, round after round; the daemon is killed at half time"""
    worker = REAL
    hours = 1.0
    settings = {"workers__count": 2, "workers__restarts": 100}
    # Of a daemon between a quarter of its time, when caches are full, and its end.
    most_grown_mb = 16.0
    most_grown_descriptors = 8

    def plan(self):
        sweep = study_pb2.SweepPlan(design=study_pb2.SweepPlan.GRID)
        sweep.axes.add(key="alloy.conductivity.scale", values=["0.9", "1", "1.1"])
        return coarse(), sweep

    def attempt(self, chance, most):
        count = Count()
        with self.scene(chance) as scene:
            for _ in range(2):
                self.live(scene, count, time.monotonic() + self.hours * 1800)
                scene.tell_daemon(signal.SIGKILL)
                scene.come_back()
        return count

    def live(self, scene, count, end):
        """Rounds of one daemon, and what it has grown by."""
        begin, settled = time.monotonic(), None
        while settled is None or time.monotonic() < end:
            self.round(scene, count)
            megabytes, descriptors = held_by(scene.daemon.process.pid)
            count.measured("MB at most", megabytes)
            count.measured("descriptors at most", descriptors)
            if settled is None and time.monotonic() - begin > (end - begin) / 4:
                settled = megabytes, descriptors
        grown = megabytes - settled[0], descriptors - settled[1]
        count.measured("MB more at the end of a daemon than after a quarter", grown[0])
        if grown[0] > self.most_grown_mb or grown[1] > self.most_grown_descriptors:
            count.found("wrong", f"the daemon has grown by {grown[0]:.1f} MB, {grown[1]} descriptors")

    def round(self, scene, count):
        count.tried += 1
        self.request = f"sweep {count.tried}"
        self.begin(scene)
        castings = [scene.submit(case()) for case in (coarse, failing_check, coarse)]
        with watched(scene, castings[0]):
            self.ask(scene, count)
            at_some_step(scene, castings[0], len(undisturbed(REAL, coarse()).steps))
            if workers := scene.job_workers():
                signal_process(scene.chance.choice(workers), signal.SIGKILL)
        self.look(scene, count)
        count.add(judge(scene, self.patience))
        scene.client.ask("DeleteStudy", id=self.study.id)
        for job_id in castings:
            scene.client.ask("DeleteJob", id=job_id)
        scene.acknowledged.clear()

    @staticmethod
    def ask(scene, count):
        """Two draft queries; the second is taken back on its way."""
        for last in (10 ** 6, scene.chance.randint(1, 200)):
            call = scene.client.ask("QueryButtCurl", case=varied(coarse(), count.tried))
            with contextlib.suppress(grpc.RpcError):
                for answer in call:
                    if answer.step.step >= last:
                        call.cancel()


@contextlib.contextmanager
def watched(scene, job_id):
    """A watch by the command line client, which is killed."""
    client = subprocess.Popen([*TIED, os.path.join(BIN, "dccast"), "--server", scene.daemon.address,
                               "watch", job_id], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        pause(scene.chance, 0.5)
        yield
    finally:
        client.kill()
        client.wait()


def held_by(process):
    """Megabytes and open descriptors."""
    return memory_of(process, "VmRSS") / 1e6, len(os.listdir(f"/proc/{process}/fd"))
