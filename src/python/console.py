"""The commands of an installation by pip: each becomes the tool of its name."""

import os
import pathlib
import signal
import sys


def start():
    tool = pathlib.Path(__file__).parent / "lib/planar_chain" / pathlib.Path(sys.argv[0]).name
    with open(tool, "rb") as file:
        python = [sys.executable] if file.read(2) == b"#!" else []
    for ignored in (signal.SIGPIPE, signal.SIGXFSZ):  # by Python; a tool would inherit that
        signal.signal(ignored, signal.SIG_DFL)
    command = [*python, str(tool), *sys.argv[1:]]
    os.execv(command[0], command)
