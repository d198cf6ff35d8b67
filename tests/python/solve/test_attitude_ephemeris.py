"""Attitude ephemeris messages of CCSDS: what is read is what was written, by others too."""

from datetime import datetime
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import rigid
from physics import present

RUN = rigid.simulate(rigid.Body((1.0, 2.0, 3.0)), [0.1, 1.0, 0.2], t=[0.0, 5.0, 10.25])


QUARTER = """\
CCSDS_AEM_VERS = 2.0
COMMENT the example of annex F2.2: 90 degrees about Z
CREATION_DATE = 2026-01-31T12:00:00
ORIGINATOR = EXAMPLE

META_START
OBJECT_NAME = TURNED
OBJECT_ID = UNKNOWN
REF_FRAME_A = ICRF
REF_FRAME_B = SC_BODY_1
TIME_SYSTEM = UTC
START_TIME = 2026-01-31T12:00:00
STOP_TIME = 2026-031T12:00:01.5Z
ATTITUDE_TYPE = QUATERNION/ANGVEL
ANGVEL_FRAME = SC_BODY_1
META_STOP

DATA_START
2026-01-31T12:00:00 0 0 0.7071 0.7071 0 0 1.5
2026-031T12:00:01.5Z 0 0 0.7071 0.7071 0 0 1.5
DATA_STOP
"""


#: As brahe 1.8.0 writes the message of ``RUN``.
BRAHE = """\
CCSDS_AEM_VERS = 2.0
CREATION_DATE = 2026-11-29T12:39:36.261453
ORIGINATOR = RIGID

META_START
OBJECT_NAME = BODY
OBJECT_ID = UNKNOWN
REF_FRAME_A = EME2000
REF_FRAME_B = SC_BODY_1
TIME_SYSTEM = UTC
START_TIME = 2026-01-31T12:00:00.000
STOP_TIME = 2026-01-31T12:00:10.25
ATTITUDE_TYPE = QUATERNION
META_STOP

DATA_START
2026-01-31T12:00:00.000 0 0 0 1
2026-01-31T12:00:05.000 -0.2884483423367915 -0.24267845136844152 -0.7217304935819232 \
0.5805254668647756
2026-01-31T12:00:10.25 -0.07399119292618318 -0.03691007888594726 -0.9943359170300764 \
-0.0667759953123173
DATA_STOP
"""


def read(folder: Path, text: str, segment: int | None = None) -> rigid.AttitudeEphemeris:
    (folder / "a.aem").write_text(text)
    return rigid.load_aem(folder / "a.aem", segment=segment)


def angles_apart(ephemeris: rigid.AttitudeEphemeris, run: rigid.Run) -> float:
    there = Rotation.from_quat(ephemeris.attitude, scalar_first=True)
    return float((there.inv() * run.rotation()).magnitude().max())


def test_what_was_written_is_read(tmp_path: Path) -> None:
    path = RUN.to_aem(tmp_path / "run.aem", epoch="2026-01-31T12:00:00", object_name="BOX")
    found = rigid.load_aem(path)
    assert found.t.tolist() == RUN.t.tolist()
    assert found.epoch == datetime(2026, 1, 31, 12)
    assert found.entries["OBJECT_NAME"] == "BOX"
    # 17 digits give the bits back; normalised once more, a unit in the last place.
    assert angles_apart(found, RUN) < 4e-16
    # Neighbours have one sign, as readers that interpolate need: that of the first.
    assert found.attitude[0].tolist() == present(RUN.attitude)[0].tolist()
    assert np.all(np.vecdot(found.attitude[1:], found.attitude[:-1]) > 0.0)


def test_a_message_of_another_program_is_read(tmp_path: Path) -> None:
    found = read(tmp_path, BRAHE)
    assert found.t.tolist() == RUN.t.tolist()
    assert angles_apart(found, RUN) < 1e-15


def test_another_program_reads_our_message(tmp_path: Path) -> None:
    ccsds = pytest.importorskip("brahe.ccsds")
    path = RUN.to_aem(tmp_path / "run.aem", epoch="2026-01-31T12:00:00")
    (segment,) = ccsds.AEM.from_file(str(path)).segments
    assert segment.ref_frame_b == "SC_BODY_1"
    for state, turned in zip(segment.states, present(RUN.attitude), strict=True):
        found = state.quaternion.to_vector(True)
        assert abs(abs(found @ turned) - 1.0) < 1e-15


def test_the_example_of_the_standard_takes_components_from_a_to_b(tmp_path: Path) -> None:
    """Annex F2.2: X_A = (1, 0, 0) has the components (0, -1, 0) in frame B."""
    found = read(tmp_path, QUARTER)
    to_space = Rotation.from_quat(found.attitude[0], scalar_first=True)
    assert np.allclose(to_space.inv().apply([1.0, 0.0, 0.0]), [0.0, -1.0, 0.0], atol=1e-15)
    assert found.t.tolist() == [0.0, 1.5]  # the second by the day of the year, with a Z


def test_version_1_had_other_orders_and_directions(tmp_path: Path) -> None:
    first = "ATTITUDE_DIR = B2A\nQUATERNION_TYPE = FIRST\nMETA_STOP"
    old = QUARTER.replace("VERS = 2.0", "VERS = 1.0").replace("META_STOP", first)
    old = old.replace(" 0 0 0.7071 0.7071 0", " 0.7071 0 0 -0.7071 0")
    here, there = read(tmp_path, old), read(tmp_path, QUARTER)
    assert np.allclose(here.attitude, there.attitude, rtol=0.0, atol=1e-16)


def test_a_segment_of_several(tmp_path: Path) -> None:
    one = BRAHE.partition("META_START")[2]
    two = BRAHE + "META_START" + one.replace("= BODY\n", "= OTHER\n").replace("2026", "2027")
    assert read(tmp_path, two, 0).entries["OBJECT_NAME"] == "BODY"
    last = read(tmp_path, two, -1)
    assert (last.entries["OBJECT_NAME"], last.epoch.year) == ("OTHER", 2027)
    with pytest.raises(ValueError, match=r"a\.aem: segment = None: the message has 2, choose one"):
        read(tmp_path, two)
    with pytest.raises(ValueError, match="segment = 2: the message has 2"):
        read(tmp_path, two, 2)


def test_rates_follow_from_the_attitudes_of_a_message(tmp_path: Path) -> None:
    t = np.linspace(0.0, 1.0, 101)
    run = rigid.simulate(rigid.Body((1.0, 2.0, 3.0)), [0.1, 1.0, 0.2], t=t)
    found = rigid.load_aem(run.to_aem(tmp_path / "run.aem", epoch="2026-01-31"))
    rates = rigid.rotations.omega_from_attitudes(found.attitude, found.t)
    # Of samples 0.01 s apart: of the second order, with a third derivative of about 1 rad/s³.
    assert np.abs(rates - run.omega).max() < 1e-4


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("CCSDS_AEM", "CCSDS_OEM", "line 1: is no attitude ephemeris message: CCSDS_AEM_VERS"),
        ("REF_FRAME_B = SC_BODY_1\n", "", "line 17: REF_FRAME_B is missing"),
        ("QUATERNION/ANGVEL", "SPIN", "line 18: ATTITUDE_TYPE = 'SPIN': must be one of QUATERNION"),
        (" 0 0 1.5", " 0 0", "must be a time and 7 finite numbers"),
        (" 0 0 1.5", " 0 0 nan", "must be a time and 7 finite numbers"),
        ("0.7071 0.7071", "0.7071 one", "line 19: could not convert string to float: 'one'"),
        ("2026-01-31T12:00:00 ", "2026-13-31T12:00:00 ", "line 19: '2026-13-31.*: must be a time"),
        (
            "2026-01-31T12:00:00 ",
            "2026-01-31T25:00:00 ",
            "line 19: '2026-01-31T25.*: must be",
        ),
        ("2026-01-31T12:00:00 ", "2026-01-31T12:00:-1 ", "line 19: .*: must be a time"),
        ("2026-01-31T12:00:00 ", "2026-01-31T12:00 ", "line 19: .*: must be a time"),
        ("2026-01-31T12:00:00 ", "2026-01-31T12:00:0.5e3 ", "line 19: .*: must be a time"),
        ("ATTITUDE_TYPE", "ATTITUDE_DIR = A TO B\nATTITUDE_TYPE", "ATTITUDE_DIR = 'A TO B': must"),
        ("ATTITUDE_TYPE", "QUATERNION_TYPE = ANY\nATTITUDE_TYPE", "QUATERNION_TYPE = 'ANY': must"),
        ("2026-01-31T12:00:00 ", "2026-01-31T12:00:02 ", "line 20: the times must ascend"),
        ("0.7071 0.7071", "0.7071 0.9", "line 19: a quaternion has not the length 1"),
        ("DATA_STOP", "", "the message ends before its data do"),
        ("OBJECT_NAME =", "OBJECT_NAME", "must be keyword = value"),
        ("META_START\n", "DATA_START\n", "line 6: data before their metadata"),
    ],
)
def test_what_is_no_message_is_refused(tmp_path: Path, old: str, new: str, words: str) -> None:
    assert old in QUARTER
    with pytest.raises(ValueError, match=words):
        read(tmp_path, QUARTER.replace(old, new, 1))
