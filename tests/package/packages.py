"""The packages of the build tree, made for a test."""
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tests/support"))
BUILD = pathlib.Path(os.environ.get("DCCAST_BUILD", ROOT / "build/release"))


def run(*command, **rest):
    """Runs a program that must succeed. Returns what it prints."""
    done = subprocess.run([str(word) for word in command], text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, check=False, **rest)
    if done.returncode:
        raise AssertionError(f"{command} ended with {done.returncode}:\n{done.stdout}")
    return done.stdout


def made(folder, version):
    """Packs what is built. Returns the packages' files by their name."""
    run(ROOT / "deploy/package", "--built", BUILD, folder, version, timeout=240)
    return {path.name.split("_")[0]: path for path in pathlib.Path(folder).glob("*.deb")}
