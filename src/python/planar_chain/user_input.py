"""What users give by hand: numbers, paths of numbers to vary, tables. For sweeps and fits, and by a link for the tools."""

import csv
import io
import re

FIRST = 65536  # letters that are looked at before all are read
STILL = re.compile(r"(publish|sensors)/.*|seed|real_time_factor|command_timeout|integrator/loosest_tolerance|"
                   r"links/[^/]*/joint/(velocity_limit|effort_limit|command_delay|motor/.*)")


def read_number(text):
    """As float(), which also takes 1_0 for 10, and digits of other scripts."""
    if "_" in text or not text.isascii():
        raise ValueError(f"could not convert string to float: {text!r}")
    return float(text)


def read_whole(text):
    """As int(), with the same exceptions."""
    read_number(text)
    return int(text)


def read_numbers(option, text, refused):
    """The numbers between commas, or None for None."""
    try:
        return None if text is None else [read_number(number) for number in text.split(",")]
    except ValueError:
        raise refused(f"{option}: expected numbers with commas between, got {text!r}") from None


def read_torques(option, text, refused):
    """As linearize() takes them: "holding", the numbers between commas, or None."""
    return text if text == "holding" else read_numbers(option, text, refused)


def require_moving(path, refused):
    """Raises `refused` for the path of a number that acts on no motion of a run without commands."""
    if STILL.fullmatch(path):
        raise refused(f"--vary: expected a number that changes the motion, got {path}, which acts only on commands, measurements or the node")


def rows_of(path):
    """The rows of a CSV with the number of the line that each ends on; and words on its end where a number may be cut off, or "".
    Raises OSError, UnicodeDecodeError, csv.Error."""
    with open(path, newline="", encoding="utf-8-sig") as file:
        text = file.read(FIRST)
        if "\0" in text:  # as of a device without an end
            raise csv.Error("it has a byte 0")
        text += file.read()
    reader = csv.reader(io.StringIO(text, newline=""))
    rows = [(reader.line_num, row) for row in reader]
    return rows, "" if text.endswith(("\n", "\r")) or not rows else f"{path}: the last line has no end: its last number may be cut off"
