"""kill -9 at random instants: nothing acknowledged is lost, nothing is done twice."""
import os
import signal
import subprocess
import threading

from cases import COARSE, FAKE, REAL, coarse, failing_check, fake, shipped
from fault import Fault
from oracle import Count, judge, undisturbed
from scene import TIED, Scene, pause, signal_process

TINY = ("steps=3", "steps=25 checkpoint=7")
PATIENT = {"worker_restarts": 100}  # so many kills in one run are no fault of the case


class Kill(Fault):
    """Keeps real castings running and kills at random instants of their life."""
    kills_in_one_scene = 6
    seconds = 30.0

    def attempt(self, chance, most):
        count = Count()
        life = undisturbed(REAL, coarse()).seconds
        with Scene(chance, REAL, **PATIENT) as scene:
            while count.tried < min(most, self.kills_in_one_scene):
                self.keep_busy(scene)
                pause(chance, life)
                count.tried += self.kill(scene)
            count.add(judge(scene))
        return count

    @staticmethod
    def keep_busy(scene):
        unfinished = sum(not scene.ended(job_id) for job_id in scene.acknowledged)
        for _ in range(2 - unfinished):
            scene.submit(scene.chance.choice((coarse, failing_check))())

    def kill(self, scene):
        """Returns how many were killed: 0 when there was nobody at this instant."""
        raise NotImplementedError


class KillWorker(Kill):
    """kill -9 of a worker in the middle of a real casting."""
    short, long = 5, 70

    def kill(self, scene):
        workers = scene.job_workers()
        return int(bool(workers) and signal_process(scene.chance.choice(workers), signal.SIGKILL))


class KillDaemon(Kill):
    """kill -9 of the daemon while real castings run; started again."""
    short, long = 4, 60

    def kill(self, scene):
        scene.kill_daemon()
        scene.come_back()
        return 1


class KillEverything(Kill):
    """kill -9 of workers, client and daemon at once; daemon started again."""
    short, long = 3, 40

    def kill(self, scene):
        client = submitting_client(scene, case_file(scene))
        pause(scene.chance, 0.05)
        for worker in scene.job_workers():
            signal_process(worker, signal.SIGKILL)
        scene.daemon.process.send_signal(signal.SIGKILL)
        end(client)
        scene.kill_daemon()
        scene.come_back()
        scene.send_again()
        return 1


class KillClient(Fault):
    """kill -9 of the command line client while it submits and watches; the same request again."""
    short, long = 5, 40
    seconds = 15.0

    def attempt(self, chance, most):
        count = Count()
        with Scene(chance, REAL) as scene:
            for _ in range(min(most, 5)):
                client = submitting_client(scene, case_file(scene))
                pause(chance, 0.4)
                end(client)
                count.tried += 1
                scene.send_again()
            count.add(judge(scene))
        return count


class KillUnderLoad(Fault):
    """kill -9 of the daemon while a client submits one job after another, tiny ones."""
    short, long = 3, 30
    seconds = 20.0
    jobs = 15  # for each kill

    def attempt(self, chance, most):
        count = Count()
        with Scene(chance, FAKE) as scene:
            for _ in range(min(most, 3)):
                self.submit_and_kill(scene)
                count.tried += 1
            count.add(judge(scene))
        return count

    def submit_and_kill(self, scene):
        killed = threading.Timer(scene.chance.uniform(0.0, 0.5),
                                 scene.daemon.process.send_signal, (signal.SIGKILL,))
        killed.start()
        for _ in range(self.jobs):
            scene.submit(fake(scene.chance.choice(TINY)))
        killed.join()
        scene.kill_daemon()
        scene.come_back()
        scene.send_again()


def case_file(scene):
    """Writes the coarse case for the command line client. Returns its path."""
    path = os.path.join(scene.folder, "case.toml")
    with open(path, "w", encoding="utf-8") as file:
        file.write(shipped(*COARSE))
    return path


def submitting_client(scene, path):
    """The real client with a request_id of its own; whether it was heard, nobody knows."""
    expected = scene.next_request(coarse(), None)
    expected.file = path
    scene.unsure.append(expected)
    return subprocess.Popen([*TIED, *scene.submit_command(expected), "--watch"],
                            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def end(process):
    process.kill()
    process.wait()
