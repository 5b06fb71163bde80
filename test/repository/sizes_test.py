#!/usr/bin/python3
"""No file of the core has more than 400 lines, and no function of it more than 60.

    sizes_test.py [FOLDER …]        default: src and include"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).absolute().parents[2]
MOST_OF_A_FILE = 400
MOST_OF_A_FUNCTION = 60

TEXT = re.compile(r"//[^\n]*|/\*.*?\*/|R\"\((.*?)\)\"|\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])+'", re.DOTALL)
SCOPE = re.compile(r"\b(namespace|class|struct|enum|union|extern)\b")


def bare(text):
    """Without comments, literals and preprocessor lines; every line stays where it was."""
    def blank(match):
        return "\n" * match.group().count("\n")

    text = re.sub(r"(?<=[0-9a-fA-F])'(?=[0-9a-fA-F])", "", text)  # 1'000
    text = TEXT.sub(blank, text)
    return re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", blank, text, flags=re.MULTILINE)


def functions(text):
    """(first line, lines) of every function that stands in a namespace or a class, from its head to its last brace."""
    scopes, head, begin, line = [], "", 1, 1
    for char in bare(text):
        if char == "\n":
            line += 1
        if not scopes or scopes[-1] is None:  # in no function
            if not head.strip():
                head, begin = "", line
            if char == "{":
                is_scope = SCOPE.search(re.sub(r"template\s*<[^>]*>", "", head)) and "(" not in head
                is_value = not is_scope and "(" not in head
                scopes.append(None if is_scope else ("value" if is_value else begin))
                head = "" if is_scope else head
                continue
            head = "" if char in ";}" else head + char
            if char == "}" and scopes:
                scopes.pop()
        elif char == "{":
            scopes.append("inner")
        elif char == "}":
            begun = scopes.pop()
            if isinstance(begun, int):
                yield begun, line - begun + 1
            if not scopes or scopes[-1] is None:
                head = "" if begun != "value" else head


def python_functions(text):
    """The functions of a Python file, by indentation."""
    lines = text.split("\n")
    for i, line in enumerate(lines):
        head = re.match(r"( *)(?:async )?def ", line)
        if not head:
            continue
        last = i
        for k in range(i + 1, len(lines)):
            if lines[k].strip() and not lines[k].startswith(head[1] + " ") and not re.match(head[1] + r"\)", lines[k]):
                break
            last = k if lines[k].strip() else last
        yield i + 1, last - i + 1


def faults(folders):
    for folder in folders:
        for file in sorted(folder.rglob("*")):
            if file.suffix not in (".h", ".cpp", ".py"):
                continue
            text = file.read_text(encoding="utf-8")
            name = file.relative_to(ROOT) if ROOT in file.parents else file
            count = text.count("\n")
            if count > MOST_OF_A_FILE:
                yield f"{name} has {count} lines, more than {MOST_OF_A_FILE}"
            for begin, size in (python_functions if file.suffix == ".py" else functions)(text):
                if size > MOST_OF_A_FUNCTION:
                    yield f"{name}:{begin}: a function of {size} lines, more than {MOST_OF_A_FUNCTION}"


def main():
    found = list(faults([pathlib.Path(folder).absolute() for folder in sys.argv[1:]] or [ROOT / "src", ROOT / "include"]))
    print("\n".join(found) if found else f"no file over {MOST_OF_A_FILE} lines, no function over {MOST_OF_A_FUNCTION}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
