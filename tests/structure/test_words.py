"""The code's words are those of the field: words.toml lists private ones, and how many each room that is not clean still has."""

import pathlib
import re
import tomllib

import pytest
from cpp_parts import COMMENT_OR_TEXT
from source_tree import is_generated, name_of, source_files

TABLE = tomllib.loads(pathlib.Path(__file__).with_name("words.toml").read_text())
WORDS = [(re.compile(rf"\b(?:{row['found']})\b"), row["say"], tuple(row.get("rooms", [""]))) for row in TABLE["word"]]
EXCEPTIONS = re.compile("|".join(rf"\b(?:{row['found']})\b" for row in TABLE["exception"]))
LEFT = TABLE["left"]
CAPITAL = re.compile(r"(?<=[a-z0-9])(?=[A-Z])")


def plain(text: str) -> str:
    """Lower-case words: texts are emptied, exceptions dropped, names split; lines keep their numbers."""
    text = COMMENT_OR_TEXT.sub(lambda m: m.group() if m.group()[0] == "/" else '""', re.sub(r"(?<=\d)'(?=\d)", "0", text))
    text = re.sub(r'^[ \t]*#include "[^"]*"', "", text, flags=re.MULTILINE)
    return CAPITAL.sub(" ", EXCEPTIONS.sub("", text)).replace("_", " ").lower()


def private_words(name: str, text: str) -> list[str]:
    """Place, word and what to say instead, of each."""
    found = []
    for number, line in enumerate(plain(text).splitlines(), 1):
        for pattern, say, rooms in WORDS:
            if name.startswith(rooms):
                found += [f"{name}:{number}: '{match.group()}': {say}" for match in pattern.finditer(line)]
    return found


def room_left(name: str) -> str | None:
    return next((room for room in LEFT if name.startswith(room)), None)


@pytest.fixture(scope="module")
def found():
    places: dict[str | None, list[str]] = {room: [] for room in (None, *LEFT)}
    for file in source_files("fsw", "platform", suffixes=(".cpp", ".hpp")):
        if not is_generated(file):
            places[room_left(name_of(file))] += private_words(name_of(file), file.read_text())
    return places


# verifies: CMP-07
def test_clean_rooms_have_no_private_words(found):
    assert not found[None], "\n".join(found[None])


@pytest.mark.parametrize("room", LEFT)
def test_private_words_only_fall_and_the_number_is_lowered_when_they_have(found, room):
    assert len(found[room]) == LEFT[room], f"{room}: {len(found[room])}, words.toml has {LEFT[room]}\n" + "\n".join(found[room][:20])


def test_a_private_word_is_found_in_names_and_comments():
    text = 'bool is_sound();  // tells it anew\nauto a = "told"; int n = 1\'000;\nclass TimeDoubt { int chi2_gap_commit; };\n/// An octet\n'
    assert [place.split(": ")[:2] for place in private_words("fsw/map/a.hpp", text)] == [
        ["fsw/map/a.hpp:1", "'sound'"], ["fsw/map/a.hpp:1", "'tells'"], ["fsw/map/a.hpp:1", "'anew'"],
        ["fsw/map/a.hpp:3", "'doubt'"], ["fsw/map/a.hpp:4", "'octet'"]]
    assert not private_words("platform/transport/a.hpp", "// An octet")
