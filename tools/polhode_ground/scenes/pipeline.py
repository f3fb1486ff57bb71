"""One scene from file to folder: builds it, renders what is missing, writes what describes it."""

import hashlib
import json
import os
import sys
import time
from pathlib import Path

import numpy as np

from . import camera as camera_model
from . import mesh, noise, png, relative_motion, rigid_body, sensor, truth
from .materials import Material
from .rotations import quat_from_axis_angle, quat_to_matrix
from .scene_file import SceneError

# Counted up by whoever changes what the same scene looks like.
FORMAT = 1
LABORATORY_FORMAT = 2
# A window of more pixels is large: its frame gets no more samples than LARGE_WINDOW_WORK in all, but 3 for each of its
# pixels over all sub-frames, and its pixels share them (README, "Cost").
LARGE_WINDOW_PX = 412_000
LARGE_WINDOW_WORK = 4_400_000
LARGE_WINDOW_SAMPLES_MIN = 3


class Plan:
    """A checked scene with its times and truth: everything that is known before anything is drawn."""

    def __init__(self, scene):
        self.scene = scene
        times = scene["time"]
        count = times["frames"]
        start_ns = times["epoch_ns"] + round(times["start_s"] * 1e9)
        self.timestamps_ns = [start_ns + round(i * times["period_s"] * 1e9) for i in range(count)]
        self.offsets_s = self._sub_frame_offsets()
        mid_s = np.array([(stamp - times["epoch_ns"]) * 1e-9 for stamp in self.timestamps_ns])
        all_s = np.maximum(0.0, (mid_s[:, None] + self.offsets_s).ravel())
        order = np.argsort(all_s, kind="stable")
        self.history = self._camera_history(float(all_s.max()))
        try:
            motion = truth.motion_at(scene["motion"], self.history, all_s[order])
        except rigid_body.NotIntegrated as error:
            raise SceneError(f"motion.w0_T_deg_s: {error}") from None
        place = np.empty(len(order), dtype=int)
        place[order] = np.arange(len(order))
        # place[i, k]: row of sub-frame k of frame i; the middle one is the frame's truth.
        self.rows = place.reshape(count, len(self.offsets_s))
        self.sub_motion = motion
        keep = self.rows[:, len(self.offsets_s) // 2]
        self.motion = truth.Motion(
            mid_s,
            truth.continuous_signs(motion.q_CT[keep]),
            motion.p_CT_m[keep],
            motion.v_C_m_s[keep],
            motion.w_T_rad_s[keep],
            motion.q_IC[keep],
        )
        self.camera = self._camera()
        self.sensor = sensor.Sensor(**{k: scene["sensor"][k] for k in sensor.Sensor.__dataclass_fields__})

    def _sub_frame_offsets(self):
        """Times of the sub-frames about mid-exposure [s], an odd number so that the middle one is the truth."""
        exposure_s, count = self.scene["sensor"]["exposure_s"], self.scene["sensor"]["blur_samples"]
        if exposure_s == 0 or count == 1:
            return np.zeros(1)
        count += 1 - count % 2
        return ((np.arange(count) + 0.5) / count - 0.5) * exposure_s

    def _camera_history(self, end_s):
        settings = self.scene["camera"]
        if settings["attitude_history"]:
            return settings["attitude_history"]
        if any(settings["w_C_deg_s"]):
            steps = max(2, int(np.ceil(end_s)) + 1)
            return relative_motion.turning_history([1, 0, 0, 0], np.radians(settings["w_C_deg_s"]), np.linspace(0, end_s, steps))
        return []

    def _camera(self):
        settings = self.scene["camera"]
        width, height = settings["resolution"]
        if settings["intrinsics_px"]:
            fu, fv, cu, cv = settings["intrinsics_px"]
        else:
            fu = fv = settings["lens_mm"] / settings["sensor_width_mm"] * width
            cu, cv = (width - 1) / 2, (height - 1) / 2
        made = camera_model.Camera(width, height, fu, fv, cu, cv, tuple(settings["distortion"]))
        if not camera_model.scene_margin_is_invertible(made):
            raise SceneError("camera.distortion: the model folds over inside the image")
        return made

    @property
    def R_IC0(self):
        """Camera attitude at time 0."""
        return quat_to_matrix(relative_motion.camera_attitude(self.history, 0.0))

    @property
    def orbit_normal_I(self):
        normal = self.R_IC0 @ np.asarray(self.scene["background"]["orbit_normal_C"], dtype=float)
        return normal / np.linalg.norm(normal)

    def earth_direction_I(self, time_s):
        """Unit vector to the Earth's centre; it turns with the orbit where the Earth is in the picture."""
        direction = self.R_IC0 @ np.asarray(self.scene["light"]["earth_direction_C"], dtype=float)
        direction = direction / np.linalg.norm(direction)
        if self.scene["background"]["kind"] != "earth":
            return direction
        angle_rad = np.radians(self.scene["background"]["orbit_rate_deg_s"]) * time_s
        return quat_to_matrix(quat_from_axis_angle(self.orbit_normal_I, angle_rad)) @ direction

    @property
    def centre_of_mass_G_m(self):
        return np.asarray(self.scene["motion"]["centre_of_mass_G_m"], dtype=float)


def check_view(plan, vertices_G_m):
    """SceneError unless, in every frame, the whole target is before the camera and its middle is in the image."""
    vertices_T = vertices_G_m - plan.centre_of_mass_G_m
    middle_T = (vertices_T.min(axis=0) + vertices_T.max(axis=0)) / 2
    sparse = vertices_T[:: max(1, len(vertices_T) // 2000)]
    for i in range(len(plan.timestamps_ns)):
        R_CT, p_CT = plan.motion.R_CT(i), plan.motion.p_CT_m[i]
        where = f"target out of view in frame {i} (t = {plan.motion.time_s[i]:.1f} s)"
        if (sparse @ R_CT.T + p_CT)[:, 2].min() < 0.02:
            raise SceneError(f"{where}: it reaches behind the camera")
        u, v = camera_model.project(plan.camera, R_CT @ middle_T + p_CT)
        if not (0 <= u <= plan.camera.width - 1 and 0 <= v <= plan.camera.height - 1):
            raise SceneError(f"{where}: its middle is at pixel ({u:.0f}, {v:.0f})")


def build_target(scene):
    """(parts, materials, known lengths) in G, fiducials included."""
    settings = scene["target"]
    if settings["kind"] == "file":
        from .targets import imported

        parts, materials, known = imported.build(settings["path"], settings["scale"])
    else:
        parts, materials, known = _build_own(settings)
    for i, point in enumerate(settings["fiducials_G_m"]):
        parts.append(mesh.sphere(f"fiducial_{i}", point, settings["fiducial_radius_m"], "fiducial", 16, 8))
        materials["fiducial"] = Material((1.0, 1.0, 1.0), emission=1.0)
    return parts, materials, known


def _build_own(settings):
    from .targets import box, cubesat

    builders = {"box": box, "cubesat": cubesat}
    if settings["kind"] in ("damaged_cube", "upper_stage"):
        from .targets import damaged_cube, upper_stage

        builders = {"damaged_cube": damaged_cube, "upper_stage": upper_stage}
    arguments = [settings["size_m"], settings["detail_seed"], settings["texture_px"]]
    if settings["kind"] == "cubesat":
        arguments.append(settings["panel_length_m"])
    return builders[settings["kind"]].build(*arguments)


def large_window_samples(samples, sub_frames, window):
    """Samples a pixel in a window (x0, y0, w, h) whose pixels share them; None if the window isn't large.

    @param samples  the scene's, for each of the sub_frames that make one frame
    """
    area_px = window[2] * window[3]
    if area_px <= LARGE_WINDOW_PX:
        return None
    affordable = round(LARGE_WINDOW_WORK / (area_px * sub_frames))
    return min(samples, max(-(-LARGE_WINDOW_SAMPLES_MIN // sub_frames), affordable))


def has_large_window(plan, vertices_T):
    """Whether the window of any sub-frame is large."""
    resampler, motion = camera_model.Resampler(plan.camera), plan.sub_motion
    windows = [resampler.target_window(vertices_T @ motion.R_CT(row).T + motion.p_CT_m[row]) for row in plan.rows.ravel()]
    return any(window is not None and large_window_samples(1, 1, window) is not None for window in windows)


def fingerprint(scene, large_window):
    """Hash of everything that decides the pixels."""
    form = LABORATORY_FORMAT if scene["background"]["kind"] == "laboratory" else FORMAT
    if large_window:
        form = [form, LARGE_WINDOW_PX, LARGE_WINDOW_WORK, LARGE_WINDOW_SAMPLES_MIN]
    return hashlib.sha256(json.dumps([form, scene], sort_keys=True).encode()).hexdigest()


def prepare_folder(out, plan, parts, known):
    """Writes all but the frames; keeps the frames of an interrupted run of the same scene, refuses any other folder."""
    out = Path(out)
    vertices_T = mesh.all_vertices(parts) - plan.centre_of_mass_G_m
    mark = fingerprint(plan.scene, has_large_window(plan, vertices_T))
    description = out / "scene.json"
    if description.is_file():
        if json.loads(description.read_text()).get("fingerprint") != mark:
            raise SceneError(f"{out}: holds a rendering of another scene; give an empty folder")
    elif out.is_dir() and any(out.iterdir()):
        raise SceneError(f"{out}: not empty and not a rendering")
    (out / "mav0/cam0/data").mkdir(parents=True, exist_ok=True)
    truth.write_truth(out / "truth.csv", plan.timestamps_ns, plan.motion)
    truth.write_sensor_yaml(out / "mav0/cam0/sensor.yaml", plan.camera, 1.0 / plan.scene["time"]["period_s"])
    if plan.history:  # a camera that turns knows how
        truth.write_servicer_attitude(out / "servicer_attitude.csv", plan.timestamps_ns, plan.motion)
    mesh.write_ply(out / "model.ply", parts, plan.centre_of_mass_G_m)
    extent = vertices_T.max(axis=0) - vertices_T.min(axis=0)
    truth.write_json(
        description,
        {
            "fingerprint": mark,
            "scene": plan.scene,
            "body_size_m": float(extent.max()),
            "extent_T_m": extent.tolist(),
            "bounding_box_T_m": [vertices_T.min(axis=0).tolist(), vertices_T.max(axis=0).tolist()],
            "fiducials_T_m": [(np.array(p) - plan.centre_of_mass_G_m).tolist() for p in plan.scene["target"]["fiducials_G_m"]],
            "known_lengths": truth.known_lengths(
                known, plan.centre_of_mass_G_m, plan.camera, plan.timestamps_ns, plan.motion, camera_model.project
            ),
        },
    )


def write_atomically(path, data):
    """A frame is either complete or absent, whatever interrupts the run."""
    partial = path.with_suffix(".part")
    partial.write_bytes(data)
    os.replace(partial, path)


class Painter:
    """Renders frames of a plan. Lights are given at time 0 in C and stay fixed in I."""

    def __init__(self, plan, parts, materials, scratch_path):
        from . import backgrounds, blender_scene

        self.blender, self.plan, self.scratch_path = blender_scene, plan, scratch_path
        scene = plan.scene
        # Sub-frames are averaged, so they share a frame's samples; 8 each keep the soft light even.
        self.samples = max(min(8, scene["render"]["samples"]), scene["render"]["samples"] // len(plan.offsets_s))
        # Materials of an imported file live in Blender; reading the file came first and must not be wiped.
        if scene["target"]["kind"] != "file":
            blender_scene.reset(self.samples)
        own = [part for part in parts if part.material != "imported"]
        self.target = blender_scene.add_parts(own, materials, origin_m=plan.centre_of_mass_G_m)
        if len(own) < len(parts):
            from .targets import imported

            imported.adopt(self.target, plan.centre_of_mass_G_m)
        self.vertices_T = mesh.all_vertices(parts) - plan.centre_of_mass_G_m
        self.resampler = camera_model.Resampler(plan.camera)
        light = scene["light"]
        self.sun_I = plan.R_IC0 @ light["sun_direction_C"]
        self.background = backgrounds.make(plan, self.resampler, blender_scene, scratch_path, self.vertices_T)
        if self.background.own_light:
            self.sun = None
        else:
            self.sun = blender_scene.add_sun(light["sun"])
            self.earth = blender_scene.add_earthshine(light["earthshine"], np.radians(light["earth_half_angle_deg"]))

    def _target_layer(self, row, seed):
        """Linear premultiplied RGBA (H, W, 4) of the target alone at one instant."""
        motion = self.plan.sub_motion
        R_CT, p_CT = motion.R_CT(row), motion.p_CT_m[row]
        R_CI = quat_to_matrix(motion.q_IC[row]).T
        self.blender.place(self.target, R_CT, p_CT)
        if self.sun:
            self.blender.aim_sun(self.sun, R_CI @ self.sun_I)
            self.blender.aim_earthshine(self.earth, R_CI @ self.plan.earth_direction_I(motion.time_s[row]))
        window = self.resampler.target_window(self.vertices_T @ R_CT.T + p_CT)
        camera = self.plan.camera
        if window is None:
            return np.zeros((camera.height, camera.width, 4), dtype=np.float32)
        few = large_window_samples(self.samples, len(self.plan.offsets_s), window)
        picture = self.blender.render_window(
            self.resampler.f_ideal, camera.cu, camera.cv, window, seed, self.scratch_path, few or self.samples, shared=few is not None
        )
        if few is not None:
            picture = camera_model.share_samples(picture)
        return self.resampler.to_camera(picture, window)

    def frame(self, i):
        """Pixel values of frame i."""
        total = None
        for k, row in enumerate(self.plan.rows[i]):
            seed = int(noise.generator(self.plan.scene["seed"], 11, i, k).integers(0, 2**31 - 1))
            self.background.prepare(self.plan.sub_motion, row)
            layer = self._target_layer(row, seed)
            behind = self.background.radiance(self.plan.sub_motion, row)
            picture = layer[..., :3] if behind is None else layer[..., :3] + (1 - np.clip(layer[..., 3:], 0, 1)) * behind
            total = picture if total is None else total + picture
        return sensor.expose(total / len(self.plan.rows[i]), self.plan.sensor, self.plan.scene["seed"], i)


def render(plan, parts, materials, out, report=lambda text: print(text, file=sys.stderr)):
    """Renders the frames that are not there yet, then writes data.csv, whose presence says that all is there."""
    folder = Path(out) / "mav0/cam0/data"
    missing = [i for i, stamp in enumerate(plan.timestamps_ns) if not (folder / f"{stamp}.png").is_file()]
    report(f"{len(plan.timestamps_ns)} frames, {len(missing)} to render")
    if missing:
        painter = Painter(plan, parts, materials, str(Path(out) / "window.exr"))
        begin = time.monotonic()
        for done, i in enumerate(missing, 1):
            write_atomically(folder / f"{plan.timestamps_ns[i]}.png", png.encode(painter.frame(i)))
            each_s = (time.monotonic() - begin) / done
            left_s = round(each_s * (len(missing) - done))
            report(f"frame {i + 1}/{len(plan.timestamps_ns)}  {each_s:.2f} s/frame  {left_s // 60} min {left_s % 60:02d} s left")
    for leftover in [*folder.glob("*.part"), Path(out) / "window.exr"]:
        leftover.unlink(missing_ok=True)
    truth.write_data_csv(Path(out) / "mav0/cam0/data.csv", plan.timestamps_ns)
