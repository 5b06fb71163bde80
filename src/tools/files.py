"""The files of a tool: which it reads and writes, and why it cannot."""

import contextlib
import io
import os
import pathlib
import re
import stat
import sys
import warnings

sys.path.append(str(pathlib.Path(sys.argv[0]).absolute().parent.parent / "python3/dist-packages"))  # where setup.bash is not sourced
PICTURES = ".png", ".svg", ".pdf"
SHIPPED = pathlib.Path(sys.argv[0]).absolute().parent / "../../share/planar_chain/config/scenes"


class BadOutput(ValueError):
    """Which option, what was expected, what was found."""


def words_of(problem):
    """An error of the system without its number."""
    if not isinstance(problem, OSError) or not problem.strerror:
        return str(problem)
    return problem.strerror if problem.filename is None else f"{os.fsdecode(problem.filename)}: {problem.strerror}"


@contextlib.contextmanager
def writing(name):
    """An error within names the file."""
    try:
        yield
    except OSError as problem:
        raise OSError(f"cannot write {name}: {problem.strerror}") from problem


def require_picture(option, path):
    """Raises BadOutput for a name that is no picture's; None is none."""
    if path is not None and not path.endswith(PICTURES):
        raise BadOutput(f"{option}: expected a name that ends in .png, .svg or .pdf, got {path}")


def save_picture(figure, path, **how):
    """As figure.savefig(), but with a clear error on a full disk, without warnings of letters that a font lacks, and without formulas
    between dollars, such as those of a file's name."""
    from matplotlib.text import Text  # pylint: disable=import-outside-toplevel  # only what draws has it
    for text in figure.findobj(Text):
        text.set_text(text.get_text().replace("$", r"\$"))
    picture = io.BytesIO()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        figure.savefig(picture, format=os.path.splitext(path)[1][1:], **how)
    with writing(path), open(path, "wb") as file:
        file.write(picture.getbuffer())


@contextlib.contextmanager
def notes_by(say):
    """Says each warning, such as a note on a scene that is read, in a line without the place in the program."""
    with warnings.catch_warnings(record=True) as notes:
        yield
    for note in notes:
        say(f"note: {note.message}")


def scene_file(scene):
    """The file of a scene that is given by its path, or by the name of one that ships."""
    shipped = SHIPPED / f"{scene}.yaml"
    return str(shipped) if (not os.path.exists(scene) or os.path.isdir(scene)) and shipped.exists() else scene


def tree_of(text):
    """The values of a scene's text: of YAML, or a URDF, as scene_reader.cpp takes them."""
    import yaml  # pylint: disable=import-outside-toplevel  # most tools do not need it
    return {"robot_description": text} if re.match("\ufeff?\\s*<[^<]", text) else yaml.safe_load(text)


def is_same(path, other):
    """Devices and pipes may be given twice."""
    try:
        return os.path.samefile(path, other) and os.path.isfile(path)
    except OSError:  # one of them does not exist yet
        return os.path.realpath(path) == os.path.realpath(other)


def require_apart(outputs, inputs):
    """outputs: (option, path or None) of each. Raises BadOutput if one is, by any name, an input or another output."""
    taken = list(inputs)
    for option, path in outputs:
        if path is None:
            continue
        if any(is_same(path, other) for other in taken):
            raise BadOutput(f"{option}: expected a file that is not another of the run's, got {path}")
        taken.append(path)


def require_outputs(outputs, inputs):
    """As require_apart(). Also raises BadOutput if one cannot be written, or is standard output. Changes no file."""
    require_apart(outputs, inputs)
    for option, path in outputs:
        if path is None:
            continue
        if path == "-":
            raise BadOutput(f"{option}: expected a file, as standard output has other text, got -")
        is_new = not os.path.exists(path)
        if os.access(path, os.W_OK) and stat.S_ISFIFO(os.stat(path).st_mode):
            continue  # to open it waits for its reader, and to close it ends what the reader gets
        try:
            with open(path, "ab"):
                pass
        except OSError as problem:
            raise BadOutput(f"{option}: expected a file that can be written, got {path}: {problem.strerror}") from problem
        if is_new:
            os.remove(os.path.realpath(path))
