"""Programs under valgrind's callgrind: how many instructions they execute, and where."""
import collections
import glob
import os
import re
import subprocess
import tempfile

Profile = collections.namedtuple("Profile", "total where")
Profile.__doc__ = "Instructions in all, and a Counter of them by (function, source file): inlined code by its own."

POSITION = re.compile(r"(fl|fi|fe|fn|cfn)=\((\d+)\)(?: (.*))?")


def read(path):
    """One file of callgrind's, see its manual, section "Callgrind Format Specification"."""
    names = {"file": {}, "function": {}}

    def named(kind, number, name):
        if name:
            names[kind][number] = name
        return names[kind][number]

    where = collections.Counter()
    function = file = None
    follows_call = False
    with open(path) as lines:
        for line in lines:
            position = POSITION.match(line)
            if position:
                key, number, name = position.groups()
                if key == "cfn":
                    named("function", number, name)
                elif key == "fn":
                    function = named("function", number, name)
                else:
                    file = named("file", number, name)
            elif line.startswith(("cfi=", "cfl=")):
                number, name = re.match(r"\((\d+)\)(?: (.*))?", line[4:]).groups()
                named("file", number, name)
            elif line.startswith("calls="):
                follows_call = True
            elif line[:1].isdigit() or line[:1] in "+-*":
                cost = line.split()[1:]
                if not follows_call and cost:  # else it is what was spent in the function called
                    where[function, os.path.basename(file)] += int(cost[0])
                follows_call = False
    return Profile(sum(where.values()), where)


def prefix(inside, out):
    """For a command: counts into the file `out` while function `inside` is running, whose name may end in *."""
    return ["valgrind", "--tool=callgrind", "--toggle-collect=" + inside, "--callgrind-out-file=" + out]


def run(command, inside, each_call=False):
    """What the program wrote, and its profile inside that function; or a list of profiles, one for each call of it.

    Then `inside` must be the whole name.
    """
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "out")
        dumps = ["--dump-after=" + inside] if each_call else []
        result = subprocess.run([*prefix(inside, out), *dumps, *command], stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, universal_newlines=True, check=False)
        if result.returncode != 0:
            raise RuntimeError(f"{command}: exit status {result.returncode}\n{result.stderr}")
        if not each_call:
            return result.stdout, read(out)
        paths = sorted(glob.glob(out + ".*"), key=lambda path: int(path.rsplit(".", 1)[1]))
        if not paths:
            raise RuntimeError(f"{command}: no function is called {inside}")
        return result.stdout, [read(path) for path in paths]
