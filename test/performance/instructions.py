#!/usr/bin/python3
"""Instructions a call, counted by valgrind's callgrind: exact, whatever else the machine does.

    instructions.py PROGRAM [--write]       PROGRAM: the test program `instructions`

Compares with instructions.csv: fails if one has grown by more than 2 %, or if an operation takes more than LONGEST times
that of another chain. Says which have fallen by more, so that the file may be renewed; --write does that. Where the
compiler or the kernel is another one than there, counts do not compare: then it is skipped, with exit status 77.
"""
import csv
import os
import sys

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../support"))
import callgrind  # noqa: E402

FILE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "instructions.csv")
MOST = 0.02
# operation; chain, links; the other chain, its links; times
LONGEST = [("evaluation", "one rotor", 10, "bare", 10, 1.6)]
LONGEST += [(operation, "on a cart", n + 1, "one rotor", n, 1.3) for operation in ("evaluation", "factor") for n in (10, 100, 1000)]
LONGEST += [("evaluation", "held tip", n, "one rotor", n, 2.2) for n in (3, 10, 100, 1000)]
SKIPPED = 77


def counts(program):
    """Who made the program and what it runs; and (operation, chain, links) with the instructions of one call."""
    output, profiles = callgrind.run([program], inside="counted", each_call=True)
    build, *lines = output.splitlines()
    if len(lines) != len(profiles):
        sys.exit(f"{len(lines)} operations, but {len(profiles)} counts")
    found = {}
    for (operation, chain, links, times), profile in zip(csv.reader(lines), profiles):
        found[operation, chain, int(links)] = profile.total / int(times)
    return build, found


def write(build, found):
    with open(FILE, "w", newline="") as file:
        file.write(f"# {build}\n")
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["operation", "chain", "links", "instructions"])
        rows.writerows([*key, round(count)] for key, count in found.items())


def committed():
    with open(FILE, newline="") as file:
        build = file.readline()[2:].rstrip("\n")
        rows = csv.DictReader(file)
        return build, {(row["operation"], row["chain"], int(row["links"])): int(row["instructions"]) for row in rows}


def compare(found, before):
    """Prints every count; returns those that have grown and those that have fallen."""
    grown, fallen = [], []
    print(f"{'operation':16}{'chain':20}{'links':>6}{'a call':>12}{'a link':>10}{'change':>9}")
    for key, count in found.items():
        change = count / before[key] - 1 if key in before else float("inf")
        operation, chain, links = key
        print(f"{operation:16}{chain:20}{links:6}{count:12.0f}{count / links:10.1f}{change:+9.2%}")
        if change > MOST:
            grown.append(key)
        elif change < -MOST:
            fallen.append(key)
    for operation, chain, links, other, its_links, most in LONGEST:
        ratio = found[operation, chain, links] / found[operation, other, its_links]
        print(f"{operation}: {chain}, {links} links, takes {ratio:.3f} times as many as {other}, {its_links}; at most {most}")
        if ratio > most:
            grown.append((operation, chain, links, f"more than {most} times {other}"))
    return grown, fallen


def main():
    if len(sys.argv) < 2 or sys.argv[2:] not in ([], ["--write"]):
        sys.exit(__doc__)
    build, found = counts(sys.argv[1])
    if sys.argv[2:]:
        write(build, found)
        return 0
    build_before, before = committed()
    if build != build_before:
        print(f"Skipped: this is {build}; the counts of instructions.csv are for {build_before}.")
        return SKIPPED
    grown, fallen = compare(found, before)
    for key in fallen:
        print("fewer instructions:", *key, "- instructions.py --write keeps that")
    for key in grown:
        print("MORE INSTRUCTIONS:", *key)
    return 1 if grown or set(before) - set(found) else 0


if __name__ == "__main__":
    sys.exit(main())
