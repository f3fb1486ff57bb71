"""The parts that C++ is made of: parameters, structs, constants, comments."""

import bisect
import pathlib
import re

from source_tree import COMMENT_OR_TEXT, code_of


def head_parts(head: str) -> tuple[str, list[str]]:
    """Name and parameters of a function, from what stands before its body. A comma within any brackets parts nothing."""
    depth, begin = 0, None
    parameters = [""]
    for at, character in enumerate(head):
        opens, closes = character in "(<[{", character in ")>]}"
        if begin is None:
            if character == "(" and depth == 0 and not re.search(r"\boperator$", head[:at]):
                begin = at
            depth += (character == "<") - (character == ">")
        elif character == ")" and depth == 0:
            break
        elif character == "," and depth == 0:
            parameters.append("")
        else:
            depth += opens - closes
            parameters[-1] += character
    name = re.search(r"operator\W*$|[~\w:]*(?:<[^()]*>)?$", head[:begin].rstrip()).group()
    return name, [one.strip() for one in parameters if one.strip() not in ("", "void")]


MEMBERS_MAX = 15  # a struct with more is wide

STRUCT = re.compile(r"(?<!enum )\b(?:struct|class) ([\w:]+)(?: final)?(?: : [^;{}()]*)?\s*\{")
NO_MEMBER = re.compile(r"(?:static|using|enum|struct|class|union|friend|template|explicit|\[\[)\b|~|.*\boperator\b", re.DOTALL)


def members_of(body: str) -> int:
    """Data members of a struct: declarations at its own depth that are no functions."""
    depth, flat = 0, []
    for character in body:
        depth += {"{": 1, "(": 1}.get(character, 0)
        if depth == 0:
            flat.append(character)
        elif character in "({":
            flat.append("~" if character == "(" else "")
        depth -= {"}": 1, ")": 1}.get(character, 0)
    statements = [re.sub(r"\b(?:public|private|protected):", "", s).strip() for s in "".join(flat).split(";")]
    return sum(len(s.split(",")) if "<" not in s else 1 for s in statements
               if s and "~" not in s.split("=")[0] and not NO_MEMBER.match(s))


def structs_of(file: pathlib.Path) -> list[tuple[str, int, int]]:
    """Name, line and number of data members of each struct and class, those within others too."""
    code, found = code_of(file), []
    for match in STRUCT.finditer(code):
        depth, at = 1, match.end()
        while depth and at < len(code):
            depth += (code[at] == "{") - (code[at] == "}")
            at += 1
        found.append((match.group(1), code.count("\n", 0, match.start()) + 1, members_of(code[match.end():at - 1])))
    return found


CONSTANT = re.compile(r"^[ \t]*(?:(?:static|inline) )*constexpr\b[^=;(){}]*?\b(k[A-Z]\w*)(?:\[[^\]]*\])*\s*(?:=|(?=\{))", re.MULTILINE)
NUMBER = re.compile(r"(?<![\w.])\.?\d")
NO_NUMBER = re.compile(r'"|[{,]\s*\{|^\s*\[')  # texts, braces in braces, a function


def blanked(text: str) -> str:
    """Without comments and texts; every character that stays keeps its place."""

    def blank(match: re.Match) -> str:
        inner = re.sub(r"[^\n]", " ", match.group())
        return f'"{inner[1:-1]}"' if match.group()[0] == '"' else inner

    return COMMENT_OR_TEXT.sub(blank, re.sub(r"(?<=\d)'(?=\d)", "0", text))


def constants(text: str) -> list[tuple[str, int, int, bool]]:
    """Name, first and last line (from 0) of each constexpr kName, and whether its value is spelled as a number."""
    code = blanked(text)
    line_ends = [match.start() for match in re.finditer("\n", code)]
    found = []
    for match in CONSTANT.finditer(code):
        end = code.index(";", match.end())
        value = code[match.end():end]
        first, last = (bisect.bisect_left(line_ends, at) for at in (match.start(1), end))
        first -= code[match.start():match.start(1)].count("\n")
        found.append((match.group(1), first, last, bool(NUMBER.search(value)) and not NO_NUMBER.search(value)))
    return found


def comments_of(text: str) -> list[tuple[int, str]]:
    """Line and text of each comment. Lines that begin at one column, one below the other, are one comment."""
    found, last_end, last_column = [], None, None
    for match in COMMENT_OR_TEXT.finditer(re.sub(r"(?<=\d)'(?=\d)", "0", text)):
        if match.group()[0] != "/":
            continue
        column = match.start() - text.rfind("\n", 0, match.start())
        between = text[last_end:match.start()] if found else ""
        if found and column == last_column and re.fullmatch(r"\n[ \t]*", between):
            found[-1] = (found[-1][0], f"{found[-1][1]}\n{match.group()}")
        else:
            found.append((text.count("\n", 0, match.start()) + 1, match.group()))
        last_end, last_column = match.end(), column
    return found
