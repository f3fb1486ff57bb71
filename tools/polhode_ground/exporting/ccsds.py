"""Attitude and orbit messages of CCSDS (504.0-B-2: AEM, APM; 502.0-B-3: OEM), written by ccsds-ndm-py as KVN or XML.

A quaternion (Q1, Q2, Q3, QC) from REF_FRAME_A = C to REF_FRAME_B = T turns the axes of C into those of T: it is q_CT, scalar last.
"""

import datetime
from dataclasses import dataclass, replace

import ccsds_ndm as ndm
import numpy as np

from polhode_ground.common.errors import BadInput
from polhode_ground.common.whole_file import MARK
from polhode_ground.exporting.names import Names, definition
from polhode_ground.exporting.poses import Poses, chosen, counted, runs_of, with_rates, without
from polhode_ground.exporting.times import date_of

KM = 1e-3
VELOCITY_COMMENT = "velocity is relative to inertial space; it is the derivative of the place where the camera does not rotate"
RATE_COMMENT = "angular velocities are relative to inertial space: the user states that the camera does not rotate"
COVARIANCE_SOURCE = "position and velocity: their correlation is not known and stands as 0"


@dataclass(frozen=True)
class Message:
    """How a message is to be written."""

    names: Names
    clock: str  # "utc" or "tai"
    gap_ns: int | None
    rates: bool = False
    frame: int | None = None  # of an APM; None: the last one with a pose

    @property
    def time_system(self) -> str:
        return self.clock.upper()


def _header_fields(message: Message, poses: Poses) -> tuple:
    """creation date, originator, classification, id, comments"""
    now = datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%dT%H:%M:%S")
    return now, message.names.originator, None, None, [f"{MARK} of {poses.source}", *poses.remarks]


def _sigma_comment(poses: Poses) -> list[str]:
    sigma = poses.sigma_att_rad[np.isfinite(poses.sigma_att_rad)]
    return (
        [f"attitude, 1-sigma of the worst axis: {sigma.min():.3g} to {sigma.max():.3g} rad"] if len(sigma) else ["attitude: sigma unknown"]
    )


def _attitudes(poses: Poses, rates: bool) -> np.ndarray:
    """[N,4] Q1 Q2 Q3 QC, or [N,7] with deg/s."""
    quaternions = np.roll(poses.q_CT, -1, axis=1)
    return np.concatenate([quaternions, np.degrees(poses.w_T)], axis=1) if rates else quaternions


def aem(poses: Poses, message: Message) -> tuple[object, str, list[str]]:
    """@return the message, what is in it, and what was left out."""
    poses = with_rates(poses) if message.rates else poses
    kind, names = "QUATERNION/ANGVEL" if message.rates else "QUATERNION", message.names
    segments = []
    for rows in runs_of(poses, message.gap_ns):
        part = chosen(poses, rows)
        epochs, body = [date_of(time_ns) for time_ns in part.time_ns], names.frame_of(part.last_target, part.kind)
        metadata = ndm.AemMetadata(
            names.target,
            names.target_id,
            names.camera_frame,
            body,
            epochs[0],
            epochs[-1],
            message.time_system,
            kind,
            center_name=names.servicer,
            angvel_frame=body if message.rates else None,
            comment=definition(part.last_target, part.kind, part.source, names),
        )
        data = ndm.AemData.from_numpy(
            epochs, _attitudes(part, message.rates), attitude_type=kind, comment=_sigma_comment(part) + [RATE_COMMENT] * message.rates
        )
        segments.append(ndm.AemSegment(metadata, data))
    return (
        ndm.Aem(ndm.AdmHeader(*_header_fields(message, poses)), segments),
        f"{counted(len(poses), 'attitude')} in {counted(len(segments), 'segment')}",
        poses.remarks,
    )


def apm(poses: Poses, message: Message) -> tuple[object, str, list[str]]:
    """One attitude."""
    rows = np.flatnonzero(poses.frame == message.frame) if message.frame is not None else np.array([len(poses) - 1])
    if not len(rows):
        raise BadInput(
            f"--frame {message.frame}: has no pose in {poses.source}; allowed are frames with one, from {poses.frame[0]} to {poses.frame[-1]}"
        )
    one, names = chosen(poses, rows), message.names
    one = with_rates(one) if message.rates else one
    body = names.frame_of(one.last_target, one.kind)
    frames = (names.camera_frame, body)
    metadata = ndm.ApmMetadata(
        names.target, names.target_id, message.time_system, names.servicer, definition(one.last_target, one.kind, one.source, names)
    )
    attitude = _attitudes(one, message.rates)[0]
    rates = [ndm.AngVelState(*frames, body, *attitude[4:], [RATE_COMMENT])] if message.rates else None
    data = ndm.ApmData(
        date_of(one.time_ns[0]),
        [ndm.QuaternionState(*frames, *attitude[:4], None, None, None, None, [])],
        angular_velocity=rates,
        comment=_sigma_comment(one),
    )
    return (
        ndm.Apm(ndm.AdmHeader(*_header_fields(message, one)), ndm.ApmSegment(metadata, data)),
        f"the attitude of frame {one.frame[0]}",
        one.remarks,
    )


def oem(poses: Poses, message: Message) -> tuple[object, str, list[str]]:
    """Place and velocity of T's origin seen from the camera, in C, with covariances."""
    if not poses.metres.any():
        raise BadInput(
            f"{poses.source}: its lengths are in map units, and an OEM is in km; give the replay a known length ([scale] in its configuration), "
            "or here --metres-per-unit"
        )
    poses = without(poses, poses.metres, "are in map units: their scale was not known yet")
    moving = np.isfinite(poses.v_C).all(axis=1)
    if not moving.any():
        raise BadInput(f"{poses.source}: no pose with a scale has a velocity, which an OEM needs")
    poses = without(poses, moving, "have no velocity")
    poses = replace(poses, remarks=[*poses.remarks, poses.covariances_from])
    names, segments = message.names, []
    states, covariances = np.concatenate([poses.p_CT, poses.v_C], axis=1) * KM, _covariances_km2(poses)
    for rows in runs_of(poses, message.gap_ns):
        part, epochs = chosen(poses, rows), [date_of(time_ns) for time_ns in poses.time_ns[rows]]
        comments = [
            f"place of the origin of T seen from the camera of {names.servicer}, in axes of {names.camera_frame}",
            VELOCITY_COMMENT,
            *definition(part.last_target, part.kind, part.source, names),
            COVARIANCE_SOURCE,
        ]
        metadata = ndm.OemMetadata(
            names.target,
            names.target_id,
            epochs[0],
            epochs[-1],
            center_name=names.servicer,
            ref_frame=names.camera_frame,
            time_system=message.time_system,
            comment=comments,
        )
        known = [row for row in rows if np.isfinite(covariances[row]).all()]
        data = ndm.OemData.from_numpy(
            epochs,
            states[rows],
            [date_of(poses.time_ns[row]) for row in known] or None,
            covariances[known] if known else None,
            [names.camera_frame] * len(known) or None,
        )
        segments.append(ndm.OemSegment(metadata, data))
    return (
        ndm.Oem(ndm.OdmHeader(*_header_fields(message, poses)), segments),
        f"{counted(len(poses), 'state')} in {counted(len(segments), 'segment')}",
        poses.remarks,
    )


def _covariances_km2(poses: Poses) -> np.ndarray:
    """[N,21] lower triangle by rows, of (position, velocity)."""
    whole = np.zeros((len(poses), 6, 6))
    whole[:, :3, :3], whole[:, 3:, 3:] = poses.cov_pose[:, 3:, 3:], poses.cov_v
    lower = np.tril_indices(6)
    return whole[:, lower[0], lower[1]] * KM**2


WRITERS = {"aem": aem, "apm": apm, "oem": oem}


def text_of(message: object, form: str) -> str:
    """@param form  "kvn" or "xml"."""
    text = message.to_str(form)
    if form == "kvn" and isinstance(message, ndm.Apm):
        # Figure G-1 of 504.0-B-2 has no such lines in an APM, and Orekit finds no metadata between them; ccsds-ndm-py 0.0.9 writes them.
        text = text.replace("META_START\n", "").replace("META_STOP\n", "")
    return text
