"""What every fault is: a name, how often it is tried, and one try."""
import re


class Fault:
    """A subclass's docstring says in one line what is done; the table and docs show it."""
    short = 1          # tries of the short form
    long = 10          # and of the long one
    seconds = 20.0     # no further try begins after so long; times eight in the long form

    @classmethod
    def name(cls):
        return re.sub(r"(?<=[a-z])(?=[A-Z])", "-", cls.__name__).lower()

    @classmethod
    def says(cls):
        return cls.__doc__.strip().splitlines()[0].rstrip(".")

    def attempt(self, chance, most):
        """One try, or a few in one scene. Returns a Count with how many it made.

        chance: random.Random of this try; most: tries that are still wanted.
        """
        raise NotImplementedError
