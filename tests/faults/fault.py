"""What every fault is: a name, how often it is tried, and one scene of it."""
import re

from cases import FAKE
from oracle import Count, judge
from scene import Scene


class Fault:
    """A subclass's docstring says in one line what is done; table and docs show it."""
    short = 1          # tries of the short form
    long = 10          # and of the long one
    at_once = 1        # tries in one scene, one after another
    seconds = 20.0     # no further scene begins after so long; times eight in the long form
    patience = 60.0    # seconds until every job must have ended
    worker = FAKE
    settings = {}
    options = ()       # of the daemon's command line

    @classmethod
    def name(cls):
        return re.sub(r"(?<=[a-z])(?=[A-Z])", "-", cls.__name__).lower()

    @classmethod
    def says(cls):
        return cls.__doc__.strip().splitlines()[0].rstrip(".")

    def attempt(self, chance, most):
        """One scene. Returns a Count with how many tries it made.

        chance: random.Random of this scene; most: tries that are still wanted.
        """
        count = Count()
        with self.scene(chance) as scene:
            self.begin(scene)
            for _ in range(4 * self.at_once):
                if count.tried < min(most, self.at_once):
                    count.tried += self.disturb(scene, count) is not False
            self.look(scene, count)
            count.add(judge(scene, self.patience))
            self.look_back(scene, count)
        return count

    def scene(self, chance):
        return Scene(chance, self.worker, options=self.options, **self.settings)

    def begin(self, scene):
        """Submits what is to be disturbed."""

    def disturb(self, scene, count):
        """One try. Returns False when there was nothing to disturb at this instant."""
        raise NotImplementedError

    def look(self, scene, count):
        """What must be true before the jobs have ended, besides what the oracle asks."""

    def look_back(self, scene, count):
        """And after."""
