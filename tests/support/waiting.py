"""How tests wait. Every other sleep of a test says beside it why nothing can be waited for."""
import os
import time

# Above 1 where the programs are slowed down: by sanitizers, tests/run.
WAIT_FACTOR = float(os.environ.get("DCCAST_WAIT_FACTOR", "1"))


def until(condition, seconds, every_s=0.01):
    """Waits for what another process brings about, and returns it; fails when it does not come in time."""
    end = time.monotonic() + seconds * WAIT_FACTOR
    while not (found := condition()):
        if time.monotonic() > end:
            raise AssertionError("waited in vain")
        time.sleep(every_s)
    return found


def stays(condition, seconds):
    """Fails as soon as a condition does not hold: for a time in which nothing may come."""
    for _ in turns(seconds, 0.02):
        if not condition():
            raise AssertionError(f"was so for less than {seconds} s")


def turns(seconds, pause_s):
    """Turns of a load, or of a look at it, until the time is over, with a pause after each."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        yield
        time.sleep(pause_s)


def pause(chance, most, least=0.0):
    """A random time [s], so that what follows happens at a random instant."""
    time.sleep(chance.uniform(least, most))


def wait_for_clock(due):
    """Until the clock (time.monotonic) shows a time: for a sender with a pace of its own."""
    time.sleep(max(0.0, due - time.monotonic()))
