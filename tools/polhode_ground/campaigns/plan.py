"""The plan of a campaign: PLAN.toml read and checked, and the runs that it asks for.

A run is a scene, a transform of its pictures, and a setting of the program (a configuration with values on top).
"""

import itertools
import json
import pathlib
import tomllib
from dataclasses import dataclass, field
from typing import Any, NoReturn

from polhode_ground.campaigns.scene_space import Picture, narrowed, points, scene_of
from polhode_ground.common.errors import BadInput
from polhode_ground.common.venv import REPOSITORY
from polhode_ground.transforms.table import check_order, options_of

UNTRANSFORMED = "plain"
TABLES = {
    "": {"name", "scenes", "paths", "scene_files", "sequences", "configurations", "sweep", "transforms", "untransformed", "judge"},
    "scenes": {"draws", "seed", "frames", "resolution", "texture_px", "samples", "space"},
    "paths": {"draws", "seed", "frames", "resolution"},
    "scene_files": {"file", "variant"},
    "configurations": {"name", "file", "set"},
    "transforms": {"name", "steps", "seed"},
    "judge": {"shape", "time_alone", "limit", "replay_timeout_s"},
}


@dataclass(frozen=True)
class Scene:
    """Where a sequence comes from: a scene that is rendered (text of its TOML, its file where it has one, variant), a path that is
    drawn (arguments of paths.draw), or a folder."""

    name: str
    text: str = ""
    file: pathlib.Path | None = None
    variant: str = ""
    folder: pathlib.Path | None = None
    path: dict[str, Any] | None = None


@dataclass(frozen=True)
class Transform:
    name: str
    steps: tuple[dict[str, Any], ...] = ()
    seed: int = 1


@dataclass(frozen=True)
class Setting:
    """One way of running the program."""

    name: str
    config: pathlib.Path
    settings: tuple[str, ...] = ()


@dataclass(frozen=True)
class Run:
    scene: Scene
    transform: Transform
    setting: Setting

    @property
    def name(self) -> str:
        return f"{self.scene.name}/{self.transform.name}/{self.setting.name}"


@dataclass(frozen=True)
class Plan:
    name: str
    scenes: tuple[Scene, ...]
    transforms: tuple[Transform, ...]
    settings: tuple[Setting, ...]
    shape: bool = True  # judge the cloud, too
    time_alone: bool = True  # measure times by runs that have the machine to themselves
    limit: bool = False  # ask from which frame on the depth sign is decidable
    replay_timeout_s: float = 1800.0
    draws: tuple[dict[str, Any], ...] = field(default=())  # the points of the scene space, in order

    @property
    def runs(self) -> list[Run]:
        return [Run(*one) for one in itertools.product(self.scenes, self.transforms, self.settings)]


def scene_toml(scene: dict[str, Any]) -> str:
    """A scene table as TOML: numbers, texts and lists are written as in JSON, which TOML reads."""
    lines = [f"{key} = {json.dumps(value)}" for key, value in scene.items() if not isinstance(value, dict)]
    for table, values in scene.items():
        if isinstance(values, dict):
            lines += ["", f"[{table}]", *(f"{key} = {json.dumps(value)}" for key, value in values.items())]
    return "\n".join(lines) + "\n"


class _Reader:
    """Values of the plan's tables; what is wrong is told with the file, the key and what is allowed."""

    def __init__(self, path: pathlib.Path):
        self.path = path
        try:
            self.raw = tomllib.loads(path.read_text())
        except OSError as problem:
            raise BadInput(f"{path}: {problem.strerror}") from None
        except (tomllib.TOMLDecodeError, UnicodeDecodeError) as problem:
            raise BadInput(f"{path}: not TOML: {problem}") from None
        self.keys("", self.raw)

    def refuse(self, where: str, what: str) -> NoReturn:
        raise BadInput(f"{self.path}: {where}: {what}")

    def keys(self, table: str, given: Any, where: str = "") -> None:
        if not isinstance(given, dict):
            self.refuse(where or table, "a table is needed")
        for key in given:
            if key not in TABLES[table]:
                self.refuse(f"{where or table}.{key}".lstrip("."), f"unknown; allowed: {', '.join(sorted(TABLES[table]))}")

    def tables(self, name: str) -> list[tuple[str, dict[str, Any]]]:
        """(where, table) of a list of tables."""
        given = self.raw.get(name, [])
        if not isinstance(given, list):
            self.refuse(name, f"a list of tables [[{name}]] is needed")
        for number, table in enumerate(given, 1):
            self.keys(name, table, f"{name} {number}")
        return [(f"{name} {number}", table) for number, table in enumerate(given, 1)]

    def value(
        self,
        where: str,
        table: dict[str, Any],
        key: str,
        kind: Any,
        default: Any = None,
        least: float | None = None,
        most: float | None = None,
    ) -> Any:
        if key not in table:
            if default is None:
                self.refuse(f"{where}.{key}", "missing")
            return default
        value = table[key]
        right = isinstance(value, kind) and not (isinstance(value, bool) and kind is not bool)
        if not right or (least is not None and not least <= value <= most):
            allowed = "" if least is None else f" in {least} .. {most}"
            names = {int: "a whole number", (int, float): "a number", str: "a text", bool: "true or false", list: "a list", dict: "a table"}
            self.refuse(f"{where}.{key}", f"found {value!r}, allowed is {names[kind]}{allowed}")
        return value

    def texts(self, where: str, table: dict[str, Any], key: str) -> list[str]:
        values: list[str] = self.value(where, table, key, list, [])
        if not all(isinstance(value, str) for value in values):
            self.refuse(f"{where}.{key}", "a list of texts is needed")
        return values

    def toml(self, where: str, text: str) -> pathlib.Path:
        """As place(), of a file that is TOML."""
        path = self.place(f"{where}.file", text)
        try:
            tomllib.loads(path.read_text())
        except OSError as problem:
            self.refuse(f"{where}.file", f"{path}: {problem.strerror}")
        except (tomllib.TOMLDecodeError, UnicodeDecodeError) as problem:
            self.refuse(f"{where}.file", f"{path}: not TOML: {problem}")
        return path

    def place(self, where: str, text: str) -> pathlib.Path:
        """A path as written in the plan: beside it, or from the project's root."""
        for base in (self.path.parent, REPOSITORY):
            if (base / text).exists():
                return (base / text).resolve()
        return self.refuse(where, f"{text} is neither beside the plan nor in the project")


def _resolution(reader: _Reader, where: str, table: dict[str, Any], default: list[int]) -> list[int]:
    resolution: list[int] = reader.value(where, table, "resolution", list, default)
    if len(resolution) != 2 or not all(isinstance(n, int) and 32 <= n <= 4096 for n in resolution):
        reader.refuse(f"{where}.resolution", "two whole numbers in 32 .. 4096 are needed")
    return resolution


def _picture(reader: _Reader, table: dict[str, Any]) -> Picture:
    width, height = _resolution(reader, "scenes", table, [640, 480])
    return Picture(
        frames=reader.value("scenes", table, "frames", int, 80, 3, 100000),
        resolution=(width, height),
        texture_px=reader.value("scenes", table, "texture_px", int, 1024, 64, 8192),
        samples=reader.value("scenes", table, "samples", int, 16, 1, 4096),
    )


def _drawn(reader: _Reader) -> tuple[list[Scene], list[dict[str, Any]]]:
    if "scenes" not in reader.raw:
        return [], []
    table = reader.raw["scenes"]
    reader.keys("scenes", table)
    draws, seed = (
        reader.value("scenes", table, key, int, None, least, most) for key, least, most in (("draws", 1, 4096), ("seed", 0, 2**31))
    )
    picture = _picture(reader, table)
    space = narrowed(f"{reader.path}: scenes.space", reader.value("scenes", table, "space", dict, {}))
    found = points(space, draws, seed)
    scenes = []
    for number, point in enumerate(found):
        name = f"draw_{number:03d}"
        scenes.append(Scene(name, scene_toml(scene_of(point, picture, name, seed=1000 * seed % 2**31 + number))))
    return scenes, found


def _paths(reader: _Reader) -> list[Scene]:
    """Random paths; more draws of the same seed begin with the same ones."""
    if "paths" not in reader.raw:
        return []
    table = reader.raw["paths"]
    reader.keys("paths", table)
    draws, seed = (
        reader.value("paths", table, key, int, None, least, most) for key, least, most in (("draws", 1, 100000), ("seed", 0, 2**31))
    )
    common = {
        "frames": reader.value("paths", table, "frames", int, 60, 8, 10000),
        "resolution": _resolution(reader, "paths", table, [240, 180]),
    }
    return [Scene(f"path_{number:05d}", path=common | {"seed": seed, "number": number}) for number in range(draws)]


def _given(reader: _Reader) -> list[Scene]:
    """Scene files with their variants, and folders of sequences."""
    scenes = []
    for where, table in reader.tables("scene_files"):
        file = reader.toml(where, reader.value(where, table, "file", str))
        variant = reader.value(where, table, "variant", str, "-").strip("-")
        scenes.append(Scene(f"{file.stem}_{variant}" if variant else file.stem, file.read_text(), file, variant))
    for text in reader.texts("", reader.raw, "sequences"):
        folder = reader.place("sequences", text)
        if not (folder / "mav0/cam0/data.csv").is_file():
            reader.refuse("sequences", f"{text}: holds no mav0/cam0/data.csv")
        scenes.append(Scene(folder.name, folder=folder))
    return scenes


def _transforms(reader: _Reader) -> list[Transform]:
    found = [Transform(UNTRANSFORMED)] if reader.value("", reader.raw, "untransformed", bool, True) else []
    for where, table in reader.tables("transforms"):
        steps = reader.value(where, table, "steps", list)
        for step in steps:
            if not isinstance(step, dict) or not isinstance(step.get("kind"), str):
                reader.refuse(f"{where}.steps", "each step is a table with a kind")
            options_of(f"{reader.path}: {where}", step["kind"], {key: value for key, value in step.items() if key != "kind"})
        check_order(f"{reader.path}: {where}", [step["kind"] for step in steps])
        found.append(Transform(reader.value(where, table, "name", str), tuple(steps), reader.value(where, table, "seed", int, 1, 0, 2**31)))
    return found


def _sweep(reader: _Reader) -> list[tuple[str, tuple[str, ...]]]:
    """(name, settings) for each combination of the swept values; one empty one without a sweep."""
    table = reader.value("", reader.raw, "sweep", dict, {})
    for key, values in table.items():
        if not isinstance(values, list) or not values:
            reader.refuse(f"sweep.{key}", 'a list of values is needed; dotted keys stand in quotes, as in "map.keyframes_max" = [40, 60]')
    for key, values in table.items():
        if not all(isinstance(value, (bool, int, float, str, list)) for value in values):
            reader.refuse(f"sweep.{key}", "values are numbers, texts, true or false, or lists of them")
    combinations = itertools.product(*([f"{key}={json.dumps(value)}" for value in values] for key, values in table.items()))
    return [(",".join(one), tuple(one)) for one in combinations]


def _settings(reader: _Reader) -> list[Setting]:
    configurations = reader.tables("configurations") or [("", {"name": "default", "file": "config/default.toml"})]
    found = []
    for where, table in configurations:
        name = reader.value(where, table, "name", str)
        file = reader.toml(where, reader.value(where, table, "file", str))
        own = tuple(reader.texts(where, table, "set"))
        found += [Setting("+".join(part for part in (name, swept) if part), file, own + settings) for swept, settings in _sweep(reader)]
    return found


def _unlike_names(reader: _Reader, what: str, names: list[str]) -> None:
    for name in names:
        if names.count(name) > 1:
            reader.refuse(what, f"two are called '{name}'")
        if not name or any(not (c.isalnum() or c in '_-+.,="[] ') for c in name):
            reader.refuse(what, f"'{name}' is no name: letters, digits and _-+., are allowed")


def read_plan(path: pathlib.Path) -> Plan:
    """A checked plan; BadInput with file, key and what is allowed."""
    reader = _Reader(pathlib.Path(path))
    scenes, draws = _drawn(reader)
    scenes += _paths(reader) + _given(reader)
    if not scenes:
        reader.refuse("scenes", "neither [scenes], [paths], [[scene_files]] nor sequences: there is nothing to run")
    transforms, settings = _transforms(reader), _settings(reader)
    if not transforms:
        reader.refuse("transforms", "none, and untransformed is false: there is nothing to run")
    for what, entries in (("scenes", scenes), ("transforms", transforms), ("configurations", settings)):
        _unlike_names(reader, what, [entry.name for entry in entries])
    judge = reader.value("", reader.raw, "judge", dict, {})
    reader.keys("judge", judge)
    return Plan(
        name=reader.value("", reader.raw, "name", str, reader.path.stem),
        scenes=tuple(scenes),
        transforms=tuple(transforms),
        settings=tuple(settings),
        shape=reader.value("judge", judge, "shape", bool, True),
        time_alone=reader.value("judge", judge, "time_alone", bool, True),
        limit=reader.value("judge", judge, "limit", bool, False),
        replay_timeout_s=float(reader.value("judge", judge, "replay_timeout_s", (int, float), 1800.0, 1, 1e6)),
        draws=tuple(draws),
    )
