"""What the tests of the house look at: source files, their includes, the length of their functions."""

import ast
import functools
import pathlib
import re

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
ROOTS = ("fsw", "platform", "config", "tests", "hil", "tools")
SUFFIXES = (".cpp", ".hpp", ".py", ".sh")
WRITTEN_BY = "// Written by tools/generate_bus.py"

COMMENT_OR_TEXT = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'', re.DOTALL)


def source_files(*roots: str, suffixes=SUFFIXES) -> list[pathlib.Path]:
    files = []
    for root in roots or ROOTS:
        files += [file for file in (REPOSITORY / root).rglob("*")
                  if file.suffix in suffixes and "__pycache__" not in file.parts and "data" not in file.parts[:-1]]
    return sorted(files)


def name_of(file: pathlib.Path) -> str:
    return str(file.relative_to(REPOSITORY))


def is_generated(file: pathlib.Path) -> bool:
    return file.read_text().startswith(WRITTEN_BY)


@functools.cache
def code_of(file: pathlib.Path) -> str:
    """C++ without comments; texts are emptied; lines keep their numbers."""

    def blank(match: re.Match) -> str:
        text = match.group()
        return '""' if text[0] == '"' else "0" if text[0] == "'" else "\n" * text.count("\n")

    text = re.sub(r"(?<=\d)'(?=\d)", "", file.read_text())  # digit separators are no quotes
    return COMMENT_OR_TEXT.sub(blank, text)


def own_includes(file: pathlib.Path) -> list[str]:
    return re.findall(r'^\s*#include "([^"]+)"', file.read_text(), re.MULTILINE)


def system_includes(file: pathlib.Path) -> list[str]:
    return re.findall(r"^\s*#include <([^>]+)>", file.read_text(), re.MULTILINE)


NOT_A_FUNCTION = re.compile(r"^\s*(?:if|for|while|switch|catch|do|else|return|namespace|class|struct|enum|union)\b")
HOLDS_FUNCTIONS = re.compile(r'\b(?:namespace|class|struct|union|extern)\b[^;(){}=]*$')


def cpp_definitions(file: pathlib.Path) -> list[tuple[int, int, str]]:
    """First line, number of lines and head of each function, by its outermost braces."""
    code = re.sub(r"^\s*#(?:\\\n|[^\n])*", lambda m: "\n" * m.group().count("\n"), code_of(file), flags=re.MULTILINE)
    functions, stack, start_of_statement = [], [], 0
    for position, character in enumerate(code):
        if character == "{":
            before = code[start_of_statement:position]
            inside_function = any(kind == "function" for kind, *_ in stack)
            if HOLDS_FUNCTIONS.search(before.split("template", 1)[-1]) and not inside_function:
                kind = "scope"
            elif not inside_function and "(" in before and "=" not in before.split("(", 1)[0].replace("operator=", "") \
                    and not NOT_A_FUNCTION.match(before):
                kind = "function"
            else:
                kind = "block"
            first = start_of_statement + len(before) - len(before.lstrip())
            stack.append((kind, first, before.strip()))
            start_of_statement = position + 1
        elif character == "}":
            kind, first, head = stack.pop() if stack else ("block", 0, "")
            if kind == "function":
                line = code.count("\n", 0, first) + 1
                functions.append((line, code.count("\n", 0, position) + 2 - line, head))
            start_of_statement = position + 1
        elif character == ";":
            start_of_statement = position + 1
    return functions


def cpp_functions(file: pathlib.Path) -> list[tuple[int, int]]:
    """First line and number of lines of each function."""
    return [(line, lines) for line, lines, _ in cpp_definitions(file)]


def python_functions(file: pathlib.Path) -> list[tuple[int, int]]:
    tree = ast.parse(file.read_text())
    return [(node.lineno, node.end_lineno - node.lineno + 1) for node in ast.walk(tree)
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))]
