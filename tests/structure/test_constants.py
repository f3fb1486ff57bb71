"""Every named number says where it comes from."""

import re

from cpp_parts import constants
from source_tree import REPOSITORY, WRITTEN_BY, is_generated, name_of, source_files

# Numbers that explain themselves: "file:name", and why.
ALLOWED: dict[str, str] = {}

TEMPLATE_LINE = re.compile(r"\s*template <[^;{]*>\s*")


def has_comment(lines: list[str], first: int, last: int, block_starts: dict[int, int]) -> bool:
    """On its own lines, or directly above the block of constants that it stands in."""
    if any("//" in line for line in lines[first:last + 1]):
        return True
    indentation = re.match(r"\s*", lines[first]).group()
    above = first - 1
    while above >= 0:
        if above in block_starts:
            above = block_starts[above] - 1
        elif TEMPLATE_LINE.fullmatch(lines[above]):
            above -= 1
        else:
            return lines[above].startswith(indentation + "//")
    return False


def constants_without_comment(file) -> list[tuple[str, int]]:
    """Name and line of each."""
    if is_generated(file):
        return []
    text = file.read_text()
    lines = text.splitlines()
    found = constants(text)
    block_starts = {last: first for _, first, last, _ in found}
    return [(name, first + 1) for name, first, last, number in found
            if number and not has_comment(lines, first, last, block_starts)]


def complaints(constants_found: list[tuple[str, int, str]], allowed: dict[str, str]) -> list[str]:
    """File, line and name of each constant without a comment that is not allowed; what is allowed and does not occur."""
    wrong = [f"{file}:{line}: {name}" for file, line, name in constants_found if f"{file}:{name}" not in allowed]
    idle = set(allowed) - {f"{file}:{name}" for file, _, name in constants_found}
    return wrong + [f"{key} is allowed, but does not occur without a comment" for key in sorted(idle)]


def test_every_constant_says_where_it_comes_from():
    found = [(name_of(file), line, name) for file in source_files("fsw", suffixes=(".cpp", ".hpp"))
             for name, line in constants_without_comment(file)]
    wrong = complaints(found, ALLOWED)
    assert not wrong, "\n".join(wrong)


def test_an_exception_that_does_not_occur_is_found():
    found = [("fsw/base/one.hpp", 3, "kOne"), ("fsw/base/two.hpp", 4, "kTwo")]
    allowed = {"fsw/base/one.hpp:kOne": "of the format", "fsw/base/one.hpp:kGone": "of the format"}
    assert complaints(found, allowed) == [
        "fsw/base/two.hpp:4: kTwo", "fsw/base/one.hpp:kGone is allowed, but does not occur without a comment"]


def test_every_exception_has_a_reason():
    assert all(reason.strip() for reason in ALLOWED.values())


SAMPLE = """\
namespace {
constexpr int kBare = 3;

// A block's comment.
constexpr double kFirst = 1e-4;
constexpr double kSecond =
    2.0 * kFirst;
constexpr int kAtItsEnd = 7;  // why

constexpr double kText = 0.5; // a semicolon; in a comment
constexpr auto kTable = make_table();
constexpr double kBlockWithoutComment = 0.1;
struct Sizes {
  static constexpr std::size_t kMember = kBare + 1;
  static constexpr std::size_t kOctets =
      128;  ///< why
  template <int kSide>
  static constexpr int kRow = stride_of(kSide + 2);
};
constexpr Row kRows[] = {{"a", 1}, {"b", 2}};
constexpr std::array<double, 2> kList = {6.0,
                                         10.0};
constexpr std::array<double, 2> kBraced{1.0, 2.0};
constexpr float limited(float value) { return value < 1.0F ? value : 1.0F; }
}  // namespace
"""


def test_a_constant_without_a_comment_is_found(tmp_path):
    file = tmp_path / "sample.cpp"
    file.write_text(SAMPLE)
    assert constants_without_comment(file) == [
        ("kBare", 2), ("kBlockWithoutComment", 12), ("kMember", 14), ("kRow", 18), ("kList", 21), ("kBraced", 23)]


def test_written_files_are_not_asked(tmp_path):
    file = tmp_path / "written.hpp"
    file.write_text(WRITTEN_BY + "\nconstexpr int kBare = 3;\n")
    assert constants_without_comment(file) == []


def test_constants_are_found_at_all():
    """The measure would pass on anything if it found nothing."""
    found = constants((REPOSITORY / "fsw/base/time_doubt.hpp").read_text())
    assert [name for name, *_ in found] == ["kInARow"]
