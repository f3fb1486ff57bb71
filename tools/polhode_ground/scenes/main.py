"""Entry point inside Blender, whose Python has no environment of ours: hil/render_scene.sh names the package's folder in PYTHONPATH.

Arguments: -- SCENE.toml OUT [--variant NAME] [--threads N] [--check]. Exit 0, 1 failed, 2 refused."""

import os
import sys

USAGE = "usage: render_scene.sh SCENE.toml OUT [--variant NAME] [--threads N] [--check]"
THREADS = 2


def parse(arguments):
    """(scene path, out folder, variant or None, threads, check only) or None if unusable."""
    variant, threads, check_only, rest = None, THREADS, False, []
    arguments = list(arguments)
    while arguments:
        word = arguments.pop(0)
        if word == "--variant" and arguments:
            variant = arguments.pop(0)
        elif word == "--threads" and arguments and arguments[0].isdigit() and int(arguments[0]) > 0:
            threads = int(arguments.pop(0))
        elif word == "--check":
            check_only = True
        elif word.startswith("-"):
            return None
        else:
            rest.append(word)
    return (rest[0], rest[1], variant, threads, check_only) if len(rest) == 2 else None


def run(arguments, report):
    """Renders as the arguments say; returns the exit status."""
    from polhode_ground.scenes import blender_scene, mesh, pipeline, scene_file

    parsed = parse(arguments)
    if parsed is None:
        report(USAGE)
        return 2
    path, out, variant, blender_scene.threads, check_only = parsed
    try:
        scene = scene_file.load(path, variant)
        plan = pipeline.Plan(scene)
        if scene["target"]["kind"] == "file":
            blender_scene.reset(scene["render"]["samples"])
        parts, materials, known = pipeline.build_target(scene)
        pipeline.check_view(plan, mesh.all_vertices(parts))
        if check_only:
            report(f"{path}: fine")
            return 0
        pipeline.prepare_folder(out, plan, parts, known)
    except scene_file.SceneError as error:
        report(f"render_scene: {error}")
        return 2
    pipeline.render(plan, parts, materials, out, report)
    return 0


def main():
    """Keeps stderr for our own lines and sends Blender's chatter away."""
    own = os.fdopen(os.dup(2), "w", buffering=1)
    quiet = os.open(os.devnull, os.O_WRONLY)
    if not os.environ.get("POLHODE_BLENDER_LOG"):
        os.dup2(quiet, 1)
        os.dup2(quiet, 2)
    try:
        status = run(sys.argv[sys.argv.index("--") + 1 :], lambda text: print(text, file=own))
    except ImportError as error:
        print(f"render_scene: {error}; Debian 12: tools/setup.sh renderer installs Blender 3.4 and python3-numpy", file=own)
        status = 2
    except Exception as error:  # The last line of defence: say it in one line and fail.
        print(f"render_scene: {type(error).__name__}: {error}", file=own)
        if os.environ.get("POLHODE_BLENDER_LOG"):
            raise
        status = 1
    own.flush()
    os._exit(status)
