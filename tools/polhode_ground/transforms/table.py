"""Every kind of transform with its options and their ranges, and how a chain of them is applied."""

import pathlib
from collections.abc import Callable
from dataclasses import dataclass

from polhode_ground.common.errors import BadInput
from polhode_ground.transforms import camera_faults, claims, delivery, optics, view
from polhode_ground.transforms.footage import Footage, read_footage, write_footage


@dataclass(frozen=True)
class Option:
    """A number with its range; whole where the default is."""

    default: float | int
    least: float
    most: float
    what: str


@dataclass(frozen=True)
class Kind:
    """function(footage, options, seed) -> footage."""

    function: Callable[[Footage, dict, int], Footage]
    options: dict[str, Option]

    @property
    def what(self) -> str:
        return self.function.__doc__.splitlines()[0]


FRACTION = Option(0.1, 0.0, 0.9, "part of the frames")
RUN = Option(1, 1, 1000, "frames in a row")
FROM, TO, RAMP = (
    Option(value, 0.0, 1.0, what)
    for value, what in ((0.45, "where it begins, part of the sequence"), (0.6, "where it ends"), (0.05, "how long it takes to come and go"))
)

KINDS: dict[str, Kind] = {
    "faults": Kind(camera_faults.faults, {"fraction": FRACTION}),
    "repeated": Kind(delivery.repeated, {"fraction": FRACTION}),
    "near_repeated": Kind(delivery.near_repeated, {"fraction": FRACTION, "sigma_gray": Option(1.0, 0.0, 50.0, "noise, gray levels")}),
    "stale": Kind(delivery.stale, {"fraction": FRACTION, "age_frames": Option(20, 2, 10000, "how old the picture is")}),
    "missing": Kind(delivery.missing, {"fraction": FRACTION, "run_frames": RUN}),
    "excerpt": Kind(
        delivery.excerpt, {"first_frame": Option(0, 0, 1_000_000, "it begins with"), "frames": Option(20, 2, 1_000_000, "at most")}
    ),
    "foreign": Kind(delivery.foreign, {"fraction": FRACTION, "run_frames": RUN}),
    "torn": Kind(delivery.torn, {"fraction": FRACTION}),
    "halves": Kind(delivery.halves, {}),
    "shuffled": Kind(delivery.shuffled, {}),
    "rate_jump": Kind(
        delivery.rate_jump,
        {"at_part": Option(0.5, 0.0, 1.0, "where, part of the sequence"), "factor": Option(2, -10, 10, "how much faster; not 0")},
    ),
    "eclipse": Kind(
        optics.eclipse,
        {
            "from_part": FROM,
            "to_part": TO,
            "ramp_part": Option(0.05, 0.001, 1.0, RAMP.what),
            "darkness": Option(0.01, 1e-6, 1.0, "part of the light that is left"),
        },
    ),
    "flare": Kind(optics.flare, {"strength": Option(0.4, 0.0, 5.0, "brightest veil, 1 is white")}),
    "caption": Kind(optics.caption, {"height_part": Option(0.06, 0.01, 0.5, "height of the text in pictures")}),
    "own_structure": Kind(optics.own_structure, {"reach_part": Option(0.3, 0.0, 1.0, "how far it reaches, part of the width")}),
    "dirt": Kind(
        optics.dirt,
        {
            "spots": Option(12, 0, 1000, "how many"),
            "size_part": Option(0.03, 0.001, 0.5, "radius, part of the width"),
            "loss": Option(0.5, 0.0, 1.0, "light lost in the middle of a spot"),
        },
    ),
    "jpeg": Kind(optics.jpeg, {"quality": Option(50, 1, 100, "of the encoder")}),
    "noise": Kind(optics.noise, {"sigma_gray": Option(4.0, 0.0, 100.0, "gray levels")}),
    "gamma": Kind(optics.gamma, {"exponent": Option(0.7, 0.1, 10.0, "of gray levels")}),
    "shake": Kind(view.shake, {"sigma_px": Option(3.0, 0.0, 100.0, "about each axis, at the focal length")}),
    "leaving": Kind(view.leaving, {"from_part": FROM, "to_part": TO, "ramp_part": Option(0.1, 0.001, 1.0, RAMP.what)}),
    "rolling_shutter": Kind(
        view.rolling_shutter,
        {
            "readout_part": Option(0.3, -1.0, 1.0, "of the time between frames; from below: negative"),
            "stated": Option(0, 0, 1, "1: sensor.yaml states the rows' times"),
        },
    ),
    "zoom": Kind(view.zoom, {"factor": Option(1.3, 0.2, 5.0, "at the end, over the first focal length")}),
    "mirrored": Kind(view.mirrored, {}),
    "focal_length": Kind(claims.focal_length, {"factor": Option(1.05, 0.1, 10.0, "stated over true")}),
    "aspect": Kind(claims.aspect, {"factor": Option(1.05, 0.1, 10.0, "stated over true fv / fu")}),
    "principal_point": Kind(
        claims.principal_point, {"du_px": Option(10.0, -1e4, 1e4, "to the right"), "dv_px": Option(-5.0, -1e4, 1e4, "down")}
    ),
    "stamps": Kind(
        claims.stamps,
        {"pace": Option(1.02, 0.1, 10.0, "stated time over true time"), "jitter_part": Option(0.0, 0.0, 0.9, "of the time between frames")},
    ),
}


# They give frames other times, or other frames the times: what was logged before would name none of them.
RESTAMPING = {"shuffled", "rate_jump", "stamps"}


def check_order(where: str, kinds: list[str]) -> None:
    """Transforms that restamp come first."""
    for number, kind in enumerate(kinds):
        if kind in RESTAMPING and number > 0:
            raise BadInput(
                f"{where}: {kind} gives frames other times: it must be the first step, and the only one of {', '.join(sorted(RESTAMPING))}"
            )


def options_of(where: str, kind: str, given: dict) -> dict:
    """All options of a kind with those that are given; BadInput names what is wrong and what is allowed."""
    if kind not in KINDS:
        raise BadInput(f"{where}: kind '{kind}' is none of {', '.join(KINDS)}")
    table = KINDS[kind].options
    for name, value in given.items():
        if name not in table:
            raise BadInput(f"{where}: {kind} has no option '{name}'; allowed: {', '.join(table) or 'none'}")
        option = table[name]
        whole = isinstance(option.default, int)
        if isinstance(value, bool) or not isinstance(value, int if whole else (int, float)) or not option.least <= value <= option.most:
            raise BadInput(
                f"{where}: {name} = {value!r}: allowed is a {'whole ' if whole else ''}number in {option.least} .. {option.most}"
            )
    if kind == "rate_jump" and given.get("factor") == 0:
        raise BadInput(f"{where}: factor = 0: allowed is a whole number in -10 .. 10 other than 0")
    return {name: option.default for name, option in table.items()} | given


def applied(footage: Footage, steps: list[dict], seed: int) -> Footage:
    """The footage after steps {kind, options...}, in order."""
    check_order("steps", [step["kind"] for step in steps])
    for number, step in enumerate(steps):
        given = {name: value for name, value in step.items() if name != "kind"}
        options = options_of(f"step {number + 1}", step["kind"], given)
        footage = KINDS[step["kind"]].function(footage, options, seed + number)
    return footage


def transform(source: pathlib.Path, out: pathlib.Path, steps: list[dict], seed: int) -> int:
    """Applies steps to a sequence; OUT is a new folder. @return lines in its log."""
    footage = applied(read_footage(source), steps, seed)
    write_footage(footage, out)
    return len(footage.log)
