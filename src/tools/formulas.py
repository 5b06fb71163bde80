#!/usr/bin/python3
"""Writes the equations of motion M q'' = f of a scene as formulas: a LaTeX document, or functions in C, MATLAB or Python.

The functions give M, f and q'' of a state, and with --linearize A and B of dx/dt = A x + B dtau. Exit status: 0 done; 1 it
cannot be written to the file; 2 bad arguments, a scene with faults, or one that no formula describes."""

from program import Parser, put, run  # isort: skip

import argparse
import os
import pathlib
import sys
import warnings

from files import BadOutput, require_outputs, save_picture, scene_file, words_of, writing
try:
    from planar_chain import NoFormula, Refused, Scene, formulas
    from planar_chain.symbolic.chain import read
    from planar_chain.symbolic.code import name_from
    from planar_chain.symbolic.code_c import c_code, c_header
    from planar_chain.symbolic.code_matlab import matlab_code
    from planar_chain.symbolic.code_python import python_code
    from planar_chain.symbolic.document import Document
except ImportError as missing:
    sys.exit(f"formulas: {missing}")

OWN = "Written by `formulas` of planar_chain"  # in what code.py begins with
CODES = {"c": c_code, "matlab": matlab_code, "python": python_code}


def arguments():
    parser = Parser(prog="formulas", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", metavar="SCENE", help="a YAML file, a URDF, or the name of a scene that ships")
    parser.add_argument("--format", required=True, choices=["latex", *CODES], help="what is written")
    parser.add_argument("--numbers", action="store_true", help="the scene's numbers in place of letters")
    parser.add_argument("--linearize", action="store_true", help="also A and B")
    parser.add_argument("--output", metavar="FILE", help="where it is written; functions are named after it (default, or -: standard "
                                                         "output, named after the scene). FILE.c has the header FILE.h beside it, "
                                                         "a page in latex the picture "
                                                         "FILE_chain.pdf beside it, FILE without its ending")
    given = parser.parse_args()
    given.output = None if given.output == "-" else given.output
    return given


def scene_from(path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # initial angles that are moved to close a chain
        return Scene.from_file(path)


def picture_of(page):
    """The file of the picture beside a page."""
    return page.with_name(page.stem + "_chain.pdf")


def header_of(given):
    """The header beside a file FILE.c, or None."""
    return pathlib.Path(given.output).with_suffix(".h") if given.format == "c" and given.output and given.output.endswith(".c") else None


def require_own(beside, what, page, words, where):
    """Raises BadOutput if there is a file `beside` that is not that of the page: these words are not in the file `where`."""
    is_own = where.is_file() and words in where.read_text(encoding="utf-8", errors="replace")
    if beside.exists() and not is_own:
        raise BadOutput(f"--output: expected no file {beside}, which would be the {what} of {page}, got one")


def results_of(given):
    """The text to be written, and what stands beside it: a picture, the text of a header, or None."""
    scene = scene_from(given.scene)
    of = formulas(scene)
    of = of.with_numbers() if given.numbers else of
    source = os.path.basename(given.scene)
    output = pathlib.Path(given.output or pathlib.Path(given.scene).name)
    if given.format != "latex":
        about = of, name_from(output.stem), source, given.linearize
        return CODES[given.format](*about), c_header(*about) if header_of(given) else None
    picture = None
    if given.output:
        from planar_chain.symbolic.sketch import draw  # pylint: disable=import-outside-toplevel  # matplotlib takes a second
        picture = draw(read(scene))
    return Document(of, source, given.output and picture_of(output).name, given.linearize).text(), picture


def main():
    given = arguments()
    try:
        if given.format == "matlab" and given.output and name_from(pathlib.Path(given.output).stem) + ".m" != os.path.basename(given.output):
            raise NoFormula(f"--output: expected a function's name that ends in .m, as MATLAB does, got {given.output}")
        require_outputs([("--output", given.output)], [scene_file(given.scene)])
        if given.format == "latex" and given.output:
            page = pathlib.Path(given.output)
            require_own(picture_of(page), "picture", page, f"{{{picture_of(page).name}}}", page)
        header = header_of(given)
        if header:
            require_own(header, "header", given.output, OWN, header)
        text, beside = results_of(given)
    except (OSError, UnicodeDecodeError) as problem:
        raise NoFormula(words_of(problem)) from problem
    if beside and not header:
        save_picture(beside, str(picture_of(pathlib.Path(given.output))), bbox_inches="tight", pad_inches=0.02)
    if given.output:
        with writing(given.output), open(given.output, "w", encoding="utf-8", errors="surrogateescape") as file:
            file.write(text)
        text = f"written to {given.output}{f' and {header}' if header else ''}\n"
    if header:
        with writing(header), open(header, "w", encoding="utf-8", errors="surrogateescape") as file:
            file.write(beside)
    put(text)
    return 0


if __name__ == "__main__":
    sys.exit(run(main, (BadOutput, NoFormula, Refused)))
