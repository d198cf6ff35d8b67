"""Runs in files, datasets, pictures and messages; angular momentum in both frames."""

import re
import warnings
import zipfile
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import rigid
from rigid._archive import Archive, ForeignError, write_archive
from rigid.solve.columns import Column

BODY = rigid.Body((1.0, 1.5, 2.0))
TIMES = np.linspace(-3.0, 5.0, 9)
QUATERNION = np.array([0.5, -0.5, 0.1, 0.7]) / np.linalg.norm([0.5, -0.5, 0.1, 0.7])


def runs() -> dict[str, rigid.Run]:
    top = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=[1.2, 0.8], com=(0.6, 0.0, 0.8))
    driven = rigid.FreeBody(BODY, torque=rigid.Torque.body((0.1, 0.0, 0.0)), damping=0.1)
    path = rigid.Orbit(0.7).position(TIMES)
    tables = rigid.FreeBody(
        BODY,
        orbit=rigid.Orbit.table(TIMES, path, gm=1.0),
        rotor=rigid.RotorTable(TIMES, 0.1 * path),
    )
    return {
        "one": rigid.simulate(BODY, [0.1, 1.0, 0.2], QUATERNION, t=TIMES),
        "many": rigid.simulate(top, [0.1, 1.0, 0.2], QUATERNION, t=TIMES, accuracy=1e-9),
        "own times": rigid.simulate(BODY, [0.1, 1.0, 0.2], t=[[0.0, 1.0], [1.0, 2.0]]),
        "rates": rigid.simulate(BODY, [0.1, 1.0, 0.2], t=TIMES, record="rates", dtype=np.float32),
        "driven": rigid.simulate(driven, [0.1, 1.0, 0.2], t=[0.0, 2.0]),
        "tables": rigid.simulate(tables, [0.1, 1.0, 0.2], t=TIMES),
        "tangent": rigid.simulate(BODY, [0.1, 1.0, 0.2], t=[0.0, 2.0], tangent=("I1", "damping")),
    }


RUNS = runs()

ARRAYS = tuple(name for name, column in vars(rigid.Run).items() if isinstance(column, Column))


@pytest.fixture(params=RUNS)
def run(request: pytest.FixtureRequest) -> rigid.Run:
    return RUNS[request.param]


def test_a_run_that_was_saved_is_the_same_run(run: rigid.Run, tmp_path: Path) -> None:
    again = rigid.load_run(run.save(tmp_path / "run.npz"))
    for name in ("t", *ARRAYS, "parameters", "events", "nanoseconds", "spec", "plan"):
        one, two = getattr(run, name), getattr(again, name)
        if isinstance(one, np.ndarray):
            assert one.dtype == two.dtype, name
            assert one.shape == two.shape, name
            assert one.tobytes() == two.tobytes(), name
        else:
            assert np.array_equal(one, two, equal_nan=True) if one != one else one == two, name
    assert repr(again) == repr(run)
    assert again.momentum().tobytes() == run.momentum().tobytes()
    if run is RUNS["tables"]:
        assert again.in_orbit_frame().omega.tobytes() == run.in_orbit_frame().omega.tobytes()
    assert again.reasons() == run.reasons()
    assert run.save(tmp_path / "again.npz").read_bytes() == (tmp_path / "run.npz").read_bytes()


def test_a_damaged_run_is_refused(tmp_path: Path) -> None:
    path = RUNS["one"].save(tmp_path / "run.npz")
    whole = path.read_bytes()
    for damaged in (b"", whole[:100], whole[: len(whole) // 2], b"x" * 500):
        path.write_bytes(damaged)
        with pytest.raises(ValueError, match=r"is no run that rigid has saved, it is"):
            rigid.load_run(path)
    middle = len(whole) // 3
    flipped = whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1 :]
    for damaged in (whole[:-1], flipped):
        path.write_bytes(damaged)
        with pytest.raises(ValueError, match="is a damaged run"):
            rigid.load_run(path)
    np.savez(path, header=np.array('{"format": "rigid run 9"}'))
    with pytest.raises(ValueError, match="has the format 'rigid run 9'"):
        rigid.load_run(path)
    np.savez(path, header=np.array('{"format": "rigid run 1"}'))
    with pytest.raises(ValueError, match="is a damaged run"):
        rigid.load_run(path)
    np.savez(path, header=np.array('{"format": "rigid run 1"}'), strange=np.zeros(2))
    with pytest.raises(ValueError, match=r"unknown arrays \['strange'\]"):
        rigid.load_run(path)
    path = RUNS["many"].save(tmp_path / "many.npz")
    with np.load(path) as archive:
        arrays = dict(archive)
    np.savez(path, **{**arrays, "steps": arrays["steps"][:1]})
    with pytest.raises(ValueError, match=r"steps: expected shape \(2, ...\), got \(1,\)"):
        rigid.load_run(path)
    with pytest.raises(FileNotFoundError):
        rigid.load_run(tmp_path / "none.npz")
    for name, array in (
        ("omega", np.zeros((2, 7, 3))),
        ("t", np.array(["a"])),
        ("t", np.arange(3)),
    ):
        np.savez(path, **{**arrays, name: array})
        with pytest.raises(ValueError, match=r"is a damaged run \((omega: expected|t has no num)"):
            rigid.load_run(path)


@pytest.mark.parametrize("most", [2**16 - 1, 1], ids=["of few entries", "of many entries"])
def test_a_directory_as_long_as_the_bound_is_read(
    most: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An entry of a directory has 46 B and its name (PKWARE's APPNOTE, §4.3.12).

    Of more entries than 16 bits count, a further record at the end tells the size (§4.3.14).
    """
    monkeypatch.setattr(zipfile, "ZIP_FILECOUNT_LIMIT", most)
    path = tmp_path / "two.npz"
    write_archive(path, {"one": np.arange(3.0), "two": np.arange(4)})
    size = 2 * (46 + len("one.npy"))
    with path.open("rb") as file:
        assert Archive(file, size).read("one").tolist() == [0.0, 1.0, 2.0]
        with pytest.raises(ForeignError, match=f"its directory is larger than {size - 1} B"):
            Archive(file, size - 1)


def test_any_damage_of_a_run_is_a_value_error(tmp_path: Path) -> None:
    """Flipped bits of flags and versions made ``zipfile`` raise all kinds of errors."""
    rng = np.random.default_rng(1)
    sealed = RUNS["one"].save(tmp_path / "run.npz").read_bytes()
    path = tmp_path / "damaged.npz"
    for place in rng.integers(0, len(sealed), 50).tolist():
        path.write_bytes(sealed[:place] + bytes([sealed[place] ^ 4]) + sealed[place + 1 :])
        with pytest.raises(ValueError, match=r"is (a damaged run|no run)"):
            rigid.load_run(path)
    # Without the digest, as other programs write archives.
    whole = np.frombuffer(sealed[:-73] + bytes(2), np.uint8)
    directory = len(whole) - 22 - int.from_bytes(whole[-10:-6].tobytes(), "little")
    for place in (*range(directory, len(whole)), *rng.integers(0, directory, 50)):
        damaged = whole.copy()
        damaged[place] ^= rng.integers(1, 256, dtype=np.uint8)
        path.write_bytes(damaged.tobytes())
        with suppress(ValueError):
            rigid.load_run(path)


def test_what_is_no_run_or_no_map_is_named(tmp_path: Path) -> None:
    result = rigid.stability_map(
        rigid.HeavyTop, axes={"spin": [1.0]}, stable=rigid.tilt_below(0.5), t_end=1.0, samples=1
    )
    result.save(tmp_path / "map.npz")
    RUNS["one"].save(tmp_path / "run.npz")
    growth = rigid.lyapunov(BODY, [0.1, 1.0, 0.2], t=[10.0, 20.0], check=False)
    growth.save(tmp_path / "points.npz")
    rigid.stability_map(result.spec, store=tmp_path / "run.rigid")
    (tmp_path / "zarr").mkdir()
    (tmp_path / "zarr" / "zarr.json").write_text("{}")
    (tmp_path / "notes.npz").write_text("some notes\n")
    (tmp_path / "none.npz").write_bytes(b"")
    (tmp_path / "cut.npz").write_bytes((tmp_path / "run.npz").read_bytes()[:1000])
    np.save(tmp_path / "array.npy", np.zeros(3))
    np.savez(tmp_path / "arrays.npz", np.zeros(3))
    kinds = {
        "map.npz": "a map, which rigid.load_map reads",
        "run.npz": "a run, which rigid.load_run reads",
        "points.npz": "a section or indicators of chaos, which numpy.load reads",
        "run.rigid": "a folder of a running map, which rigid.open_store reads",
        "zarr": "a folder of Zarr, which xarray.open_zarr reads",
        ".": "a folder",
        "notes.npz": "a text",
        "none.npz": "empty",
        "cut.npz": "cut or damaged",
        "array.npy": "a single array of NumPy",
        "arrays.npz": "an archive of other arrays",
    }
    for name, kind in kinds.items():
        path = tmp_path / name
        if name != "run.npz":
            with pytest.raises(ValueError, match=f"path = .* it is {re.escape(kind)}$"):
                rigid.load_run(path)
        if name != "map.npz":
            with pytest.raises(
                ValueError, match=f"{re.escape(str(path))} is .* {re.escape(kind)}$"
            ):
                rigid.load_map(path)


def test_the_angular_momentum_of_a_free_body_is_constant_in_space() -> None:
    run = RUNS["one"]
    space = run.momentum("space")
    expected = Rotation.from_quat(QUATERNION, scalar_first=True).apply(
        np.array(BODY.moments) * [0.1, 1.0, 0.2]
    )
    assert np.allclose(space, expected, rtol=0, atol=1e-14)
    assert np.array_equal(run.momentum(), run.omega * BODY.moments)


def test_the_vertical_angular_momentum_of_a_top_is_constant() -> None:
    run = RUNS["many"]
    assert run.gamma is not None
    space = run.momentum("space")
    assert np.allclose(space[..., 2], space[:, :1, 2], rtol=0, atol=1e-8)
    # The same as L·gamma in the body, from the vertical, another variable of the integration.
    assert np.allclose(space[..., 2], np.vecdot(run.momentum(), run.gamma), atol=1e-13)


def test_a_dataset_has_the_arrays_units_and_coordinates(run: rigid.Run) -> None:
    data = run.to_xarray()
    assert np.array_equal(data.omega.values, run.omega)
    assert data.omega.attrs["units"] == "rad/s"
    assert data.sizes["axis"] == 3
    if run.t.ndim == 1:
        assert np.array_equal(data.t.values, run.t)
    else:
        assert np.array_equal(data.time.values, run.t)
    for name in ("gamma", "attitude", "work", "tangent", "sensitivity"):
        assert (name in data) == (getattr(run, name) is not None)


def test_a_plot_draws_the_rates_of_one_body() -> None:
    axes = RUNS["many"].plot(body=1)
    lines = axes.get_lines()
    assert len(lines) == 3
    for k, line in enumerate(lines):
        assert np.array_equal(line.get_xydata(), np.stack([TIMES, RUNS["many"].omega[1, :, k]], 1))
    assert len(RUNS["one"].plot(axes).get_lines()) == 6


VERSION_2 = {
    *("CCSDS_AEM_VERS", "CREATION_DATE", "ORIGINATOR", "OBJECT_NAME", "OBJECT_ID", "REF_FRAME_A"),
    *("REF_FRAME_B", "TIME_SYSTEM", "START_TIME", "STOP_TIME", "ATTITUDE_TYPE"),
}
"""The mandatory entries of tables 4-2 and 4-3 of CCSDS 504.0-B-2."""


def read_aem(path: Path) -> tuple[dict[str, str], list[str], np.ndarray]:
    """Entries, epochs and numbers of a message, read by hand."""
    text = path.read_text("ascii")
    head, rest = text.split("DATA_START\n")
    entries = dict(line.split(" = ") for line in head.splitlines() if " = " in line)
    rows = [line.split() for line in rest.split("DATA_STOP")[0].splitlines()]
    return entries, [row[0] for row in rows], np.array([row[1:] for row in rows], dtype=float)


def test_an_attitude_ephemeris_has_the_frame_rotation_of_the_standard(tmp_path: Path) -> None:
    run = RUNS["one"]
    path = run.to_aem(tmp_path / "run.aem", epoch="2026-01-31T14:00:00+02:00", object_name="BOX")
    entries, epochs, numbers = read_aem(path)
    assert next(iter(entries)) == "CCSDS_AEM_VERS"
    assert entries["OBJECT_NAME"] == "BOX"
    # Version 2 knows neither ATTITUDE_DIR nor QUATERNION_TYPE: A to B, scalar last.
    assert entries.keys() == VERSION_2
    assert entries["START_TIME"] == epochs[0] == "2026-01-31T11:59:57.000000"
    assert entries["STOP_TIME"] == epochs[-1] == "2026-01-31T12:00:05.000000"
    assert np.all(np.vecdot(numbers[1:], numbers[:-1]) > 0.0)
    assert run.attitude is not None
    for (x, y, z, w), turned in zip(numbers, run.rotation().as_matrix(), strict=True):
        # Wertz, Spacecraft Attitude Determination and Control, eq. (12-13): components from A to B.
        first = [w * w + x * x - y * y - z * z, 2 * (x * y + z * w), 2 * (x * z - y * w)]
        assert np.allclose(first, turned.T[0], rtol=0, atol=1e-14)


def test_an_attitude_ephemeris_ends_where_the_body_ends(tmp_path: Path) -> None:
    t = np.linspace(0.0, 40.0, 81)
    whole = rigid.simulate(rigid.Body((1.0, 2.0, 3.0)), [1e-3, 1.0, 0.0], t=t)
    run = rigid.simulate(
        rigid.Body((1.0, 2.0, 3.0)), [1e-3, 1.0, 0.0], t=t, until=rigid.crosses("omega2")
    )
    flip = float(rigid.exact.flip_times(rigid.Body((1.0, 2.0, 3.0)), [1e-3, 1.0, 0.0], axis=2)[0])
    entries, epochs, numbers = read_aem(run.to_aem(tmp_path / "run.aem", epoch="2026-01-31"))
    last = np.flatnonzero(t <= flip)[-1]
    assert entries["STOP_TIME"] == epochs[-1] == f"2026-01-31T00:00:{t[last]:09.6f}"
    _, _, full = read_aem(whole.to_aem(tmp_path / "whole.aem", epoch="2026-01-31"))
    assert np.array_equal(numbers, full[: last + 1])
    late = rigid.simulate(
        rigid.Body((1.0, 2.0, 3.0)), [1e-3, 1.0, 0.0], t=t[60:], until=rigid.crosses("omega2")
    )
    with pytest.raises(ValueError, match="attitude: none of 21 times has one"):
        late.to_aem(tmp_path / "none.aem", epoch="2026-01-31")


def test_what_messages_and_pictures_refuse(tmp_path: Path) -> None:
    one, many, path = RUNS["one"], RUNS["many"], tmp_path / "a.aem"
    bad: list[tuple[str, rigid.Run, dict[str, Any]]] = [
        ("epoch = 'soon': must be a datetime", one, {"epoch": "soon"}),
        ("epoch = 3: must be", one, {"epoch": 3}),
        ("object_name = ''", one, {"epoch": "2026-01-31", "object_name": ""}),
        ("frame = ", one, {"epoch": "2026-01-31", "frame": "a\nb"}),
        ("body = None: the run has 2 bodies", many, {"epoch": "2026-01-31"}),
        ("body = 2: the run has 2 bodies", many, {"epoch": "2026-01-31", "body": 2}),
        ("beyond the calendar", one, {"epoch": "9999-12-31T23:59:59"}),
        ("record = 'attitude' was not", RUNS["rates"], {"epoch": "2026-01-31"}),
    ]
    for message, run, options in bad:
        with pytest.raises(ValueError, match=message):
            run.to_aem(path, **options)
    close = rigid.simulate(BODY, [0.1, 1.0, 0.2], t=[0.0, 1.0, 1.0 + 1e-8])
    with pytest.raises(
        ValueError, match=r"t\[2\] = 1\.00000001: is the same microsecond as t\[1\]"
    ):
        close.to_aem(path, epoch="2026-01-31")
    assert not path.exists()
    with pytest.raises(ValueError, match="frame = 'sky'"):
        one.momentum("sky")
    with pytest.raises(ValueError, match="record = 'attitude' was not"):
        RUNS["rates"].momentum("space")
    with pytest.raises(ValueError, match="body = None"):
        many.plot()
    for t, end in (([], "10"), ([3.0], "3")):
        rule = f"t = {t}: a plot needs two times or more, such as t=np.linspace(0, {end}, 201)"
        with pytest.raises(ValueError, match=f"^{re.escape(rule)}$"):
            rigid.simulate(BODY, [0.1, 1.0, 0.2], t=t).plot()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert many.to_aem(path, epoch="2026-01-31", body=-1) == path
