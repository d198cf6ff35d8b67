"""Results as Datasets and as tidy tables: names, axes, and the bits of every number."""

import csv
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid

TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
STARTS, ATTITUDE = [[0.3, 0.4, 1.0], [0.1, -0.4, 2.0], [1.0, 0.2, 0.3]], [0.9, 0.3, 0.2, 0.1]


def table(path: Path) -> Mapping[str, Any]:
    """The columns of a table, as texts or, where all are numbers, as numbers."""
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    words = ("verdict", "grazing", "start")
    return {name: c if name in words else c.astype(float) for name, c in columns.items()}


def test_a_run_is_a_row_for_each_body_and_time(tmp_path: Path) -> None:
    t = np.linspace(0.0, 3.0, 7)
    run: Any = rigid.simulate(TOP, STARTS, ATTITUDE, t=t)
    found = table(run.to_csv(tmp_path / "run.csv"))
    np.testing.assert_array_equal(found["body"], np.repeat([0, 1, 2], 7))
    np.testing.assert_array_equal(found["t"], np.tile(t, 3))
    np.testing.assert_array_equal(found["omega2"], run.omega[..., 1].ravel())
    np.testing.assert_array_equal(found["gamma3"], run.gamma[..., 2].ravel())
    np.testing.assert_array_equal(found["w"], run.attitude[..., 0].ravel())
    alone = rigid.simulate(TOP, STARTS[0], ATTITUDE, t=t, record="rates")
    found = table(alone.to_csv(tmp_path / "alone.csv"))
    assert list(found) == ["t", "omega1", "omega2", "omega3"]
    np.testing.assert_array_equal(found["omega3"], alone.omega[:, 2])


def test_bodies_of_two_axes_have_two_indices(tmp_path: Path) -> None:
    run = rigid.simulate(TOP, np.ones((2, 3, 3)), ATTITUDE, t=[1.0, 2.0])
    found = table(run.to_csv(tmp_path / "run.csv"))
    np.testing.assert_array_equal(found["body"], np.repeat([0, 1], 6))
    np.testing.assert_array_equal(found["body1"], np.tile(np.repeat([0, 1, 2], 2), 2))


def test_a_body_that_an_event_ended_has_no_rows_after_its_end(tmp_path: Path) -> None:
    """Rates that damping halves every second: each falls to 1 after the logarithm of its start."""
    start = np.array([0.5, 3.0, 6.0, 20.0])
    body = rigid.FreeBody(rigid.Body((1.0, 1.0, 1.0)), damping=np.log(2.0))
    omega, t = start[:, np.newaxis] * [0.0, 0.0, 1.0], np.arange(0.0, 4.0)
    run = rigid.simulate(body, omega, t=t, until=rigid.crosses("speed", 1.0))
    found = table(run.to_csv(tmp_path / "run.csv"))
    last = np.where(start > 1.0, np.log2(start), np.inf)
    there = [(i, time) for i in range(4) for time in t if time <= last[i]]
    np.testing.assert_array_equal(np.stack([found["body"], found["t"]], axis=1), there)
    exact = [start[i] * 0.5**time for i, time in there]
    np.testing.assert_allclose(found["omega3"], exact, rtol=1e-12)
    alone = rigid.simulate(body, omega[1], t=t, until=rigid.crosses("speed", 1.0))
    assert table(alone.to_csv(tmp_path / "one.csv"))["t"].tolist() == [0.0, 1.0]


def test_more_rows_than_are_written_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = rigid.simulate(TOP, STARTS, ATTITUDE, t=np.linspace(0.0, 3.0, 7))
    whole = run.to_csv(tmp_path / "whole.csv").read_bytes()
    monkeypatch.setattr("rigid.solve.columns.ROWS", 4)
    assert run.to_csv(tmp_path / "parts.csv").read_bytes() == whole
    assert whole.count(b"\r\n") == 22


def test_points_are_a_dataset_and_rows_of_a_table(tmp_path: Path) -> None:
    points = rigid.poincare(TOP, STARTS, ATTITUDE, t_end=20.0)
    data = points.to_xarray()
    assert data.sizes == {"point": len(points), "axis": 3, "part": 4, "motion": 3}
    np.testing.assert_array_equal(data.gamma.sel(axis=1), points.gamma[:, 0])
    np.testing.assert_array_equal(data.attitude.sel(part="w"), points.attitude[:, 0])
    np.testing.assert_array_equal(data.complete, points.complete)
    assert data.omega.units == "rad/s"
    found = table(points.to_csv(tmp_path / "points.csv"))
    for name, column in (
        ("body", points.body),
        ("t", points.t),
        ("gamma2", points.gamma[:, 1]),
        ("z", points.attitude[:, 3]),
        ("direction", points.direction),
        ("error", points.error),
    ):
        np.testing.assert_array_equal(found[name], column)
    assert set(found["grazing"]) == {"False"}


@pytest.fixture(scope="module")
def growth() -> rigid.Growth:
    return rigid.lyapunov(TOP, STARTS, ATTITUDE, t=np.linspace(10.0, 100.0, 10), exponents=3)


def test_growth_is_a_dataset(growth: rigid.Growth) -> None:
    data = growth.to_xarray()
    assert data.sizes == {"body": 3, "t": 10, "exponent": 3, "order": 2}
    assert data.order.values.tolist() == [2, 3]
    assert growth.gali is not None
    np.testing.assert_array_equal(data.gali.sel(order=3), growth.gali[..., 1])
    np.testing.assert_array_equal(data.log_growth.sel(t=100.0), growth.log_growth[:, -1])
    assert data.spectrum.units == "1/s"


def test_growth_is_kept_in_a_file_and_in_a_table(growth: rigid.Growth, tmp_path: Path) -> None:
    with np.load(growth.save(tmp_path / "growth.npz")) as kept:
        np.testing.assert_array_equal(kept["spectrum"], growth.spectrum)
        np.testing.assert_array_equal(kept["verdict"], growth.verdict)
        np.testing.assert_array_equal(kept["t"], growth.t)
        assert '"exponents": 3' in str(kept["spec"])
    found = table(growth.to_csv(tmp_path / "growth.csv"))
    assert growth.sali is not None
    assert growth.gali is not None
    np.testing.assert_array_equal(found["mean_megno"], growth.mean_megno.ravel())
    np.testing.assert_array_equal(found["exponent3"], growth.spectrum[..., 2].ravel())
    np.testing.assert_array_equal(found["sali"], growth.sali.ravel())
    np.testing.assert_array_equal(found["gali2"], growth.gali[..., 0].ravel())
    np.testing.assert_array_equal(found["verdict"], np.repeat(growth.verdict, 10))


def test_growth_is_drawn_over_the_time(growth: rigid.Growth) -> None:
    ax = growth.plot("fli")
    assert ax.get_ylabel() == "FLI"
    assert len(ax.lines) == 3
    np.testing.assert_array_equal(ax.lines[1].get_ydata(), growth.fli[1])
    legend: Any = ax.get_legend()
    of_word = {
        text.get_text(): line.get_color()
        for text, line in zip(legend.get_texts(), legend.get_lines(), strict=True)
    }
    assert set(of_word) == set(growth.verdict.tolist())
    for line, verdict in zip(ax.lines, growth.verdict.tolist(), strict=True):
        assert line.get_color() == of_word[verdict]
    assert growth.plot().get_xscale() == "log"
    alone = rigid.lyapunov(TOP, STARTS[0], ATTITUDE, t=[10.0, 20.0], check=False)
    assert len(alone.plot("megno").lines) == 1
    with pytest.raises(ValueError, match=r"what = 'sali': .*exponents=2"):
        alone.plot("sali")
    with pytest.raises(ValueError, match="what = 'lce': must be one of 'exponent'"):
        growth.plot("lce")


def test_a_map_is_a_row_for_each_pixel(tmp_path: Path) -> None:
    result = rigid.stability_map(
        rigid.FreeBody,
        axes={"I2/I1": [1.2, 1.8, 1.9], "spin": [1.0, 2.0]},
        samples=4,
        t_end=50.0,
        stable=rigid.no_flip(),
        measure=rigid.flips(2),
        rng=2026,
    )
    found = table(result.to_csv(tmp_path / "map.csv"))
    np.testing.assert_array_equal(found["I2/I1"], np.tile([1.2, 1.8, 1.9], 2))
    np.testing.assert_array_equal(found["spin"], np.repeat([1.0, 2.0], 3))
    np.testing.assert_array_equal(found["share"], result.share.ravel())
    np.testing.assert_array_equal(found["stable"], result.stable.ravel())
    (name,) = result.measures
    np.testing.assert_array_equal(found[f"mean of {name}"], result.measures[name].mean.ravel())


# Parts of many bodies that are appended: each body keeps its numbers


RNG = np.random.default_rng(4)
TIMES = [0.0, 0.7, 2.0]
COUNT = 7
OWN = rigid.Body(RNG.uniform(1.0, 1.5, size=(COUNT, 3)), mass=np.arange(COUNT) + 1.0)
MGL, COM = np.arange(COUNT) + 0.5, np.eye(3)[[0, 1, 2, 0, 1, 2, 0]]
IN_BODY, IN_SPACE = (np.outer(np.arange(COUNT), axis) for axis in ([1.0, 0, 2.0], [0, 3.0, 0]))
SAMPLES = np.arange(COUNT * 6.0).reshape(COUNT, 2, 3)
OF_SOME = np.array([0.0, 0.0, 0.0, 0.1, 0.0, 0.2, 0.0])  # none of the first, and of one at the end
ROTOR = np.outer([1, 1, 1, 0, 0, 0, 1], [0.0, 0.0, 0.3])
DRAG = np.outer([0, 0, 0, 0, 1, 1, 1], [0.1, 0.2, 0.3])
SINKS = np.outer([0, 0, 0, 1, 2, 3, 0], [0.01] * 3)
TORQUE = rigid.Torque.body(IN_BODY) + rigid.Torque.space(IN_SPACE)
TABLES = rigid.Torque.body(SAMPLES, times=[0.0, 2.0])

PARTS: dict[str, tuple[rigid.FreeBody | rigid.HeavyTop, dict[str, Any]]] = {
    "moments": (rigid.FreeBody(OWN), {"moments": OWN.moments, "mass": OWN.mass}),
    "tops": (
        rigid.HeavyTop(rigid.Body((1.0, 1.2, 0.6)), mgl=MGL, com=COM),
        {"mgl": MGL, "com": COM},
    ),
    "torques": (
        rigid.FreeBody(OWN, torque=TORQUE),
        {"torque": IN_BODY, "torque_in_space": IN_SPACE},
    ),
    "tables": (
        rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)), torque=TABLES),
        {"torque": SAMPLES, "torque_time": [0.0, 2.0]},
    ),
    "damping": (
        rigid.FreeBody(OWN, damping=OF_SOME),
        {"damping": np.multiply.outer(OF_SOME, np.eye(3))},
    ),
    "common damping": (
        rigid.FreeBody(OWN, damping=0.1),
        {"damping": np.multiply.outer(np.full(COUNT, 0.1), np.eye(3))},
    ),
    "rotor and drag": (
        rigid.FreeBody(OWN, rotor=ROTOR, drag=DRAG),
        {"rotor": ROTOR, "drag": DRAG},
    ),
    "energy sinks": (
        rigid.FreeBody(OWN, dissipation=rigid.EnergySink(SINKS)),
        {"dissipation": SINKS},
    ),
}


@pytest.mark.parametrize("case", PARTS)
def test_appended_parts_keep_the_numbers_of_their_bodies(case: str, tmp_path: Path) -> None:
    """Also where nothing acts on any body of a part, and where the last part is one body."""
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("zarr")
    scene, expected = PARTS[case]
    starts = RNG.normal(size=(COUNT, 3))
    mode: dict[str, Any] = {}
    for part in rigid.simulate_chunks(scene, starts, t=TIMES, chunk=3):
        part.to_xarray().to_zarr(tmp_path / "run.zarr", consolidated=False, **mode)
        mode = {"append_dim": "body"}
    with xarray.open_zarr(tmp_path / "run.zarr", consolidated=False) as found:
        assert found.sizes["body"] == COUNT
        for name, values in expected.items():
            np.testing.assert_array_equal(found[name].values, values, err_msg=name)
            assert found[name].dims[0] == ("torque_time" if name == "torque_time" else "body")
            assert found[name].attrs["units"] or name == "com"
        np.testing.assert_array_equal(found.start_omega.values, starts)
        told = json.loads(found.attrs["spec"])["scene"]
        for name in expected.keys() & told.keys() - {"torque"}:
            assert told[name] == f"variable {name}"
        if scene.forces:
            work: Any = rigid.simulate(scene, starts, t=TIMES).work
            np.testing.assert_allclose(found.work.values, work, rtol=0.0, atol=1e-9)


def test_rods_are_computed_in_parts() -> None:
    rod, starts = rigid.Body((2.0, 2.0, 0.0)), [[0.3, 1.0, 0.0], [-1.0, 0.5, 0.0]]
    parts = [part.omega for part in rigid.simulate_chunks(rod, starts, t=TIMES, chunk=1)]
    np.testing.assert_array_equal(np.concatenate(parts), rigid.simulate(rod, starts, t=TIMES).omega)


def test_what_all_bodies_have_in_common_is_no_variable() -> None:
    dataset = rigid.simulate(TOP, RNG.normal(size=(COUNT, 3)), t=TIMES).to_xarray()
    assert not {"moments", "mgl", "com", "damping", "torque"} & set(dataset)
    assert json.loads(dataset.attrs["spec"])["scene"] == TOP.to_dict()


def test_parts_with_zeros_are_saved_and_evaluated(tmp_path: Path) -> None:
    scene, _ = PARTS["damping"]
    part: Any = next(rigid.simulate_chunks(scene, RNG.normal(size=(COUNT, 3)), t=TIMES, chunk=3))
    assert not part.work.any()
    loaded = rigid.load_run(part.save(tmp_path / "run.npz"))
    np.testing.assert_array_equal(loaded.omega, part.omega)
    assert loaded.spec == part.spec
    assert np.abs(loaded.at([0.7]).omega - part.omega[:, 1:2]).max() < 1e-12
