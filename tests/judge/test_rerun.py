"""A Rerun recording, read back by Rerun's own reader: poses, pictures, cloud, rates and events are those of the run."""

import importlib.util
import json
import pathlib
import shutil
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from polhode_ground.common.tables import read_motion
from polhode_ground.common.venv import REPOSITORY
from polhode_ground.testing.synthetic import START_NS, Errors, tumbling_body, write_acquired, write_run
from scipy.spatial.transform import Rotation

NEEDS_RERUN = pytest.mark.skipif(importlib.util.find_spec("rerun") is None, reason="rerun-sdk is not installed: tools/setup.sh extras")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return write_acquired(tmp_path_factory.mktemp("rerun"), frames=20)


@pytest.fixture
def run(made, tmp_path):
    return pathlib.Path(shutil.copytree(made[1], tmp_path / "run"))


def report(*arguments):
    return subprocess.run([sys.executable, REPOSITORY / "tools/report.py", *map(str, arguments)], capture_output=True, text=True)


def rows_of(path: pathlib.Path, entity: str, component: str) -> dict[int, np.ndarray]:
    """{time [ns]: values} of one component of an entity; time 0 holds what is static."""
    from rerun.chunk import RrdReader
    found = {}
    for chunk in RrdReader(str(path)).stream():
        batch = chunk.to_record_batch()
        if chunk.entity_path != f"/{entity}" or component not in batch.schema.names:
            continue
        times = batch.column("time").cast("int64").to_pylist() if "time" in batch.schema.names else [0] * batch.num_rows
        for time_ns, values in zip(times, batch.column(component).to_pylist()):
            if values is not None:
                found[time_ns] = values
    return found


@pytest.mark.further
@NEEDS_RERUN
def test_holds_the_poses_pictures_cloud_and_rates_of_the_run(made, run, tmp_path):
    motion = read_motion(run / "motion.csv")
    done = report(run, "--rrd", tmp_path / "run.rrd")
    assert done.returncode == 0 and f"{2 * motion.pose_valid.sum()} poses" in done.stdout, done.stderr
    places = rows_of(tmp_path / "run.rrd", "target/causal", "Transform3D:translation")
    turns = rows_of(tmp_path / "run.rrd", "target/causal", "Transform3D:quaternion")
    known = {int(motion.timestamp_ns[row]): row for row in np.flatnonzero(motion.pose_valid)}
    assert set(places) == set(turns) == set(known) and len(known) == 17
    for time_ns, row in known.items():
        # Rerun holds float32: 8 m to 0.5 um, and a unit quaternion to 6e-8.
        assert np.allclose(places[time_ns], motion.p_CT[row], atol=1e-6)
        assert np.allclose(np.reshape(turns[time_ns], 4)[[3, 0, 1, 2]], motion.q_CT[row], atol=2e-7)
    rates, smoothed = ({time_ns: np.ravel(value) for time_ns, value in rows_of(tmp_path / "run.rrd", f"rates/{kind}", "Scalars:scalars").items()}
                       for kind in ("causal", "smoothed"))
    for time_ns, row in known.items():
        assert np.allclose(smoothed[time_ns], np.degrees(motion.w_T[row]))  # the two files are alike here
        # In the smoothed poses' axes, which are known by 17 attitudes 0.01 rad off: 0.0024 rad of 2 deg/s, three times.
        assert np.allclose(rates[time_ns], np.degrees(motion.w_T[row]), atol=0.015)
    pictures = rows_of(tmp_path / "run.rrd", "camera/image", "EncodedImage:blob")
    assert len(pictures) == 20
    frame = made[0] / "mav0/cam0/data" / f"{START_NS}.png"
    assert bytes(np.array(pictures[START_NS], dtype=np.uint8).reshape(-1)) == frame.read_bytes()
    cloud = rows_of(tmp_path / "run.rrd", "target/smoothed/cloud", "Points3D:positions")
    assert list(cloud) == [int(motion.timestamp_ns[3])] and len(next(iter(cloud.values()))) == 600
    assert len(rows_of(tmp_path / "run.rrd", "camera", "Pinhole:image_from_camera")) == 1


@pytest.mark.further
@NEEDS_RERUN
def test_rates_of_both_motions_are_in_the_same_axes(tmp_path):
    """Each motion has a T of its own, 60 deg apart here."""
    run = write_run(tmp_path / "run", tumbling_body(frames=20), Errors(), Errors(R_ET=Rotation.from_rotvec([0.0, 1.0, 0.3])))
    assert report(run, "--rrd", tmp_path / "run.rrd").returncode == 0
    causal, smoothed = (rows_of(tmp_path / "run.rrd", f"rates/{kind}", "Scalars:scalars") for kind in ("causal", "smoothed"))
    assert len(causal) == 20 and all(np.allclose(causal[time_ns], smoothed[time_ns], atol=1e-5) for time_ns in causal)


@pytest.mark.further
@NEEDS_RERUN
def test_a_target_that_is_lost_is_taken_away_and_comes_back(run, tmp_path):
    lines = (run / "motion.csv").read_text().splitlines()
    for at in (11, 12):  # frames 10 and 11
        cells = lines[at].split(",")
        lines[at] = ",".join([*cells[:2], "LOST", "0", "0", "0", "0", *[""] * 17, *cells[24:30], ""])
    (run / "motion.csv").write_text("\n".join(lines) + "\n")
    done = report(run, "--rrd", tmp_path / "run.rrd")
    assert done.returncode == 0, done.stderr
    cleared = rows_of(tmp_path / "run.rrd", "target/causal", "Clear:is_recursive")
    axes = rows_of(tmp_path / "run.rrd", "target/causal/axes", "Arrows3D:vectors")
    assert sorted(cleared) == [START_NS + 10 * 10**9]
    assert sorted(axes) == [START_NS + 3 * 10**9, START_NS + 12 * 10**9]
    modes = rows_of(tmp_path / "run.rrd", "mode", "TextLog:text")
    assert [modes[time_ns][0] for time_ns in sorted(modes)] == ["ACQUIRING", "TRACKING", "LOST", "TRACKING"]


@pytest.mark.further
@NEEDS_RERUN
def test_events_are_words_at_their_time(made, run, tmp_path):
    from polhode_ground.reporting.gather import gather
    from polhode_ground.reporting.rerun_file import write_rrd
    material = gather(run, made[0])
    material.events = [SimpleNamespace(header=SimpleNamespace(seconds=START_NS // 10**9 + 4, fraction=2**23), text="the scale is known")]
    write_rrd(material, tmp_path / "run.rrd")
    assert rows_of(tmp_path / "run.rrd", "events", "TextLog:text") == {START_NS + 4_500_000_000: ["the scale is known"]}


@pytest.mark.further
@NEEDS_RERUN
def test_a_run_that_never_acquired_and_has_no_sequence(run, tmp_path):
    lines = (run / "motion.csv").read_text().splitlines()
    for name in ("motion.csv", "motion_smoothed.csv"):
        (run / name).write_text("\n".join([lines[0], *(",".join([*line.split(",")[:2], "ACQUIRING", *["0"] * 4, *[""] * 24]) for line in lines[1:])]) + "\n")
    (run / "summary.json").write_text(json.dumps(json.loads((run / "summary.json").read_text()) | {"sequence": ""}))
    done = report(run, "--rrd", tmp_path / "run.rrd")
    assert done.returncode == 0 and "run.rrd: 0 poses" in done.stdout, done.stderr
    assert rows_of(tmp_path / "run.rrd", "target/causal", "Transform3D:translation") == {}


def test_where_it_cannot_be_written_one_line_says_so(run):
    done = report(run, "--rrd", "/nonexistent/run.rrd")
    assert done.returncode == 2 and "--rrd /nonexistent/run.rrd" in done.stderr and done.stderr.count("\n") == 1, done.stderr
