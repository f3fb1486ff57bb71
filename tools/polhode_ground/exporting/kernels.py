"""A SPICE C-kernel of the attitudes, with the text kernels that make it readable without anything else.

The clock: ticks are nanoseconds from a whole second before the run's first frame, which a C-kernel's double holds exactly for 104 days. In
SPICE's own times (ET, seconds since 2000) a double resolves 0.1 us only: the ends of each interval are held for 1 us beyond it, or the
first and the last attitude would not be found at their own times.
"""

import contextlib
import pathlib

import numpy as np
import spiceypy

from polhode_ground.common.errors import BadInput
from polhode_ground.common.whole_file import MARK, beside, check_replaceable
from polhode_ground.exporting.names import Names, definition, frame_number
from polhode_ground.exporting.poses import Poses, counted, runs_of, with_rates
from polhode_ground.exporting.times import NS, date_of, leap_seconds, terrestrial_s
from polhode_ground.judge.align import rotations

CAMERA_NUMBER = 999  # of the camera's frame: -999999 beside -999001 of T number 1
TARGETS_MAX = 99
TICKS_MAX = 2**53
COMMENT_OCTETS = 4096
HELD_TICKS = 1000
SUFFIXES = {"frames": ".tf", "clock": ".tsc", "leap seconds": ".tls"}

FRAMES = """KPL/FK

{mark}. Frames of {source}.

{definitions}

{camera} has no C-kernel here: it is the servicer's. With its C-kernel for {camera_id}, or with {camera} defined
by an offset from one of its frames instead (CLASS 4, a TK frame), the attitude of T is known in any other frame.
Names end in the number of T. Another run has other frames T and another clock: load the two together with different
numbers of the target only.

\\begindata

NAIF_BODY_NAME += ( '{target}' )
NAIF_BODY_CODE += ( {target_id} )

{frames}
\\begintext
"""

FRAME = """FRAME_{name} = {number}
FRAME_{number}_NAME = '{name}'
FRAME_{number}_CLASS = 3
FRAME_{number}_CLASS_ID = {number}
FRAME_{number}_CENTER = {centre}
CK_{number}_SCLK = {target_id}
CK_{number}_SPK = {centre}
"""

CLOCK = """KPL/SCLK

{mark}. The clock {target_id} of {source}: seconds and nanoseconds since {begin} {scale}.

\\begindata

SCLK_KERNEL_ID = ( @2000-JAN-01 )
SCLK_DATA_TYPE_{number} = ( 1 )
SCLK01_TIME_SYSTEM_{number} = ( 2 )
SCLK01_N_FIELDS_{number} = ( 2 )
SCLK01_MODULI_{number} = ( 4294967296 1000000000 )
SCLK01_OFFSETS_{number} = ( 0 0 )
SCLK01_OUTPUT_DELIM_{number} = ( 1 )
SCLK_PARTITION_START_{number} = ( 0.0 )
SCLK_PARTITION_END_{number} = ( 9007199254740992.0 )
SCLK01_COEFFICIENTS_{number} = ( 0.0 {terrestrial_s!r} 1.0 )

\\begintext
"""

LEAP_SECONDS = """KPL/LSK

{mark}. Leap seconds by IERS, known to be whole until {expires}; the other numbers are NAIF's.

\\begindata

DELTET/DELTA_T_A = 32.184
DELTET/K = 1.657D-3
DELTET/EB = 1.671D-2
DELTET/M = ( 6.239996D0 1.99096871D-7 )
DELTET/DELTA_AT = ( {steps} )

\\begintext
"""


def frames_text(poses: Poses, names: Names, naif_id: int) -> str:
    targets = [int(target) for target in np.unique(poses.target)]
    definitions = [sentence for target in targets for sentence in definition(target, poses.kind, poses.source, names)]
    camera_id, servicer = frame_id(naif_id, CAMERA_NUMBER), naif_id - 1
    frames = [FRAME.format(name=names.camera_frame, number=camera_id, centre=servicer, target_id=naif_id)]
    frames += [
        FRAME.format(
            name=names.frame_of(target, poses.kind),
            number=frame_id(naif_id, frame_number(target, poses.kind)),
            centre=naif_id,
            target_id=naif_id,
        )
        for target in targets
    ]
    return FRAMES.format(
        mark=MARK,
        source=poses.source,
        definitions="\n".join(f"{one}." for one in dict.fromkeys(definitions)),
        camera=names.camera_frame,
        camera_id=camera_id,
        target=names.target,
        target_id=naif_id,
        frames="\n".join(frames),
    )


def frame_id(naif_id: int, number: int) -> int:
    return 1000 * naif_id - number


def clock_begin_s(poses: Poses) -> int:
    """Alike for all files of a run, which have one clock; before all that is held."""
    return poses.begin_ns // NS - 1


def clock_text(poses: Poses, naif_id: int, clock: str) -> str:
    begin, end = clock_begin_s(poses), int(poses.time_ns[-1]) // NS
    leaps = leap_seconds()
    if leaps.at(begin, clock) != leaps.at(end, clock):
        raise BadInput(
            f"{poses.source}: a leap second lies within it, which Unix time does not tell from the second before; allowed is --clock tai"
        )
    return CLOCK.format(
        mark=MARK,
        target_id=naif_id,
        number=-naif_id,
        source=poses.source,
        begin=date_of(begin * NS).split(".")[0],
        scale=clock.upper(),
        terrestrial_s=terrestrial_s(begin, clock, leaps),
    )


def leap_seconds_text() -> str:
    leaps = leap_seconds()
    steps = [
        f"{value:.0f}, @{np.datetime64(int(second), 's').item():%Y-%b-%d}".upper()
        for second, value in zip(leaps.unix_s, leaps.tai_less_utc_s)
    ]
    return LEAP_SECONDS.format(mark=MARK, expires=leaps.expires, steps="\n                    ".join(steps))


def ticks_of(poses: Poses) -> np.ndarray:
    ticks = poses.time_ns - clock_begin_s(poses) * NS
    if ticks[-1] > TICKS_MAX:
        raise BadInput(
            f"{poses.source}: spans {ticks[-1] / NS / 86400:.0f} days; a C-kernel holds nanoseconds of 104 days, so export parts of it"
        )
    return ticks.astype(float)


def write_segments(handle: int, poses: Poses, names: Names, naif_id: int, gap_ns: int | None, rates: bool) -> int:
    """Type 3, one for each T: interpolated within runs of frames, silent between them. @return runs."""
    ticks, runs = ticks_of(poses), runs_of(poses, gap_ns)
    # SPICE's matrix takes components in the base frame to those in the instrument's: T from C.
    q_TC = poses.q_CT * [1, -1, -1, -1]
    w_C = rotations(poses.q_CT).apply(poses.w_T) if rates else np.zeros((len(poses), 3))
    for target in np.unique(poses.target):
        own = [run for run in runs if poses.target[run[0]] == target]
        rows = np.concatenate([[run[0], *run, run[-1]] for run in own])
        times = np.concatenate([[ticks[run[0]] - HELD_TICKS, *ticks[run], ticks[run[-1]] + HELD_TICKS] for run in own])
        starts = [ticks[run[0]] - HELD_TICKS for run in own]
        spiceypy.ckw03(
            handle,
            times[0],
            times[-1],
            frame_id(naif_id, frame_number(int(target), poses.kind)),
            names.camera_frame,
            rates,
            names.frame_of(int(target), poses.kind),
            len(rows),
            times,
            q_TC[rows],
            w_C[rows],
            len(starts),
            starts,
        )
    return len(runs)


def write_ck(
    poses: Poses, out: pathlib.Path, names: Names, naif_id: int, clock: str, gap_ns: int | None, rates: bool
) -> tuple[str, list[str]]:
    """@return what is in it, and what was left out."""
    if out.suffix != ".bc":
        raise BadInput(
            f"--out {out}: a C-kernel's name ends in .bc; its text kernels have the same name with {', '.join(SUFFIXES.values())}"
        )
    if poses.target.max() > TARGETS_MAX:
        raise BadInput(f"{poses.source}: has a frame T number {poses.target.max()}; allowed in a C-kernel are 1 .. {TARGETS_MAX}")
    poses = with_rates(poses) if rates else poses
    texts = {"frames": frames_text(poses, names, naif_id), "clock": clock_text(poses, naif_id, clock), "leap seconds": leap_seconds_text()}
    files = {kind: out.with_suffix(suffix) for kind, suffix in SUFFIXES.items()}
    for file in (out, *files.values()):
        check_replaceable(file)
    out.parent.mkdir(parents=True, exist_ok=True)
    with contextlib.ExitStack() as parts:
        written = {kind: parts.enter_context(beside(file)) for kind, file in files.items()}
        for kind, text in texts.items():
            written[kind].write_text(text)
        runs = _write_binary(parts.enter_context(beside(out)), written["frames"], poses, names, naif_id, gap_ns, rates)
    beside_it = ", ".join(file.name for file in files.values())
    return f"{counted(len(poses), 'attitude')} in {counted(runs, 'interval')}; beside it {beside_it}", poses.remarks


def _write_binary(
    part: pathlib.Path, frames: pathlib.Path, poses: Poses, names: Names, naif_id: int, gap_ns: int | None, rates: bool
) -> int:
    sigma = poses.sigma_att_rad[np.isfinite(poses.sigma_att_rad)]
    comments = [
        f"{MARK} of {poses.source}",
        *poses.remarks,
        *([f"attitude, 1-sigma of the worst axis: {sigma.min():.3g} to {sigma.max():.3g} rad"] if len(sigma) else []),
        "angular velocities are relative to inertial space: the user states that the camera does not rotate"
        if rates
        else "no angular velocities",
    ]
    spiceypy.kclear()
    spiceypy.furnsh(str(frames))
    try:
        handle = spiceypy.ckopn(str(part), MARK, COMMENT_OCTETS)
        try:
            runs = write_segments(handle, poses, names, naif_id, gap_ns, rates)
            spiceypy.dafac(handle, comments)
        finally:
            spiceypy.ckcls(handle)
    except spiceypy.exceptions.SpiceyError as problem:
        raise BadInput(f"{part.name}: SPICE refuses it: {problem.short}: {problem.long}".strip()) from None
    finally:
        spiceypy.kclear()
    return runs
