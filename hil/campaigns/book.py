"""The campaign's book: every run of a plan with the keys of what it is made of and the tasks that make it.

A key names content. It holds the keys of what goes in, the options, and the sources of the code that does the work, so
that a rerun finds what is there and makes the rest: a new judge judges anew, a new program replays anew and keeps scenes.
"""

import json
import pathlib
import tomllib
from dataclasses import dataclass

from campaigns.plan import Plan, Run, Scene
from campaigns.store import Store, digest, file_digest, folder_digest, is_whole, source_digest, write_whole
from campaigns.tasks import Task
from judge.errors import BadInput

BOOK_FILE = "campaign.json"


@dataclass(frozen=True)
class Sources:
    """Hashes of the code behind each kind of task."""

    generator: str
    transforms: str
    judge: str

    @staticmethod
    def now() -> "Sources":
        return Sources(source_digest("hil/scenes/generator/**/*.py", "hil/render_scene.sh"),
                       source_digest("hil/transforms/*.py", "hil/judge/sequence.py", "hil/judge/tables.py", "hil/judge/align.py",
                                     "hil/judge/fault_log.py"),
                       source_digest("hil/judge/*.py", "hil/campaigns/measures.py", "platform/transport/client/python/polhode_bus/*.py"))


@dataclass(frozen=True)
class Chain:
    """One run and its tasks in the order in which they need each other; those of a folder that is there have no render."""

    run: Run
    tasks: tuple[Task, ...]
    time: Task

    def task(self, kind: str) -> Task | None:
        return next((task for task in self.tasks if task.kind == kind), None)

    @property
    def missing(self) -> list[Task]:
        """The tasks still to be done, in order; none where the last is done. What only leads to a result that is there is not."""
        *sequence, replay, judge = self.tasks
        if is_whole(judge.place):
            return []
        made = max((i for i, task in enumerate(sequence) if is_whole(task.place)), default=-1)
        return [*sequence[made + 1 :], *([] if is_whole(replay.place) else [replay]), judge]


def _scene_key(scene: Scene, sources: Sources) -> str:
    if scene.folder is not None:
        return digest("folder", folder_digest(scene.folder))
    return digest("scene", scene.text, scene.variant, _model_digest(scene), sources.generator)


def _model_digest(scene: Scene) -> str:
    """Of the file that a scene takes its body from, which stands beside the scene's."""
    path = tomllib.loads(scene.text).get("target", {}).get("path", "")
    return file_digest(scene.file.parent / path) if path and scene.file is not None else ""


class _Maker:
    """Makes the chains of a plan; what several runs share is one task."""

    def __init__(self, plan: Plan, store: Store, program: pathlib.Path):
        self.plan, self.store, self.program = plan, store, program
        self.sources, self.program_key = Sources.now(), file_digest(program)
        self.scene_keys = {scene.name: _scene_key(scene, self.sources) for scene in plan.scenes}

    def task(self, kind: str, key: str, name: str, place: pathlib.Path, **options) -> Task:
        return Task(kind, key, name, place, self.store.log(kind, key), options)

    def sequence(self, run: Run) -> tuple[list[Task], str, pathlib.Path]:
        """(tasks, key, folder) of a run's sequence."""
        scene, key, tasks = run.scene, self.scene_keys[run.scene.name], []
        folder = scene.folder
        if folder is None:
            file = scene.file or self.store.out / "scenes" / f"{scene.name}.toml"
            tasks.append(self.task("render", key, scene.name, self.store.rendered(key), file=str(file), variant=scene.variant))
            folder = tasks[-1].place
        if run.transform.steps:
            steps = list(run.transform.steps)
            key = digest("transform", key, steps, run.transform.seed, self.sources.transforms)
            tasks.append(self.task("transform", key, f"{scene.name}/{run.transform.name}", self.store.transformed(key), source=str(folder),
                                   steps=steps, seed=run.transform.seed))
            folder = tasks[-1].place
        return tasks, key, folder

    def chain(self, run: Run) -> Chain:
        tasks, sequence_key, folder = self.sequence(run)
        setting = run.setting
        replay_key = digest("replay", sequence_key, self.program_key, setting.config.read_bytes(), list(setting.settings))
        options = {"program": str(self.program), "config": str(setting.config), "settings": list(setting.settings),
                   "sequence": str(folder), "timeout_s": self.plan.replay_timeout_s}
        replay = self.task("replay", replay_key, run.name, self.store.run(replay_key), **options)
        judge_key = digest("judge", replay_key, self.plan.shape, self.sources.judge)
        judge = self.task("judge", judge_key, run.name, self.store.result(judge_key), run=str(replay.place), sequence=str(folder),
                          shape=self.plan.shape)
        return Chain(run, (*tasks, replay, judge), self.task("time", replay_key, run.name, self.store.time(replay_key), **options))


def open_book(plan: Plan, store: Store, program: pathlib.Path) -> list[Chain]:
    """The chains of all runs in the plan's order; writes the drawn scenes and the book into the campaign's folder."""
    if not program.is_file():
        raise BadInput(f"{program}: not there or not a program; build it first")
    store.out.mkdir(parents=True, exist_ok=True)
    for scene in plan.scenes:
        if scene.folder is None and scene.file is None:
            write_whole(store.out / "scenes" / f"{scene.name}.toml", scene.text)
    maker = _Maker(plan, store, program.resolve())
    chains = [maker.chain(run) for run in plan.runs]
    write_whole(store.out / BOOK_FILE, json.dumps({
        "plan": plan.name, "program": str(program), "program_key": maker.program_key, "cache": str(store.cache),
        "draws": list(plan.draws), "runs": [_entry(chain, plan) for chain in chains]}, indent=1) + "\n")
    return chains


def _entry(chain: Chain, plan: Plan) -> dict:
    judge = chain.task("judge")
    return {"scene": chain.run.scene.name, "transform": chain.run.transform.name, "setting": chain.run.setting.name,
            "result": judge.key, "time": chain.time.key if plan.time_alone else None,
            "run": judge.options["run"], "sequence": judge.options["sequence"]}


def read_book(folder: pathlib.Path) -> dict:
    path = folder / BOOK_FILE
    try:
        return json.loads(path.read_text())
    except FileNotFoundError:
        raise BadInput(f"{folder}: no campaign's folder: {BOOK_FILE} is missing") from None
    except ValueError as problem:
        raise BadInput(f"{path}: {problem}") from None
