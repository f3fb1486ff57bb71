"""JavaScript: what the ground page needs to say the numbers of an event in words."""

import json

from .table import Table

NOTE = "// Written by tools/generate_bus.py from config/bus/*.toml: change those.\n"


def files(table: Table) -> dict[str, str]:
    words = {event.name: event.words for event in table.events if any(event.words)}
    codes = {name: table.codes[name] for name in sorted({code for pair in words.values() for code in pair} - {""})}
    text = NOTE + '"use strict";\n\n// Event: what each of its two numbers is a code of; empty: it is a number.\n'
    text += f"const eventCodes = {json.dumps(words, indent=2)};\n\n// Names of codes.\nconst codeNames = {json.dumps(codes, indent=2)};\n"
    return {"hil/ground_station/display/words.js": text}
