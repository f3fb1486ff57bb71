"""Estimates the focal length of a folder of pictures by pycolmap. Runs in COLMAP's own environment.

Call: focal_worker.py JOB.json with {"images", "names", "work", "focal_px", "centre_px", "k1_k2", "result"}.
Writes RESULT: {"placed", "points", "focal_px", "sigma_px", "residual_px"}, or {"placed": 0} where nothing was reconstructed.
"""

import json
import math
import pathlib
import shutil
import sys

import pycolmap

# Residuals larger than this hardly count (Cauchy): a wrong match must not pull the focal length.
ROBUST_PX = 0.5
TRACK_MIN = 3  # a point in two pictures tells of their pose only
# Each observation is taken to be wrong by 1 px, two to three times its residual: along a track the errors are alike.
NOISE_PX = 1.0
# Where the costs are compared that give the sigma: far enough to see a difference, near enough for a parabola.
PROBE = 0.01


def reconstruct(job: dict):
    """COLMAP's largest model with the focal length free; None where there is none."""
    work = pathlib.Path(job["work"])
    shutil.rmtree(work, ignore_errors=True)
    (work / "models").mkdir(parents=True)
    database = work / "database.db"
    reader = pycolmap.ImageReaderOptions()
    reader.camera_model = "RADIAL"  # one focal length: two that are free can hide a wrong motion
    centre = [value + 0.5 for value in job["centre_px"]]  # COLMAP's pixel centres lie at + 0.5
    params = [job["focal_px"], *centre, *job["k1_k2"]]
    reader.camera_params = ",".join(f"{value:.17g}" for value in params)
    pycolmap.extract_features(
        database,
        job["images"],
        image_names=job["names"],
        camera_mode=pycolmap.CameraMode.SINGLE,
        reader_options=reader,
        device=pycolmap.Device.cpu,
    )
    pycolmap.match_exhaustive(database, device=pycolmap.Device.cpu)
    options = pycolmap.IncrementalPipelineOptions()
    options.ba_refine_focal_length = True
    options.ba_refine_principal_point = False
    options.ba_refine_extra_params = False
    options.mapper.abs_pose_refine_focal_length = False
    options.random_seed = 1
    models = pycolmap.incremental_mapping(database, job["images"], work / "models", options=options).values()
    return max(models, key=lambda model: model.num_reg_images(), default=None)


def adjust(model, free: bool) -> float:
    """Bundle adjustment with a robust cost; @return the cost at its end [px^2]."""
    options = pycolmap.BundleAdjustmentOptions()
    options.refine_focal_length = free
    options.refine_principal_point = options.refine_extra_params = options.print_summary = False
    options.ceres.loss_function_type = pycolmap.LossFunctionType.CAUCHY
    options.ceres.loss_function_scale = ROBUST_PX
    config = pycolmap.BundleAdjustmentConfig()
    for number in model.reg_image_ids():
        config.add_image(number)
    config.fix_gauge(pycolmap.BundleAdjustmentGauge.TWO_CAMS_FROM_WORLD)
    return pycolmap.create_default_bundle_adjuster(options, config, model).solve().ceres_summary.final_cost


def focal_of(model) -> float:
    return float(next(iter(model.cameras.values())).params[0])


def cost_beside(model, factor: float) -> float:
    """The least cost with the focal length held at factor times its own."""
    other = pycolmap.Reconstruction(model)
    for camera in other.cameras.values():
        params = camera.params
        params[0] *= factor
        camera.params = params
    return adjust(other, False)


def sigma_px(model, cost: float) -> float | None:
    """From how the least cost rises to both sides: half a noise variance at one sigma. None where it does not rise."""
    rise = 0.5 * (cost_beside(model, 1 - PROBE) + cost_beside(model, 1 + PROBE)) - cost
    return PROBE * focal_of(model) * math.sqrt(0.5 * NOISE_PX**2 / rise) if rise > 0 else None


def main() -> None:
    job = json.loads(pathlib.Path(sys.argv[1]).read_text())
    pycolmap.logging.minloglevel = pycolmap.logging.ERROR.value
    model, result = reconstruct(job), {"placed": 0}
    if model is not None:
        for number in [number for number, point in model.points3D.items() if point.track.length() < TRACK_MIN]:
            model.delete_point3D(number)
        cost = adjust(model, True)
        result = {
            "placed": model.num_reg_images(),
            "points": model.num_points3D(),
            "focal_px": focal_of(model),
            "sigma_px": sigma_px(model, cost),
            "residual_px": model.compute_mean_reprojection_error(),
        }
    pathlib.Path(job["result"]).write_text(json.dumps(result))


if __name__ == "__main__":
    main()
