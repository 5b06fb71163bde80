"""Tables as CSV files that outlive an interruption."""
import csv


def read_table(path):
    """The rows as dictionaries of text; none if there is no file."""
    if not path.exists():
        return []
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def write_whole(path, text):
    """Writes all of the file or none of it."""
    part = path.with_suffix(".part")
    part.write_text(text, encoding="utf-8")
    part.replace(path)


def lines_of(rows):
    return "".join(",".join(cells) + "\n" for cells in rows)


def write_rows(path, columns, rows):
    write_whole(path, lines_of([columns, *([row[name] for name in columns] for row in rows)]))


def open_table(path, columns):
    """Opens a table to append lines_of() rows. Drops the line that a killed process left unfinished."""
    lines = path.read_text(encoding="utf-8").splitlines(True) if path.exists() else []
    whole = [line for line in lines if line.endswith("\n")]
    write_whole(path, "".join(whole) or lines_of([columns]))
    return open(path, "a", encoding="utf-8", buffering=1)
