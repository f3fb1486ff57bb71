"""Another camera for the same light: shaken, turned away, read row by row, or mirrored; truth is moved with it.

A camera that turns about its own centre sees the same rays in other pixels, so a turn is exact. Rows that are read later
see the body where it is by then: their pixels are moved by the motion of the mesh's points.
"""

from dataclasses import replace

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from polhode_ground.common.errors import BadInput
from polhode_ground.common.fault_log import LogEntry
from polhode_ground.common.sequence import Camera
from polhode_ground.judge.align import rotations
from polhode_ground.transforms.footage import Footage, Shot

MESH_SAMPLES = 60_000


def _rays(camera: Camera) -> np.ndarray:
    """Unit-depth rays [H,W,3] of the pixels, distortion taken out."""
    u, v = np.meshgrid(np.arange(camera.width_px, dtype=np.float64), np.arange(camera.height_px, dtype=np.float64))
    fu, fv, cu, cv = camera.intrinsics_px
    matrix = np.array([[fu, 0, cu], [0, fv, cv], [0, 0, 1]])
    xy = cv2.undistortPoints(np.stack([u, v], axis=-1).reshape(-1, 1, 2), matrix, camera.distortion)
    return np.concatenate([xy.reshape(*u.shape, 2), np.ones((*u.shape, 1))], axis=-1)


def _sampled(gray: np.ndarray, source_px: np.ndarray) -> np.ndarray:
    """gray at pixels [H,W,2]; black outside."""
    maps = np.where(np.isfinite(source_px), source_px, -10.0).astype(np.float32)
    return cv2.remap(gray, maps[..., 0], maps[..., 1], cv2.INTER_CUBIC, borderMode=cv2.BORDER_CONSTANT, borderValue=0)


def _turned(shot: Shot, camera: Camera, rays: np.ndarray, turn: Rotation, known: bool) -> Shot:
    """The shot as a camera sees it that is turned: new components = turn * old ones. The servicer knows of it, or not."""

    def change(gray):
        old_rays = turn.inv().apply(rays.reshape(-1, 3))
        return _sampled(gray, camera.project(old_rays).reshape(*rays.shape[:2], 2))

    q_CT = (turn * rotations(shot.q_CT)).as_quat(scalar_first=True) if np.isfinite(shot.q_CT).all() else shot.q_CT
    q_IC = shot.q_IC if shot.q_IC is not None else np.array([1.0, 0.0, 0.0, 0.0])
    if known:
        q_IC = (rotations(q_IC) * turn.inv()).as_quat(scalar_first=True)
    return replace(shot.redrawn(change), q_CT=q_CT, p_CT=turn.apply(shot.p_CT), v_C=turn.apply(shot.v_C), q_IC=q_IC if known else shot.q_IC)


def shake(footage: Footage, options: dict, seed: int) -> Footage:
    """Small turns of the camera, new in each frame, that the servicer knows nothing of."""
    rng, rays = np.random.default_rng([seed, 1]), _rays(footage.camera)
    angles_rad = rng.normal(0, options["sigma_px"] / footage.camera.intrinsics_px[0], (len(footage.shots), 3))
    shots = [
        _turned(shot, footage.camera, rays, Rotation.from_rotvec(angle), known=False) for shot, angle in zip(footage.shots, angles_rad)
    ]
    log = [
        LogEntry(
            frame, shot.timestamp_ns, "shake", "turned by {:.2f}, {:.2f}, {:.2f} px".format(*(angle * footage.camera.intrinsics_px[0]))
        )
        for frame, (shot, angle) in enumerate(zip(footage.shots, angles_rad))
    ]
    return footage.changed(shots, log)


def leaving(footage: Footage, options: dict, seed: int) -> Footage:
    """The camera turns aside until the target is out of the picture, and back; the servicer knows how it turned."""
    camera, inside = footage.camera, footage.ramps(options)
    # The whole width aside: nothing that was in the picture is left in it.
    aside_rad = 2 * np.arctan(0.5 * camera.width_px / camera.intrinsics_px[0]) * (0.5 - 0.5 * np.cos(np.pi * inside))
    rays, shots, log = _rays(camera), [], []
    for frame, (shot, angle) in enumerate(zip(footage.shots, aside_rad)):
        shots.append(_turned(shot, camera, rays, Rotation.from_rotvec([0, angle, 0]), known=True))
        if inside[frame] == 1:
            log.append(LogEntry(frame, shot.timestamp_ns, "leaving", "target out of the picture"))
    return footage.changed(shots, log)


def _flow_px(footage: Footage, points_T: np.ndarray, shot: Shot, later: Shot, part: float) -> np.ndarray:
    """Motion [H,W,2] of the target's pixels in `part` of the time to the next shot; spread over the picture around it."""
    camera = footage.camera
    turn = (rotations(later.q_CT) * rotations(shot.q_CT).inv()).as_rotvec()
    p_C = rotations(shot.q_CT).apply(points_T)
    moved = Rotation.from_rotvec(part * turn).apply(p_C) + shot.p_CT + part * (later.p_CT - shot.p_CT)
    p_C = p_C + shot.p_CT
    now, then = camera.project(p_C), camera.project(moved)
    inside = np.isfinite(now).all(axis=1) & (now >= 0).all(axis=1) & (now < [camera.width_px - 1, camera.height_px - 1]).all(axis=1)
    order = np.flatnonzero(inside)[np.argsort(-p_C[inside, 2])]  # the nearest points are written last
    cell = np.rint(now[order]).astype(int)
    flow = np.zeros((camera.height_px, camera.width_px, 2), dtype=np.float32)
    weight = np.zeros((camera.height_px, camera.width_px), dtype=np.float32)
    flow[cell[:, 1], cell[:, 0]] = (then - now)[order]
    weight[cell[:, 1], cell[:, 0]] = 1
    wide = [cv2.GaussianBlur(image, (0, 0), 3.0) for image in (flow[..., 0] * weight, flow[..., 1] * weight, weight)]
    return np.stack(wide[:2], axis=-1) / np.maximum(wide[2], 1e-6)[..., None]


def _read_by_rows(footage, points_T, shot, later, readout_part, gray):
    """Rows below the middle see the body later than mid-exposure, rows above it earlier."""
    height, width = gray.shape
    flow = _flow_px(footage, points_T, shot, later, part=0.1) / 0.1
    v, u = np.mgrid[0:height, 0:width].astype(np.float64)
    delay = readout_part * ((v + 0.5) / height - 0.5)
    return _sampled(gray, np.stack([u, v], axis=-1) - delay[..., None] * flow)


def rolling_shutter(footage: Footage, options: dict, seed: int) -> Footage:
    """Rows are exposed one after the other; reading all takes `readout_part` of the time between frames.

    With `stated` sensor.yaml says so.
    """
    import trimesh

    if footage.model is None or len(footage.shots) < 2 or not all(np.isfinite(shot.q_CT).all() for shot in footage.shots):
        raise BadInput("rolling_shutter: needs model.ply and the truth of every frame, of two frames or more")
    mesh = trimesh.load(footage.model, process=False)
    points_T = np.asarray(trimesh.sample.sample_surface(mesh, MESH_SAMPLES, seed=seed)[0]) * (MIRROR if footage.mirror else 1.0)
    readout, shots = options["readout_part"], []
    following = [*footage.shots[1:], None]
    for shot, later in zip(footage.shots, following):
        if later is None:  # goes on as it came
            before = footage.shots[-2]
            back = rotations(shot.q_CT) * rotations(before.q_CT).inv()
            later = replace(shot, q_CT=(back * rotations(shot.q_CT)).as_quat(scalar_first=True), p_CT=2 * shot.p_CT - before.p_CT)
        shots.append(shot.redrawn(lambda gray, a=shot, b=later: _read_by_rows(footage, points_T, a, b, readout, gray)))
    camera = footage.camera
    if options["stated"]:
        camera = replace(camera, line_time_ns=readout * footage.period_s * 1e9 / camera.height_px)
    said = f"all frames: read in {readout} of a period"
    return footage.changed(shots, [LogEntry(0, shots[0].timestamp_ns, "rolling_shutter", said)], camera=camera)


def zoom(footage: Footage, options: dict, seed: int) -> Footage:
    """The focal length grows evenly to `factor` times itself over the sequence; sensor.yaml states the first one."""
    cu_px, cv_px = footage.camera.intrinsics_px[2:]

    def change(gray, factor):
        v, u = np.mgrid[0 : gray.shape[0], 0 : gray.shape[1]].astype(np.float64)
        return _sampled(gray, np.stack([cu_px + (u - cu_px) / factor, cv_px + (v - cv_px) / factor], axis=-1))

    factors = np.geomspace(1.0, options["factor"], len(footage.shots))
    shots = [shot.redrawn(lambda gray, factor=factor: change(gray, factor)) for shot, factor in zip(footage.shots, factors)]
    return footage.changed(shots, [LogEntry(0, shots[0].timestamp_ns, "zoom", f"to {options['factor']} times the focal length at the end")])


MIRROR = np.array([-1.0, 1.0, 1.0])


def _mirrored_shot(shot: Shot) -> Shot:
    """R' = F R F and p' = F p with F = diag(-1, 1, 1): a body that is the mirror image, turning the other way about y and z."""
    q_CT = shot.q_CT * [1, 1, -1, -1]
    return replace(
        shot.redrawn(lambda gray: np.ascontiguousarray(gray[:, ::-1])),
        q_CT=q_CT,
        p_CT=MIRROR * shot.p_CT,
        v_C=MIRROR * shot.v_C,
        w_T=-MIRROR * shot.w_T,
        q_IC=None if shot.q_IC is None else shot.q_IC * [1, 1, -1, -1],
    )


def _mirrored_scene(scene: dict) -> dict:
    """Inertia and bounding box of the mirror image; known lengths, which name pixels, are left out."""
    scene = {key: value for key, value in scene.items() if key not in ("known_lengths", "fingerprint")}
    if "bounding_box_T_m" in scene:
        low, high = np.array(scene["bounding_box_T_m"])
        scene["bounding_box_T_m"] = [[-high[0], *low[1:].tolist()], [-low[0], *high[1:].tolist()]]
    motion = dict(scene.get("scene", {}).get("motion") or {})
    if np.ndim(motion.get("inertia_kg_m2")) == 2:
        flip = np.diag(MIRROR)
        motion["inertia_kg_m2"] = (flip @ np.array(motion["inertia_kg_m2"]) @ flip).tolist()
    if "centre_of_mass_G_m" in motion:
        motion["centre_of_mass_G_m"] = (MIRROR * motion["centre_of_mass_G_m"]).tolist()
    if motion:
        scene["scene"] = scene["scene"] | {"motion": motion}
    return scene


def mirrored(footage: Footage, options: dict, seed: int) -> Footage:
    """Left and right change places: another body and another motion, as good as the first."""
    fu, fv, cu, cv = footage.camera.intrinsics_px
    camera = replace(
        footage.camera,
        intrinsics_px=np.array([fu, fv, footage.camera.width_px - 1 - cu, cv]),
        distortion=footage.camera.distortion * [1, 1, 1, -1],
    )
    return footage.changed(
        [_mirrored_shot(shot) for shot in footage.shots],
        [LogEntry(0, footage.shots[0].timestamp_ns, "mirrored", "all frames")],
        camera=camera,
        scene=_mirrored_scene(footage.scene),
        mirror=not footage.mirror,
    )
