"""COLMAP as a peer: prepares its input, starts it in its own process, writes its answer as an output folder."""

import csv
import hashlib
import json
import pathlib
import shutil
import subprocess
import sys
from typing import Any

from polhode_ground.common.errors import BadInput
from polhode_ground.common.levels import read_octets, viewable
from polhode_ground.common.replay import APART
from polhode_ground.common.sequence import Camera, Sequence, read_json
from polhode_ground.common.tables import POSITION, QUATERNION, Motion, where_also
from polhode_ground.common.venv import REPOSITORY
from polhode_ground.common.whole_file import claim_folder
from polhode_ground.judge.aligned import align_each
from polhode_ground.judge.metrics import attitude
from polhode_ground.judge.run import Run

COLMAP_VENV = REPOSITORY / ".venv-colmap"
SET_UP = REPOSITORY / "tools" / "setup.sh"
# All pairs cost the square of the frames: 150 frames are 11,175 pairs, some minutes on two cores.
EXHAUSTIVE_FRAMES_MAX = 150


def ensure_venv() -> pathlib.Path:
    """Python of COLMAP's own virtual environment, made on first use; BadInput where it can't be made."""
    done = subprocess.run([SET_UP, "colmap"], stdout=sys.stderr)
    if done.returncode != 0:
        raise BadInput(f"{COLMAP_VENV.name}: can't be set up: {SET_UP.relative_to(REPOSITORY)} colmap ended with {done.returncode}")
    return COLMAP_VENV / "bin" / "python3"


def colmap_params(camera: Camera) -> list[float]:
    """fx, fy, cx, cy, k1, k2, p1, p2 of COLMAP's OPENCV model, whose pixel centres lie at + 0.5."""
    fu, fv, cu, cv = (float(value) for value in camera.intrinsics_px)
    return [fu, fv, cu + 0.5, cv + 0.5, *(float(value) for value in camera.distortion)]


def prepare_images(sequence: Sequence, folder: pathlib.Path) -> list[str]:
    """8-bit pictures under names that sort by time: links where the file serves as it is, else converted copies."""
    from PIL import Image

    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    names = []
    for index, filename in enumerate(sequence.filenames):
        source = sequence.frame_path(index)
        suffix = pathlib.Path(filename).suffix.lower()
        plain = viewable(read_octets(source)) is not None and suffix in (".png", ".jpg", ".jpeg") and not sequence.mosaic
        name = f"{index:06d}{suffix if plain else '.png'}"
        if plain:
            (folder / name).symlink_to(source.resolve())
        else:
            Image.fromarray(sequence.read_gray(index)).save(folder / name)
        names.append(name)
    return names


def run_colmap(sequence: Sequence, out: pathlib.Path) -> dict[str, Any]:
    """Runs COLMAP at low priority; its result as the worker wrote it. The log is out/colmap.log."""
    python = ensure_venv()
    names = prepare_images(sequence, out / "images")
    job = {
        "images": str(out / "images"),
        "names": names,
        "work": str(out / "work"),
        "camera_params": colmap_params(sequence.camera),
        "result": str(out / "colmap.json"),
        "matcher": "exhaustive" if len(names) <= EXHAUSTIVE_FRAMES_MAX else "sequential",
    }
    (out / "job.json").write_text(json.dumps(job, indent=1))
    worker = pathlib.Path(__file__).with_name("colmap_worker.py")
    print(f"running COLMAP on {len(names)} frames ({job['matcher']} matching), log in {out / 'colmap.log'}", file=sys.stderr)
    with open(out / "colmap.log", "w") as log:
        done = subprocess.run(
            [*APART, "nice", "-n", "10", str(python), str(worker), str(out / "job.json")], stdout=log, stderr=subprocess.STDOUT
        )
    if done.returncode != 0:
        last = (out / "colmap.log").read_text(errors="replace").strip().splitlines()[-1:]
        raise BadInput(f"{out / 'colmap.log'}: COLMAP ended with {done.returncode}: {' '.join(last)}")
    return read_json(out / "colmap.json")


def _write_motion(path: pathlib.Path, names: list[str], sequence: Sequence, poses: dict[str, Any]) -> None:
    """One model's poses in the columns of motion.csv; frames that it lacks have no pose."""
    header = ["frame", "timestamp_ns", "mode", "pose_valid", "rate_valid", "velocity_valid", "scale_known", *QUATERNION, *POSITION]
    with open(path, "w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(header)
        for index, (name, timestamp_ns) in enumerate(zip(names, sequence.timestamp_ns)):
            pose = poses.get(name)
            values = [f"{x:.12g}" for x in (*pose["q"], *pose["p"])] if pose else [""] * 7
            writer.writerow([index, timestamp_ns, "TRACKING" if pose else "LOST", int(bool(pose)), 0, 0, 0, *values])


def write_output(sequence: Sequence, result: dict[str, Any], out: pathlib.Path) -> None:
    """COLMAP's answer in the files that the judge reads: motion_smoothed.csv (it sees all frames), cloud, summary.

    Where COLMAP fell apart into several models the largest is its answer; the others go to model_N/.
    """
    names = sorted(path.name for path in (out / "images").iterdir())
    _write_motion(out / "motion_smoothed.csv", names, sequence, result["poses"])
    for old in out.glob("model_*"):
        shutil.rmtree(old)
    for number, poses in enumerate(result.get("other_poses", []), start=2):
        (out / f"model_{number}").mkdir()
        _write_motion(out / f"model_{number}" / "motion_smoothed.csv", names, sequence, poses)
    cloud = out / "work" / "cloud.ply"
    if cloud.exists():
        shutil.copyfile(cloud, out / "cloud.ply")
    summary = {
        "program": f"COLMAP {result['version']}, {result['matcher']} matching",
        "models": result["models"],
        "points": result.get("points"),
        "mean_reprojection_error_px": result.get("mean_reprojection_error_px"),
        "sequence": str(sequence.folder),
        "frames": {"in": result["images"], "with_pose": len(result["poses"])},
        "cost": {"cpu_s": result["cpu_s"], "wall_s": result["wall_s"]},
        "memory": {"peak_resident_octets": round(result["peak_rss_mb"] * 2**20)},
    }
    (out / "summary.json").write_text(json.dumps(summary, indent=2) + "\n")


def fingerprint(sequence: Sequence) -> str:
    """Tells one sequence's frames and camera from another's of the same name: a reused result must be of these."""
    digest = hashlib.sha256()
    for path in (sequence.folder / "mav0/cam0/sensor.yaml", sequence.folder / "mav0/cam0/data.csv"):
        digest.update(path.read_bytes())
    for index in range(len(sequence.filenames)):
        digest.update(sequence.frame_path(index).read_bytes() if sequence.frame_path(index).exists() else b"")
    return digest.hexdigest()


def colmap_output(sequence: Sequence, out: pathlib.Path, again: bool = False) -> pathlib.Path:
    """COLMAP's output folder out, reused where it is there for these very frames, unless again."""
    claim_folder(out, ".polhode-colmap", "fingerprint")
    mark, wanted = out / "fingerprint", fingerprint(sequence)
    if again or not mark.exists() or mark.read_text() != wanted:
        mark.unlink(missing_ok=True)
        write_output(sequence, run_colmap(sequence, out), out)
        mark.write_text(wanted)
    return out


def attitude_on_shared_frames(run: Run, peer: Run, truth: Motion) -> dict[str, dict[str, Any]]:
    """Attitude errors of each motion file of a run, over the frames that the peer has a pose of, aligned over these alone."""
    result = {}
    for kind, motion in run.motions.items():
        parts = align_each(where_also(motion, peer.motions["smoothed"]), truth)
        if parts:
            result[kind] = attitude(parts) | {"frames": sum(len(part.rows_E) for part in parts)}
    return result
