"""Every named number says where it comes from."""

import re

from cpp_parts import constants
from source_tree import is_generated, name_of, source_files

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


def test_every_constant_says_where_it_comes_from():
    wrong = [f"{name_of(file)}:{line}: {name}" for file in source_files("fsw", suffixes=(".cpp", ".hpp"))
             for name, line in constants_without_comment(file)]
    assert not wrong, "\n".join(wrong)


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
