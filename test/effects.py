#!/usr/bin/python3
"""What each effect costs, as a table in Markdown: times, and instructions by callgrind.

    effects.py PROGRAM [REPETITIONS]        PROGRAM: the study `effects`, built by hand; REPETITIONS: 101

All rows of a length take turns within one run; given are medians of their ratios to the bare chain.
"""
import csv
import subprocess
import sys

import callgrind

TITLES = {
    "evaluation": "An evaluation: time and instructions of the bare chain, and of the others as multiples of those",
    "tick": "A tick of 5 ms, five steps of rk4, likewise",
    "message": "A message, filled and serialized, as a part of the bare chain's tick",
}


def measure(program, repetitions):
    """(table, effect, links): (ns, ratio)"""
    output = subprocess.run([program, str(repetitions)], stdout=subprocess.PIPE, universal_newlines=True, check=True)
    return {(table, effect, int(links)): (float(ns), float(ratio))
            for table, effect, links, ns, ratio in csv.reader(output.stdout.splitlines())}


def count(program):
    """(table, effect, links): instructions of a call"""
    output, profiles = callgrind.run([program, "0"], inside="counted", each_call=True)
    return {(table, effect, int(links)): profile.total / int(times)
            for (table, effect, links, times), profile in zip(csv.reader(output.splitlines()), profiles)}


def cells(key, times, counts):
    """Of one row, at one length."""
    table, effect, links = key
    ns, ratio = times[key]
    if effect == "bare":
        return (f"{ns:.0f} ns" if ns < 1000 else f"{ns / 1000:.3g} µs") + f" | {counts[key]:,.0f}"
    bare = counts["tick" if table == "message" else table, "bare", links]
    return f"{ratio:.2f} | {counts[key] / bare:.2f}"


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    times = measure(sys.argv[1], sys.argv[2] if len(sys.argv) == 3 else 101)
    counts = count(sys.argv[1])
    lengths = list(dict.fromkeys(links for _, _, links in times))
    for table, title in TITLES.items():
        effects = list(dict.fromkeys(effect for of, effect, _ in times if of == table))
        if not effects:
            continue
        print(f"\n{title}:\n")
        print("| | " + " | ".join(f"n = {links} | instructions" for links in lengths) + " |")
        print("|---|" + "--:|--:|" * len(lengths))
        for effect in effects:
            row = [cells((table, effect, links), times, counts) for links in lengths]
            print(f"| {effect} | " + " | ".join(row) + " |")


if __name__ == "__main__":
    main()
