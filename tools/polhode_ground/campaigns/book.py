"""The campaign's book: every run of a plan with the keys of what it is made of and the tasks that make it.

A key names content. It holds the keys of what goes in, the options, and the sources of the code that does the work, so
that a rerun finds what is there and makes the rest: a new judge judges anew, a new program replays anew and keeps scenes.
"""

import json
import pathlib
import tomllib
from dataclasses import dataclass
from typing import Any

from polhode_ground.campaigns.plan import Plan, Run, Scene, Setting
from polhode_ground.campaigns.store import Store, digest, file_digest, folder_digest, is_whole, keep_copy, source_digest
from polhode_ground.campaigns.tasks import Task
from polhode_ground.common.errors import BadInput
from polhode_ground.common.venv import REPOSITORY
from polhode_ground.common.whole_file import claim_folder, write_whole

BOOK_FILE = "campaign.json"
# Built beside the program from the same sources.
LIMIT_PROGRAM = REPOSITORY / "build/release/bin/bench_start_limit"

_PACKAGE = "tools/polhode_ground"
TRANSFORM_SOURCES = (
    f"{_PACKAGE}/transforms/*.py",
    f"{_PACKAGE}/common/sequence.py",
    f"{_PACKAGE}/common/tables.py",
    f"{_PACKAGE}/judge/align.py",
    f"{_PACKAGE}/common/fault_log.py",
)
# The code behind each kind of task.
SOURCES = {
    "render": (f"{_PACKAGE}/scenes/**/*.py", "hil/render_scene.sh"),
    "draw": (f"{_PACKAGE}/paths/*.py", *TRANSFORM_SOURCES),
    "transform": TRANSFORM_SOURCES,
    "judge": (
        f"{_PACKAGE}/common/*.py",
        f"{_PACKAGE}/judge/*.py",
        f"{_PACKAGE}/campaigns/measures.py",
        "platform/transport/client/python/polhode_bus/*.py",
    ),
}


@dataclass(frozen=True)
class Chain:
    """One run and its tasks in the order in which they need each other; those of a folder that is there have no render, those of a
    path are drawn instead."""

    run: Run
    sequence_key: str
    tasks: tuple[Task, ...]
    time: Task
    limit: Task | None = None  # where the plan asks for it

    def task(self, kind: str) -> Task | None:
        return next((task for task in self.tasks if task.kind == kind), None)

    @property
    def missing_sequence(self) -> list[Task]:
        """The tasks that are still needed for the sequence itself, in order."""
        sequence = self.tasks[:-2]
        made = max((i for i, task in enumerate(sequence) if is_whole(task.place)), default=-1)
        return list(sequence[made + 1 :])

    @property
    def missing(self) -> list[Task]:
        """The tasks still to be done, in order; none where the last is done. What only leads to a result that is there is not."""
        replay, judge = self.tasks[-2:]
        limit = [] if self.limit is None or is_whole(self.limit.place) else [self.limit]
        if is_whole(judge.place):
            return [*self.missing_sequence, *limit] if limit else []
        return [*self.missing_sequence, *([] if is_whole(replay.place) else [replay]), judge, *limit]


def _scene_key(scene: Scene, sources: dict[str, str]) -> str:
    if scene.folder is not None:
        return digest("folder", folder_digest(scene.folder))
    if scene.path is not None:
        return digest("path", scene.path, sources["draw"])
    return digest("scene", scene.text, scene.variant, [file_digest(path) for path in model_files(scene)], sources["render"])


def model_files(scene: Scene) -> list[pathlib.Path]:
    """Files that a scene takes its body from, in the scene itself or in one of its variants; they stand beside its file."""
    raw = tomllib.loads(scene.text)
    tables = [raw, *raw.get("variants", {}).values()]
    names = {table.get("target", {}).get("path", "") for table in tables if isinstance(table.get("target", {}), dict)}
    folder = scene.file.parent if scene.file is not None else pathlib.Path()
    return sorted(folder / name for name in names if name and (folder / name).is_file())


def _named_files(config: pathlib.Path, settings: tuple[str, ...]) -> list[pathlib.Path]:
    """The files that a configuration names and whose content decides what the program does: the servicer's own in the view."""
    named = [setting.split("=", 1)[1].strip(" \"'") for setting in settings if setting.startswith("mask.file=")]
    name = named[-1] if named else tomllib.loads(config.read_text()).get("mask", {}).get("file", "")
    return [place for place in (config.parent / name, pathlib.Path(name)) if name and place.is_file()][:1]


class _Maker:
    """Makes the chains of a plan; what several runs share is one task."""

    def __init__(self, plan: Plan, store: Store, program: pathlib.Path):
        self.plan, self.store = plan, store
        self.program_key = file_digest(program)
        self.program = store.input(self.program_key, program.name)
        keep_copy(program, self.program)
        self.limit_key = self._limit_key()
        self.sources = {kind: source_digest(*patterns) for kind, patterns in SOURCES.items()}
        self.scene_keys = {scene.name: _scene_key(scene, self.sources) for scene in plan.scenes}
        self.configs = {setting.config: self._config(setting) for setting in plan.settings}

    def _limit_key(self) -> str | None:
        if not self.plan.limit:
            return None
        if not LIMIT_PROGRAM.is_file():
            raise BadInput(f"{LIMIT_PROGRAM}: not there; [judge] limit needs it, and tools/build.sh release builds it")
        key = file_digest(LIMIT_PROGRAM)
        keep_copy(LIMIT_PROGRAM, self.store.input(key, LIMIT_PROGRAM.name))
        return key

    def _config(self, setting: Setting) -> pathlib.Path:
        """A copy of the configuration; the file itself where it names others beside it."""
        if _named_files(setting.config, setting.settings):
            return setting.config
        copy = self.store.input(file_digest(setting.config), setting.config.name)
        keep_copy(setting.config, copy)
        return copy

    def _scene_file(self, scene: Scene, key: str) -> pathlib.Path:
        """A copy of the scene; the file itself where it names a body beside it."""
        if scene.file is not None and model_files(scene):
            return scene.file
        copy = self.store.input(key, f"{scene.name}.toml")
        if not copy.is_file():
            write_whole(copy, scene.text, ours=True)
        return copy

    def task(self, kind: str, key: str, name: str, place: pathlib.Path, **options: Any) -> Task:
        if kind in SOURCES:
            options["sources"] = (SOURCES[kind], self.sources[kind])
        return Task(kind, key, name, place, self.store.log(kind, key), options)

    def sequence(self, run: Run) -> tuple[list[Task], str, pathlib.Path]:
        """(tasks, key, folder) of a run's sequence."""
        scene, key, tasks = run.scene, self.scene_keys[run.scene.name], []
        folder = scene.folder
        if scene.path is not None:
            tasks.append(self.task("draw", key, scene.name, self.store.rendered(key), **scene.path))
            folder = tasks[-1].place
        elif folder is None:
            file = self._scene_file(scene, key)
            tasks.append(self.task("render", key, scene.name, self.store.rendered(key), file=str(file), variant=scene.variant))
            folder = tasks[-1].place
        if run.transform.steps:
            steps = list(run.transform.steps)
            key = digest("transform", key, steps, run.transform.seed, self.sources["transform"])
            tasks.append(
                self.task(
                    "transform",
                    key,
                    f"{scene.name}/{run.transform.name}",
                    self.store.transformed(key),
                    source=str(folder),
                    steps=steps,
                    seed=run.transform.seed,
                )
            )
            folder = tasks[-1].place
        return tasks, key, folder

    def chain(self, run: Run) -> Chain:
        tasks, sequence_key, folder = self.sequence(run)
        setting = run.setting
        replay_key = digest(
            "replay",
            sequence_key,
            self.program_key,
            setting.config.read_bytes(),
            list(setting.settings),
            *(file_digest(file) for file in _named_files(setting.config, setting.settings)),
        )
        options = {
            "program": str(self.program),
            "config": str(self.configs[setting.config]),
            "settings": list(setting.settings),
            "sequence": str(folder),
            "timeout_s": self.plan.replay_timeout_s,
        }
        replay = self.task("replay", replay_key, run.name, self.store.run(replay_key), **options)
        judge_key = digest("judge", replay_key, self.plan.shape, self.sources["judge"])
        judge = self.task(
            "judge", judge_key, run.name, self.store.result(judge_key), run=str(replay.place), sequence=str(folder), shape=self.plan.shape
        )
        return Chain(
            run,
            sequence_key,
            (*tasks, replay, judge),
            self.task("time", replay_key, run.name, self.store.time(replay_key), **options),
            self._limit(run, sequence_key, options),
        )

    def _limit(self, run: Run, sequence_key: str, options: dict[str, Any]) -> Task | None:
        """Of the sequence and the configuration alone, so that other programs find it there."""
        if self.limit_key is None:
            return None
        key = digest("limit", sequence_key, self.limit_key, run.setting.config.read_bytes(), list(run.setting.settings))
        return self.task(
            "limit",
            key,
            run.name,
            self.store.limit(key),
            **(options | {"program": str(self.store.input(self.limit_key, LIMIT_PROGRAM.name))}),
        )


def open_book(plan: Plan, store: Store, program: pathlib.Path) -> list[Chain]:
    """The chains of all runs in the plan's order; writes the drawn scenes and the book into the campaign's folder."""
    if not program.is_file():
        raise BadInput(f"{program}: not there or not a program; build it first")
    claim_folder(store.out, ".polhode-campaign", BOOK_FILE)
    for scene in plan.scenes:
        if scene.text and scene.file is None:
            write_whole(store.out / "scenes" / f"{scene.name}.toml", scene.text, ours=True)
    maker = _Maker(plan, store, program.resolve())
    chains = [maker.chain(run) for run in plan.runs]
    write_whole(
        store.out / BOOK_FILE,
        json.dumps(
            {
                "plan": plan.name,
                "program": str(program),
                "program_key": maker.program_key,
                "judge_key": maker.sources["judge"],
                "cache": str(store.cache),
                "draws": list(plan.draws),
                "runs": [_entry(chain, plan) for chain in chains],
            },
            indent=1,
        )
        + "\n",
        ours=True,
    )
    return chains


def _entry(chain: Chain, plan: Plan) -> dict[str, Any]:
    judge = chain.task("judge")
    assert judge is not None, "every chain ends with it"
    return {
        "scene": chain.run.scene.name,
        "transform": chain.run.transform.name,
        "setting": chain.run.setting.name,
        "result": judge.key,
        "time": chain.time.key if plan.time_alone else None,
        "limit": chain.limit.key if chain.limit is not None else None,
        "run": judge.options["run"],
        "sequence": judge.options["sequence"],
        "sequence_key": chain.sequence_key,
    }


def read_book(folder: pathlib.Path) -> dict[str, Any]:
    path = folder / BOOK_FILE
    try:
        book: dict[str, Any] = json.loads(path.read_text())
        return book
    except FileNotFoundError:
        raise BadInput(f"{folder}: no campaign's folder: {BOOK_FILE} is missing") from None
    except ValueError as problem:
        raise BadInput(f"{path}: {problem}") from None
