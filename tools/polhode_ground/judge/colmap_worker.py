"""Runs COLMAP on a folder of 8-bit pictures with fixed intrinsics. Needs pycolmap; knows nothing of truth or judging.

Call: colmap_worker.py JOB.json, with {"images", "names", "work", "camera_params", "matcher", "result"}. Writes RESULT:
poses of the largest model as {"name": {"q": [w,x,y,z], "p": [x,y,z], "points": n}}, those of the others in the same form,
counts, CPU and wall time, memory.
"""

import json
import pathlib
import resource
import shutil
import sys
import time
from typing import Any

import pycolmap


def cpu_s() -> float:
    """User and system time of this process and of its ended children."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)


def extract_and_match(job: dict[str, Any], database: pathlib.Path) -> None:
    """Default SIFT features and matches; one OPENCV camera for all pictures."""
    reader = pycolmap.ImageReaderOptions()
    reader.camera_model = "OPENCV"
    reader.camera_params = ",".join(f"{value:.17g}" for value in job["camera_params"])
    pycolmap.extract_features(
        database,
        job["images"],
        image_names=job["names"],
        camera_mode=pycolmap.CameraMode.SINGLE,
        reader_options=reader,
        device=pycolmap.Device.cpu,
    )
    match = pycolmap.match_exhaustive if job["matcher"] == "exhaustive" else pycolmap.match_sequential
    match(database, device=pycolmap.Device.cpu)


def reconstruct(job: dict[str, Any], database: pathlib.Path, models: pathlib.Path) -> dict[int, Any]:
    """Incremental mapping with the intrinsics held; a fixed seed."""
    options = pycolmap.IncrementalPipelineOptions()
    options.ba_refine_focal_length = False
    options.ba_refine_principal_point = False
    options.ba_refine_extra_params = False
    options.mapper.abs_pose_refine_focal_length = False
    options.mapper.abs_pose_refine_extra_params = False
    options.random_seed = 1
    found: dict[int, Any] = pycolmap.incremental_mapping(database, job["images"], models, options=options)
    return found


def poses_of(model: Any) -> dict[str, Any]:
    """q (w,x,y,z) and p of every registered picture: p_C = R * p_W + p."""
    poses = {}
    for image in model.images.values():
        if not image.has_pose:
            continue
        pose = image.cam_from_world()
        x, y, z, w = pose.rotation.quat
        poses[image.name] = {"q": [w, x, y, z], "p": list(pose.translation), "points": int(image.num_points3D)}
    return poses


def main() -> None:
    job = json.loads(pathlib.Path(sys.argv[1]).read_text())
    work = pathlib.Path(job["work"])
    shutil.rmtree(work, ignore_errors=True)
    (work / "models").mkdir(parents=True)
    started_s, cpu_started_s = time.monotonic(), cpu_s()
    extract_and_match(job, work / "database.db")
    models = list(reconstruct(job, work / "database.db", work / "models").values())
    result = {
        "version": pycolmap.__version__,
        "matcher": job["matcher"],
        "images": len(job["names"]),
        "models": len(models),
        "wall_s": time.monotonic() - started_s,
        "cpu_s": cpu_s() - cpu_started_s,
        "peak_rss_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
        "poses": {},
    }
    if models:
        models.sort(key=lambda model: model.num_reg_images(), reverse=True)
        best = models[0]
        result |= {
            "poses": poses_of(best),
            "other_poses": [poses_of(model) for model in models[1:]],
            "points": best.num_points3D(),
            "mean_reprojection_error_px": best.compute_mean_reprojection_error(),
        }
        best.export_PLY(str(work / "cloud.ply"))
        result["camera_params"] = list(next(iter(best.cameras.values())).params)
    pathlib.Path(job["result"]).write_text(json.dumps(result))


if __name__ == "__main__":
    main()
