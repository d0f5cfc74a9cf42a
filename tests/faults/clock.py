"""The wall clock is no friend: it jumps, and nothing may depend on it."""
import os

from cases import REAL, coarse, failing_check
from fault import Fault
from oracle import Count, judge, undisturbed
from scene import Scene, pause
from support import BIN


class ClockJumps(Fault):
    """The wall clock of daemon and workers jumps by up to a year, back and forth, while they run"""
    short, long = 2, 20
    year = 365 * 86400

    def attempt(self, chance, most):
        count = Count()
        life = undisturbed(REAL, coarse()).seconds
        with Scene(chance, REAL, prepare=self.preload) as scene:
            scene.submit(coarse())
            scene.submit(failing_check())
            for _ in range(min(most, 4)):
                pause(chance, life / 3)
                self.jump(chance.randint(-self.year, self.year))
                scene.submit(coarse())
                count.tried += 1
            count.add(judge(scene))
        return count

    def preload(self, scene):
        self.clock = os.path.join(scene.folder, "clock")
        self.jump(0)
        scene.daemon.through = ("env", f"LD_PRELOAD={os.path.join(BIN, 'jumping_clock.so')}",
                                f"DCCAST_FAULT_CLOCK={self.clock}")

    def jump(self, seconds):
        with open(self.clock + ".next", "w", encoding="ascii") as file:
            file.write(str(seconds))
        os.rename(self.clock + ".next", self.clock)
