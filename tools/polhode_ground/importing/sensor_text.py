"""sensor.yaml as a text that people keep: one field is exchanged, everything else stays as it is."""

import re

from polhode_ground.common.errors import BadInput

REMARKS = ("# intrinsics:", "# focal length estimated")
COLUMNS = "  # fu, fv, cu, cv [px]"


def for_parser(text: str) -> str:
    """Of the same length, without what the program takes and PyYAML does not: tabs, OpenCV's directive, odd letters in remarks."""
    text = re.sub(r"(?m)^%", "#", text).replace("\t", " ")
    return re.sub(r"[^\n\r\x20-\x7e\xa0-\ud7ff\ue000-\ufffd]", "?", text)


def values_of(text: str) -> dict:
    """@errors yaml.YAMLError"""
    import yaml

    return next(yaml.safe_load_all(for_parser(text)), None) or {}


def _fields(text: str) -> tuple[object, dict]:
    """(the table, its keys and values by name)."""
    import yaml

    root = next(yaml.compose_all(for_parser(text), yaml.SafeLoader))
    return root, {key.value: (key, value) for key, value in root.value}


def with_intrinsics(text: str, said: str, intrinsics: str, sigma_px: float) -> str:
    """sensor.yaml with other intrinsics, in whichever form of YAML the old ones stand; what an earlier estimate said goes.

    @errors BadInput where something else would change, too
    """
    import yaml

    end = "\r\n" if "\r\n" in text else "\n"
    try:
        before = values_of(text)
        new = _exchanged(
            "".join(line for line in text.splitlines(keepends=True) if not line.startswith(REMARKS)),
            said,
            intrinsics,
            f"{sigma_px:.4g}",
            end,
        )
        after = values_of(new)
    except (yaml.YAMLError, StopIteration, AttributeError, KeyError) as problem:
        raise BadInput(
            f"its intrinsics can't be exchanged ({' '.join(str(problem).split()) or 'not a table'}); write them as plain fields without anchors"
        ) from None
    own = {"intrinsics", "sigma_focal_px"}
    if {key: value for key, value in before.items() if key not in own} != {key: value for key, value in after.items() if key not in own}:
        raise BadInput("other fields refer to its intrinsics; write them out, without anchors")
    return new


def _exchanged(text: str, said: str, intrinsics: str, sigma: str, end: str) -> str:
    root, fields = _fields(text)
    (key, value), old = fields["intrinsics"], fields.get("sigma_focal_px")
    begin, stop = key.start_mark.index, value.end_mark.index
    new = "" if old else f"sigma_focal_px: {sigma}{', ' if root.flow_style else end + ' ' * key.start_mark.column}"
    new += f"intrinsics: {intrinsics}"
    if not root.flow_style:
        remark = re.compile(r"[ \t]*#[^\r\n]*").match(text, stop)  # that on the old ones goes with them
        stop = remark.end() if remark else stop
        new += COLUMNS + ("" if text[stop : stop + 1] in ("\n", "\r") else end)
    edits = [(begin, stop, new), *([(old[1].start_mark.index, old[1].end_mark.index, sigma)] if old else [])]
    for first, last, words in sorted(edits, reverse=True):
        text = text[:first] + words + text[last:]
    return _remarked(text, root, said, end)


def _remarked(text: str, root, said: str, end: str) -> str:
    """Behind what must come first in a file: directives, and the mark where the table begins."""
    begin = text.rfind("\n", 0, root.start_mark.index) + 1
    return f"{text[:begin]}# {said}; the shape of the pixels, principal point and distortion as they stood{end}{text[begin:]}"
