"""Intrinsics are exchanged in sensor.yaml of every form that the program reads; all else stays, or it is refused."""

import pytest
from polhode_ground.common.errors import BadInput
from polhode_ground.importing.sensor_text import values_of, with_intrinsics

FIELDS = ["rate_hz: 1.0  # as it was", "resolution: [640, 480]", "intrinsics: [888.9, 888.9, 319.5, 239.5]  # old", "camera_model: pinhole"]
BLOCK = "\n".join(FIELDS) + "\n"
FLOW = "{rate_hz: 1.0, intrinsics: [888.9, 888.9, 319.5, 239.5], camera_model: pinhole}\n"


@pytest.mark.parametrize("text", [
    BLOCK, FLOW, "%YAML:1.0\n---\n" + BLOCK, BLOCK + "---\na: 1\n", BLOCK.replace("1.0  #", "1.0\t#"), BLOCK.replace("\n", "\r\n"), "# \udcfc\n" + BLOCK,
    BLOCK.replace("[888.9, 888.9, 319.5, 239.5]", "&here [888.9, 888.9, 319.5, 239.5]"), "".join(f"  {line}\n" for line in FIELDS),
    BLOCK.replace(" [888.9, 888.9, 319.5, 239.5]  # old", "\n- 888.9\n- 888.9\n- 319.5\n- 239.5"), "camera_model: pinhole\nintrinsics: auto"])
def test_all_else_stays(text):
    new = with_intrinsics(text, "focal length estimated once", "[1, 2, 3, 4]", 5.0)
    new = with_intrinsics(new, "focal length estimated again", "[900, 900, 3, 4]", 7.0)
    assert values_of(new) == values_of(text) | {"intrinsics": [900, 900, 3, 4], "sigma_focal_px": 7}
    assert new.count("sigma_focal_px") == new.count("estimated") == 1
    kept = [line for line in text.splitlines(keepends=True) if "intrinsics" not in line and not line.startswith("- ")]
    assert [line for line in new.splitlines(keepends=True) if line in kept] == kept
    if text.startswith("%"):
        assert new.startswith("%YAML:1.0\n---\n")


@pytest.mark.parametrize("text", [BLOCK.replace("ics: [", "ics: &here [") + "factory: *here\n", "a: [b\n", "a: 1\n"])
def test_what_cannot_be_exchanged_alone_is_refused(text):
    with pytest.raises(BadInput, match="anchors"):
        with_intrinsics(text, "said", "[1, 2, 3, 4]", 5.0)
