"""Files, functions and lines are short, and classes have few data members."""
import pathlib
import re
from typing import List, Tuple

import tree

MAX_FILE_LINES = 400
MAX_FUNCTION_LINES = 70
MAX_COLUMNS = 100
MAX_MEMBERS = 20
MAX_README_LINES = 120  # The README at the top.

_CONTAINER = re.compile(
    r'\b(namespace|class|struct|union|enum|extern)\b(?![^()]*\)\s*(const|noexcept|->|$))'
    r'|\bTEST_SUITE\b|^HWY_\w+\s*$')


def _kind_of(head: str) -> str:
    """The kind of block after `head`, the text since the last statement."""
    stripped = head.strip()
    if _CONTAINER.search(stripped) and not stripped.endswith("="):
        return "container"
    if "(" in stripped and not stripped.endswith("="):
        return "function"
    return "other"


def functions_of(text: str) -> List[Tuple[int, int]]:
    """First and last line of each function of C++ `text`, by counting braces."""
    code = tree.bare_code(text)
    functions, stack, head, head_line, line = [], [], "", 0, 1
    for index, char in enumerate(code):
        if char == "\n":
            line += 1
        in_container = all(kind == "container" for kind, _, _ in stack)
        if char == "{":
            kind = _kind_of(head) if in_container else "other"
            stack.append((kind, head_line or line, head))
            head, head_line = "", 0
        elif char == "}" and stack:
            kind, first, opening = stack.pop()
            rest = code[index + 1:index + 200].lstrip()
            is_initializer = kind != "container" and rest[:1] in {",", "{"} and \
                all(k == "container" for k, _, _ in stack)
            if kind == "function" and not is_initializer:
                functions.append((first, line))
            # `: a_{x}, b_{y} {`: the head goes on after a member's braces.
            head, head_line = (opening + "{}", first) if is_initializer else ("", 0)
        elif char == ";":
            head, head_line = "", 0
        elif in_container:
            if not head.strip() and not char.isspace():
                head_line = line
            head += char
    return functions


_CLASS = re.compile(r"(?<!enum )(?<!<)(?<!, )\bclass\s+(\w+)[^;{}()]*\{")
_BLOCK = re.compile(r"\{[^{}]*\}")
_MEMBER = re.compile(r"(?:[\w>&*]\s+|,\s*)(\w+_)\s*(?==|,|;|\[|<>)")


def classes_of(text: str) -> List[Tuple[int, str, int]]:
    """First line, name and number of data members (`name_`) of each class of C++ `text`."""
    code, classes = tree.bare_code(text), []
    for match in _CLASS.finditer(code):
        depth, end = 1, match.end()
        while depth > 0 and end < len(code):
            depth += {"{": 1, "}": -1}.get(code[end], 0)
            end += 1
        body = code[match.end():end - 1]
        while _BLOCK.search(body):
            body = _BLOCK.sub("<>", body)  # A member's first value, or a function's body.
        body = re.sub(r"\)[^;<]*<>", ");", body)
        count = len(_MEMBER.findall(body))
        classes.append((code.count("\n", 0, match.start()) + 1, match[1], count))
    return classes


def _text_errors(path: pathlib.PurePath, text: str) -> List[str]:
    errors, lines = [], text.splitlines()
    if len(lines) > MAX_FILE_LINES:
        errors.append(f"{path}: {len(lines)} lines, at most {MAX_FILE_LINES}")
    for number, line in enumerate(lines, 1):
        if len(line) > MAX_COLUMNS and not tree.is_translation(path):
            errors.append(f"{path}:{number}: {len(line)} columns, at most {MAX_COLUMNS}")
    if path.suffix in tree.CPP:
        for first, last in functions_of(text):
            if last - first + 1 > MAX_FUNCTION_LINES:
                errors.append(f"{path}:{first}: function of {last - first + 1} lines, at most "
                              f"{MAX_FUNCTION_LINES}")
        for line, name, count in classes_of(text):
            if count > MAX_MEMBERS:
                errors.append(f"{path}:{line}: {name} has {count} data members, at most "
                              f"{MAX_MEMBERS}")
    return errors


def check(root: pathlib.Path) -> List[str]:
    errors = []
    for path in tree.files_of(root):
        if tree.is_code(path) and not tree.is_table(path):
            errors += _text_errors(path, tree.read(root, path))
        if str(path) == "README.md":
            count = len(tree.read(root, path).splitlines())
            if count > MAX_README_LINES:
                errors.append(f"{path}: {count} lines, at most {MAX_README_LINES}")
    return errors
