"""The job store is missing, empty or old, or the folder is restored: no result goes with it."""
import os
import shutil
import subprocess

from cases import fake
from damage import OLD_STORE, Damage
from fault import Fault
from waiting import pause

STORE = ("jobs.sqlite", "jobs.sqlite-wal", "jobs.sqlite-shm")


def remove_store(scene, names=STORE):
    for name in names:
        if os.path.exists(scene.data(name)):
            os.remove(scene.data(name))


class StoreDamage(Damage):
    """The store of a copied template is replaced; its folders must survive it."""
    short, long = 1, 10


class StoreMissing(StoreDamage):
    """jobs.sqlite and what belongs to it removed"""

    def damage(self, chance, scene, there):
        remove_store(scene)


class StoreEmpty(StoreDamage):
    """jobs.sqlite of 0 bytes"""

    def damage(self, chance, scene, there):
        remove_store(scene)
        with open(scene.data("jobs.sqlite"), "wb"):
            pass


class StoreReplaced(StoreDamage):
    """jobs.sqlite or a file of it replaced by a folder, a link or a named pipe"""
    short, long = 3, 18
    kinds = (os.mkdir, os.mkfifo, lambda path: os.symlink(path + ".elsewhere", path))

    def damage(self, chance, scene, there):
        path = scene.data(chance.choice(STORE))
        if os.path.exists(path):
            os.remove(path)
        chance.choice(self.kinds)(path)

    def judge(self, scene, there, count, torn):
        super().judge(scene, there, count, torn)
        if any(name.endswith(".elsewhere") for name in os.listdir(scene.data())):
            count.found("wrong", "it was written through the link")


class StoreWithoutWal(StoreDamage):
    """jobs.sqlite after kill -9, without its -wal"""

    def damage(self, chance, scene, there):
        remove_store(scene, STORE[1:])


class StoreFromOldBackup(StoreDamage):
    """jobs.sqlite from a backup made before most jobs were submitted"""

    def damage(self, chance, scene, there):
        remove_store(scene)
        os.replace(scene.data(OLD_STORE), scene.data("jobs.sqlite"))

    def start(self, scene, count):
        """What the daemon puts aside as unknown comes back by the documented command."""
        if not super().start(scene, count):
            return False
        scene.kill_daemon()
        try:
            scene.state_command("check", "--repair")
        except RuntimeError as failed:
            count.found("wrong", str(failed))
        scene.come_back()
        return True


class EightCastings(Fault):
    """Short ones and long ones, of which some have ended."""

    def begin(self, scene):
        for _ in range(8):
            scene.submit(fake(scene.chance.choice(("steps=20", "steps=60 checkpoint=7 sleep_ms=10"))))
        pause(scene.chance, 0.5)


class FolderRestored(EightCastings):
    """The whole folder restored from a backup that was made while jobs ended, ran and waited"""
    short, long = 1, 20

    def disturb(self, scene, count):
        backup = os.path.join(scene.folder, "backup")
        scene.state_command("backup", "--to", backup)
        scene.kill_daemon()
        shutil.rmtree(scene.data())
        scene.state_command("restore", "--from", backup)
        scene.come_back()


class StoreRemovedFromWorkingDaemon(EightCastings):
    """jobs.sqlite removed under the working daemon, which is killed later"""
    short, long = 1, 10

    def disturb(self, scene, count):
        remove_store(scene)
        pause(scene.chance, 0.5)
        scene.kill_daemon()
        remove_store(scene)
        scene.come_back()


class FolderMoved(EightCastings):
    """The folder moved to another path, without the store"""
    short, long = 1, 10

    def disturb(self, scene, count):
        scene.kill_daemon()
        remove_store(scene)
        moved = os.path.join(scene.folder, "moved")
        os.rename(scene.data(), moved)
        scene.daemon.settings["data_directory"] = moved
        scene.come_back()


class TwoDaemons(Fault):
    """A second daemon on the folder of a running one: it ends with a reason"""
    short, long = 1, 10

    def begin(self, scene):
        for _ in range(4):
            scene.submit(fake("steps=40 sleep_ms=5"))

    def disturb(self, scene, count):
        second = subprocess.run(scene.daemon.command(), capture_output=True, text=True, timeout=20,
                                check=False)
        if second.returncode != 4 or "another dccastd" not in second.stderr:
            count.found("wrong", f"the second ended with {second.returncode}: {second.stderr}")
