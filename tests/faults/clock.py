"""The wall clock is no friend: it jumps, and nothing may depend on it."""
import os

from cases import REAL, coarse, failing_check
from fault import Fault
from oracle import undisturbed
from scene import Scene, preloading
from waiting import pause


class ClockJumps(Fault):
    """The wall clock of daemon and workers jumps by up to a year, back and forth"""
    short, long = 2, 20
    at_once = 4
    year = 365 * 86400

    def scene(self, chance):
        return Scene(chance, REAL, prepare=self.preload)

    def begin(self, scene):
        scene.submit(coarse())
        scene.submit(failing_check())

    def disturb(self, scene, count):
        pause(scene.chance, undisturbed(REAL, coarse()).seconds / 3)
        self.jump(scene.chance.randint(-self.year, self.year))
        scene.submit(coarse())

    def preload(self, scene):
        self.clock = os.path.join(scene.folder, "clock")
        self.jump(0)
        scene.daemon.through = preloading("jumping_clock.so", DCCAST_FAULT_CLOCK=self.clock)

    def jump(self, seconds):
        with open(self.clock + ".next", "w", encoding="ascii") as file:
            file.write(str(seconds))
        os.rename(self.clock + ".next", self.clock)
