"""Every unit of fsw that decides something has a test: one of its own name, or one that covered_by.toml names."""

import pathlib
import re
import tomllib

from source_tree import REPOSITORY, code_of, own_includes

LIST = pathlib.Path(__file__).with_name("covered_by.toml")
DECISION = re.compile(r"\b(?:if|for|while|switch)\b|\?")
NAME_BEFORE_PARENTHESIS = re.compile(r"\b([A-Za-z_]\w*)\s*\(")
WORDS_MAX = 20  # an entry says in a few words what is tested


def plain_code(file: pathlib.Path) -> str:
    """Without comments, texts and what the preprocessor reads."""
    return re.sub(r"^\s*#[^\n]*(?:\\\n[^\n]*)*", "", code_of(file), flags=re.MULTILINE)


def units_that_decide(root: pathlib.Path) -> list[str]:
    return sorted(str(file.relative_to(root / "fsw")) for file in (root / "fsw").rglob("*.cpp") if DECISION.search(plain_code(file)))


def own_test(root: pathlib.Path, unit: str) -> pathlib.Path:
    return root / "tests" / unit.replace(".cpp", "_test.cpp")


def reached_headers(root: pathlib.Path, file: pathlib.Path, with_sources: bool = False) -> set[pathlib.Path]:
    """What a file includes, itself or by way of others; with_sources: and of the sources of these headers' names."""
    found, open_files = set(), [file]
    while open_files:
        at = open_files.pop()
        for include in own_includes(at):
            places = [base / include for base in (at.parent, root / "fsw", root / "tests", root)]
            header = next((place.resolve() for place in places if place.exists()), None)
            if header and header not in found:
                found.add(header)
                sources = [header.with_suffix(".cpp")] if with_sources else []
                open_files += [header] + [source for source in sources if source.exists()]
    return found


def public_functions(root: pathlib.Path, unit: str) -> dict[str, pathlib.Path]:
    """What the unit defines and its header declares; where that declares nothing of it, another header of the stage.

    A definition's name stands on a line that begins at the margin."""
    source = root / "fsw" / unit
    at_margin = [line for line in plain_code(source).splitlines() if re.match(r"[A-Za-z]", line)]
    defined = {name for line in at_margin for name in NAME_BEFORE_PARENTHESIS.findall(line)}
    own = source.with_suffix(".hpp").resolve()
    of_stage = [header for header in reached_headers(root, source) if header.parent.name == source.parent.name]
    for headers in [[own] if own.exists() else [], of_stage]:
        found = {name: header for header in headers for name in NAME_BEFORE_PARENTHESIS.findall(plain_code(header)) if name in defined}
        if found:
            return found
    return {}


def calls(root: pathlib.Path, test: pathlib.Path, unit: str) -> bool:
    called = set(NAME_BEFORE_PARENTHESIS.findall(plain_code(test)))
    seen = reached_headers(root, test)
    return any(name in called and header in seen for name, header in public_functions(root, unit).items())


def leads_to(root: pathlib.Path, unit: str, other: str) -> bool:
    """By its includes and those of the units that it calls."""
    return bool(set(public_functions(root, other).values()) & reached_headers(root, root / "fsw" / unit, with_sources=True))


def faults_of_entry(root: pathlib.Path, unit: str, entry: dict) -> list[str]:
    if not (root / "fsw" / unit).exists():
        return [f"{unit} does not exist"]
    if own_test(root, unit).exists():
        return [f"{unit} has a test of its own name"]
    faults = []
    words = len(entry.get("tested", "").split())
    if not 2 <= words <= WORDS_MAX:
        faults.append(f"{unit}: `tested` says in 2 to {WORDS_MAX} words what of it is tested")
    test = root / entry.get("test", "")
    if not test.is_file() or test.suffix != ".cpp":
        return faults + [f"{unit}: {entry.get('test')} does not exist"]
    through = entry.get("through")
    if through and not (through.startswith("pipeline/") and leads_to(root, through, unit)):
        faults.append(f"{unit}: `through` is a unit of the pipeline that leads to this one")
    if not calls(root, test, through or unit):
        faults.append(f"{unit}: {entry['test']} calls none of {', '.join(sorted(public_functions(root, through or unit)))}")
    return faults


def faults(root: pathlib.Path, covered: dict[str, dict]) -> list[str]:
    found = [fault for unit, entry in covered.items() for fault in faults_of_entry(root, unit, entry)]
    return found + [f"{unit}: no {own_test(root, unit).relative_to(root)}, and {LIST.name} names no other test"
                    for unit in units_that_decide(root) if unit not in covered and not own_test(root, unit).exists()]


def test_every_unit_that_decides_is_tested():
    assert len(units_that_decide(REPOSITORY)) > 100
    found = faults(REPOSITORY, tomllib.loads(LIST.read_text()))
    assert not found, "\n".join(found)


def test_the_list_is_in_order():
    units = list(tomllib.loads(LIST.read_text()))
    assert units == sorted(units)


def small_tree(root: pathlib.Path) -> pathlib.Path:
    files = {
        "fsw/solve/clamp.hpp": "double clamped(double value);  // calls other(value)\nstruct Range { int low; };\n",
        "fsw/solve/clamp.cpp": '#include "solve/clamp.hpp"\ndouble clamped(double value) {\n  if (value < 0) return helper(value);\n  return value;\n}\n',
        "fsw/solve/plain.cpp": "// if nothing is decided\nint three() { return 3; }\n",
        "fsw/pipeline/step.hpp": "void run_step();\n",
        "fsw/pipeline/step.cpp": '#include "pipeline/step.hpp"\n#include "pipeline/part.hpp"\nvoid run_step() {\n  while (part()) {}\n}\n',
        "fsw/pipeline/part.hpp": "bool part();\n",
        "fsw/pipeline/part.cpp": '#include "pipeline/part.hpp"\nbool part() {\n  return x ? 1 : 0;\n}\n',
        "tests/solve/numbers_test.cpp": '#include "solve/clamp.hpp"\nTEST(A, B) { EXPECT_EQ(clamped(1.0), 1.0); }\n',
        "tests/solve/other_test.cpp": '#include "solve/clamp.hpp"\nTEST(A, C) { Range r; }  // clamped(1.0)\n',
        "tests/solve/stray_test.cpp": "TEST(A, D) { clamped(1.0); }\n",
        "tests/pipeline/step_test.cpp": '#include "pipeline/step.hpp"\nTEST(A, E) { run_step(); }\n',
    }
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    return root


CLAMP = {"test": "tests/solve/numbers_test.cpp", "tested": "values in range"}
PART = {"test": "tests/pipeline/step_test.cpp", "through": "pipeline/step.cpp", "tested": "both answers"}


def test_a_covered_tree_has_no_faults(tmp_path):
    root = small_tree(tmp_path)
    assert units_that_decide(root) == ["pipeline/part.cpp", "pipeline/step.cpp", "solve/clamp.cpp"]
    assert list(public_functions(root, "solve/clamp.cpp")) == ["clamped"]
    assert faults(root, {"solve/clamp.cpp": CLAMP, "pipeline/part.cpp": PART}) == []


def test_a_unit_without_a_test_is_found(tmp_path):
    root = small_tree(tmp_path)
    found = faults(root, {"pipeline/part.cpp": PART})
    assert len(found) == 1 and found[0].startswith("solve/clamp.cpp: no tests/solve/clamp_test.cpp")
    (root / "tests/solve/clamp_test.cpp").write_text("")
    assert faults(root, {"pipeline/part.cpp": PART}) == []


def test_entries_that_hold_no_longer_are_found(tmp_path):
    root = small_tree(tmp_path)
    for unit, entry, fault in [
            ("solve/gone.cpp", CLAMP, "does not exist"),
            ("pipeline/step.cpp", PART, "has a test of its own name"),
            ("solve/clamp.cpp", CLAMP | {"test": "tests/solve/gone_test.cpp"}, "gone_test.cpp does not exist"),
            ("solve/clamp.cpp", {"tested": "values in range"}, "does not exist"),
            ("solve/clamp.cpp", CLAMP | {"tested": "all"}, "what of it is tested"),
            ("solve/clamp.cpp", CLAMP | {"test": "tests/solve/other_test.cpp"}, "calls none of clamped"),
            ("solve/clamp.cpp", CLAMP | {"test": "tests/solve/stray_test.cpp"}, "calls none of clamped"),
            ("solve/clamp.cpp", CLAMP | {"through": "solve/plain.cpp"}, "is a unit of the pipeline"),
            ("solve/clamp.cpp", CLAMP | {"through": "pipeline/step.cpp"}, "leads to this one"),
            ("pipeline/part.cpp", PART | {"test": "tests/solve/numbers_test.cpp"}, "calls none of run_step"),
    ]:
        assert any(fault in one for one in faults_of_entry(root, unit, entry)), (unit, entry, fault)
