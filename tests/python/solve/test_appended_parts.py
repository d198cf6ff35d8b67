"""Parts of many bodies as Datasets that are appended: each body keeps its numbers."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid

xarray = pytest.importorskip("xarray")
pytest.importorskip("zarr")

TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
RNG = np.random.default_rng(4)
TIMES = [0.0, 0.7, 2.0]
COUNT = 7
OWN = rigid.Body(RNG.uniform(1.0, 1.5, size=(COUNT, 3)), mass=np.arange(COUNT) + 1.0)
PARTS: dict[str, tuple[rigid.FreeBody | rigid.HeavyTop, dict[str, Any]]] = {
    "moments": (rigid.FreeBody(OWN), {"moments": OWN.moments, "mass": OWN.mass}),
    "tops": (
        rigid.HeavyTop(
            rigid.Body((1.0, 1.2, 0.6)),
            mgl=np.arange(COUNT) + 0.5,
            com=np.eye(3)[[0, 1, 2, 0, 1, 2, 0]],
        ),
        {"mgl": np.arange(COUNT) + 0.5, "com": np.eye(3)[[0, 1, 2, 0, 1, 2, 0]]},
    ),
    "torques": (
        rigid.FreeBody(
            OWN,
            torque=rigid.Torque.body(np.outer(np.arange(COUNT), [1.0, 0.0, 2.0]))
            + rigid.Torque.space(np.outer(np.arange(COUNT), [0.0, 3.0, 0.0])),
        ),
        {
            "torque": np.outer(np.arange(COUNT), [1.0, 0.0, 2.0]),
            "torque_in_space": np.outer(np.arange(COUNT), [0.0, 3.0, 0.0]),
        },
    ),
    "tables": (
        rigid.FreeBody(
            rigid.Body((1.0, 2.0, 3.0)),
            torque=rigid.Torque.body(np.arange(COUNT * 6.0).reshape(COUNT, 2, 3), times=[0.0, 2.0]),
        ),
        {"torque": np.arange(COUNT * 6.0).reshape(COUNT, 2, 3), "torque_time": [0.0, 2.0]},
    ),
    "damping": (  # none of the first bodies, and of one at the end
        rigid.FreeBody(OWN, damping=[0.0, 0.0, 0.0, 0.1, 0.0, 0.2, 0.0]),
        {"damping": np.multiply.outer([0.0, 0.0, 0.0, 0.1, 0.0, 0.2, 0.0], np.eye(3))},
    ),
    "common damping": (
        rigid.FreeBody(OWN, damping=0.1),
        {"damping": np.multiply.outer(np.full(COUNT, 0.1), np.eye(3))},
    ),
    "rotor and drag": (
        rigid.FreeBody(
            OWN,
            rotor=np.outer([1, 1, 1, 0, 0, 0, 1], [0.0, 0.0, 0.3]),
            drag=np.outer([0, 0, 0, 0, 1, 1, 1], [0.1, 0.2, 0.3]),
        ),
        {
            "rotor": np.outer([1, 1, 1, 0, 0, 0, 1], [0.0, 0.0, 0.3]),
            "drag": np.outer([0, 0, 0, 0, 1, 1, 1], [0.1, 0.2, 0.3]),
        },
    ),
    "energy sinks": (
        rigid.FreeBody(
            OWN, dissipation=rigid.EnergySink(np.outer([0, 0, 0, 1, 2, 3, 0], [0.01] * 3))
        ),
        {"dissipation": np.outer([0, 0, 0, 1, 2, 3, 0], [0.01] * 3)},
    ),
}


@pytest.mark.parametrize("case", PARTS)
def test_appended_parts_keep_the_numbers_of_their_bodies(case: str, tmp_path: Path) -> None:
    """Also where nothing acts on any body of a part, and where the last part is one body."""
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
