"""A tool in Python as a program: Ctrl-C, --help, standard output, exit status. It is imported first."""

import signal

INTERRUPTIBLE = signal.getsignal(signal.SIGINT) is signal.default_int_handler
if INTERRUPTIBLE:
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # while modules load: run() can end in words

# pylint: disable=wrong-import-position
import argparse
import os
import sys

for fd, name in enumerate(("stdin", "stdout", "stderr")):
    if getattr(sys, name) is None:  # closed: no file of the run takes its number, and with it what is meant for the other
        os.open(os.devnull, os.O_RDONLY if fd else os.O_WRONLY)
sys.stderr = sys.stderr or open(os.devnull, "w", encoding="utf-8")  # pylint: disable=consider-using-with

from files import words_of, writing
from user_input import read_number, read_whole


def say(text):
    """One line, in place of the progress."""
    print(("\r\033[K" if sys.stderr.isatty() else "") + f"{os.path.basename(sys.argv[0])}: {text}", file=sys.stderr)


def put(text):
    """Writes to standard output. What Python's own could not write, it would try again at the end."""
    with writing("standard output"), open(1, "w", encoding="utf-8", errors="surrogateescape", closefd=False) as out:
        out.write(text)


class Parser(argparse.ArgumentParser):
    def __init__(self, **how):
        super().__init__(**how)
        self.register("type", float, read_number)
        self.register("type", int, read_whole)

    def add_operating_point(self):
        """Options whose values linearize() takes."""
        self.add_argument("--tau", metavar="A,B,…", help="torques in the joints, N m, that act at --q beside all else; `holding`: those that "
                                                         "hold the pose. Then --q is by default the scene's initial pose")
        self.add_argument("--friction", choices=["acts", "slips"], default="acts",
                          help="slips: takes joints that may stick for ones that slip, without friction (default: acts)")

    def print_help(self, file=None):
        put(self.format_help())


def run(main, refused, failed=(), so_far=lambda: ""):
    """Returns the status of main(). What it raises becomes a line: `refused` ends with 2, Ctrl-C with 130, `failed` and errors of the
    system with 1. so_far(): what is added to the last two."""
    try:
        if INTERRUPTIBLE:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        return main()
    except refused as problem:
        say(problem)
        return 2
    except KeyboardInterrupt:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # a second one also ends what waits at the exit, such as Dask
        say("interrupted" + so_far())
        return 130
    except (*failed, OSError, MemoryError) as problem:
        say((words_of(problem) or "there is not enough memory") + so_far())
        return 1
