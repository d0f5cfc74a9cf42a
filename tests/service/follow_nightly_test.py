#!/usr/bin/python3
"""What following withstands for long: kills of everything, and half a day of castings one after another."""
import os
import random
import signal
import subprocess

from dccast.v1 import job_pb2
from follow_test import FollowTest, table
from real_run_test import physics
from support import main
from waiting import pause, until

KILLS = 50
CASTINGS_END = 145  # s of casting, after a hold of 60 s
HALF_A_DAY = 43200  # s of casting


class Kills(FollowTest):
    settings = {**FollowTest.settings, "workers__restarts": 100}

    def test_kills_of_client_daemon_and_worker_lose_nothing_and_use_nothing_twice(self):
        lines = table(end=CASTINGS_END).splitlines(keepends=True)
        path = self.in_folder("readings.csv")
        with open(path, "w", encoding="utf-8") as file:
            file.writelines(lines)
        self.ended(self.dccast("follow", self.case_file(CASTINGS_END), "--readings", path))
        expected = physics(self.steps_at_end(self.newest_job()))

        shots = random.Random(12)
        first = 20
        with open(path, "w", encoding="utf-8") as file:
            file.writelines(lines[:first])
            file.flush()
            client = self.dccast("follow", self.case_file(CASTINGS_END), "--readings", path, "--growing")
            until(lambda: len(self.jobs()) == 2, 30)
            job_id = self.newest_job()
            killed = {"client": 0, "daemon": 0, "worker": 0, "all": 0}
            for shot in range(KILLS):
                file.writelines(lines[first + 3 * shot:first + 3 * (shot + 1)])
                file.flush()
                pause(shots, 0.6, 0.05)
                target = shots.choice(sorted(killed))
                killed[target] += 1
                client = self.kill(target, client, job_id, path)
            file.writelines(lines[first + 3 * KILLS:])
            file.flush()
            steps = self.steps_at_end(job_id)
        client.communicate(timeout=60)

        self.assertEqual(physics(steps), expected)
        self.assertEqual(self.append(job_id).number, len(lines) - 1)
        print(f"\n{KILLS} kills: {killed}; {self.client.job(job_id).attempts} attempts")

    def kill(self, target, client, job_id, path):
        """Kills and starts again. Returns the client, which may be another one."""
        if target in ("worker", "all"):
            for worker in self.daemon.worker_processes():
                os.kill(worker, signal.SIGKILL)
        if target in ("daemon", "all"):
            self.daemon.kill()
            self.restart()
        if target not in ("client", "all"):
            return client
        client.kill()
        client.communicate()
        return self.dccast("follow", "--job", job_id, "--readings", path, "--growing")

    def jobs(self):
        return self.client.ask("ListJobs").jobs

    def newest_job(self):
        return self.jobs()[0].id


class HalfADay(FollowTest):
    def test_castings_one_after_another_leave_no_memory_and_no_disk_but_their_records(self):
        path = self.write_file("readings.csv", table(end=CASTINGS_END))
        words = self.client_command("follow", self.case_file(CASTINGS_END), "--set", "quality=draft",
                                    "--readings", path)

        castings = HALF_A_DAY // (CASTINGS_END + 60) + 1
        memory, disk, files = [], [], []
        for _ in range(castings):
            subprocess.run(words, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                           timeout=120)
            memory.append(self.resident_bytes())
            disk.append(self.bytes_of_newest_job())
            files.append(len(os.listdir(f"/proc/{self.daemon.process.pid}/fd")))

        tenth = castings // 10
        mean = lambda values: sum(values) / len(values)
        before, after = mean(memory[tenth:2 * tenth]), mean(memory[-tenth:])
        print(f"\n{castings} castings: memory of the daemon {before / 1e6:.1f} and {after / 1e6:.1f} MB, "
              f"{disk[0]} and {disk[-1]} bytes a job, {files[tenth]} and {files[-1]} open files")
        self.assertLess(after, 1.1 * before)
        self.assertLess(abs(disk[-1] - disk[0]), 0.05 * disk[0])
        self.assertLessEqual(files[-1], files[tenth] + 2)

    def resident_bytes(self):
        with open(f"/proc/{self.daemon.process.pid}/statm", encoding="ascii") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")

    def bytes_of_newest_job(self):
        job = self.client.ask("ListJobs", page_size=1).jobs[0]
        self.assertEqual(job.state, job_pb2.SUCCEEDED)
        folder = self.in_folder("data", "jobs", job.id)
        return sum(os.path.getsize(os.path.join(folder, name)) for name in os.listdir(folder))


if __name__ == "__main__":
    main()
