"""Makes a changed copy of a sequence, its truth kept right, and logs in OUT/faults.csv what was done to which frame.

Examples:
  hil/transform.py --list
  hil/transform.py SEQ OUT --kind jpeg --set jpeg.quality=30
"""

import argparse
import pathlib
import tomllib

from polhode_ground.common.ranges import whole
from polhode_ground.common.venv import enter_venv, run_main


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.strip(), formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequence", metavar="SEQ", type=pathlib.Path, nargs="?", help="sequence folder")
    parser.add_argument("out", metavar="OUT", type=pathlib.Path, nargs="?", help="folder to write, not there yet")
    parser.add_argument("--kind", action="append", default=[], help="what to do; several are done one after the other")
    parser.add_argument("--set", metavar="KIND.OPTION=VALUE", action="append", default=[], help="as in --set jpeg.quality=30")
    parser.add_argument("--seed", type=whole(0), default=1)
    parser.add_argument("--list", action="store_true", help="print all kinds with their options and end")
    return parser.parse_args()


def listing() -> str:
    from polhode_ground.transforms.table import KINDS

    lines = []
    for name, kind in KINDS.items():
        lines.append(f"{name}: {kind.what}")
        lines += [f"    {key} = {option.default}  ({option.least} .. {option.most}) {option.what}" for key, option in kind.options.items()]
    return "\n".join(lines)


def steps_of(kinds: list[str], settings: list[str]) -> list[dict]:
    from polhode_ground.common.errors import BadInput

    steps = [{"kind": kind} for kind in kinds]
    for setting in settings:
        name, _, text = setting.partition("=")
        kind, _, option = name.partition(".")
        chosen = [step for step in steps if step["kind"] == kind]
        if not chosen or option == "kind":
            raise BadInput(f"--set {setting}: no option of a --kind that is given")
        try:
            value = tomllib.loads(f"value = {text}")["value"]
        except tomllib.TOMLDecodeError:
            raise BadInput(f"--set {setting}: '{text}' is not a number") from None
        for step in chosen:
            step[option] = value
    return steps


def main() -> int:
    options = arguments()
    from polhode_ground.common.errors import BadInput
    from polhode_ground.transforms.table import transform

    if options.list:
        print(listing())
        return 0
    if options.sequence is None or options.out is None or not options.kind:
        raise BadInput("SEQ, OUT and at least one --kind are needed; --list prints the kinds")
    if options.out.exists():
        raise BadInput(f"{options.out}: is there already")
    lines = transform(options.sequence, options.out, steps_of(options.kind, options.set), options.seed)
    print(f"{options.out}: written; {lines} lines in {options.out / 'faults.csv'} say what was done")
    return 0


def command() -> None:
    enter_venv()
    run_main(main, "transform")
