#!/usr/bin/python3
"""No object file for AVX2 or AVX-512 exports a function that another file may have, too.

    kernel_symbols_test.py NM OBJECT...

The linker keeps one of several copies of an inline function or template instance. If it kept one that was compiled for
AVX2 or AVX-512, the program would crash on a CPU without it. So those files may export their kernels alone.
"""
import re
import subprocess
import sys

KERNEL = re.compile(r"planar_chain::simd::(kernel|vectors|shortChains|columns)Avx(2|512)")
POINTER = re.compile(r"DW\.ref\.\w+")  # to a function of the C++ library: no code


def shared(nm, file):
    """The exported symbols of an object file that are no kernels."""
    lines = subprocess.run([nm, "--demangle", "--defined-only", "--extern-only", "--portability", file], check=True,
                           stdout=subprocess.PIPE, universal_newlines=True).stdout.splitlines()
    names = [re.sub(r" \w( [0-9a-f]+)*$", "", line.rstrip()) for line in lines]
    if not any(KERNEL.fullmatch(name) for name in names):
        sys.exit(f"{file} exports no kernel")
    return [name for name in names if not KERNEL.fullmatch(name) and not POINTER.fullmatch(name)]


nm, *files = sys.argv[1:]
found = [f"{file} exports {name}" for file in files for name in shared(nm, file)]
print(*found, sep="\n")
sys.exit(1 if found or not files else 0)
