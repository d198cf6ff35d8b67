"""Moments and tensors as people have them: rounded, in single precision, or of no body at all."""

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import rigid
from map_texts import map_text
from physics import Floats
from printed_equations import solved
from rigid import inertia, solids
from rigid.cli import main

PUBLISHED = [(3.0, 5.0, 9.0), (8.0, 4.0, 0.4)]
"""Moments of examples in print that break the triangle inequality by 11 % and by 45 %."""


def plates(count: int, digits: int) -> tuple[Floats, Floats]:
    """Moments of plates of 1/1000 of their longer side, and the same rounded to so many digits."""
    rng = np.random.default_rng(digits)
    a, b = rng.uniform(0.1, 10.0, (2, count))
    mass = 10.0 ** rng.uniform(-3.0, 3.0, count)
    exact = solids.box(a, b, 1e-3 * np.maximum(a, b), mass=mass).tensor
    moments = np.diagonal(exact, axis1=-2, axis2=-1)
    rounded = [[float(f"{moment:.{digits - 1}e}") for moment in row] for row in moments]
    return moments, np.array(rounded)


@pytest.mark.parametrize("digits", [3, 4, 5])
def test_rounded_moments_of_thin_plates_are_those_of_a_body(digits: int) -> None:
    exact, rounded = plates(2000, digits)
    with pytest.warns(rigid.MomentsWarning) as caught:
        bodies = rigid.Body(rounded)
    assert len(caught) == 1  # once for all bodies
    taken = np.array(bodies.moments)
    order = np.argsort(rounded, axis=1, kind="stable")
    ascending = np.take_along_axis(taken, order, axis=1)
    assert (np.diff(ascending, axis=1) >= 0.0).all()
    # A moment moves by a third of the excess, which is at most the rounding of two moments.
    size = exact.max(axis=1, keepdims=True)
    half = 5.0 * 10.0**-digits
    assert (np.abs(taken - rounded) <= (2.0 / 3.0) * half * size * (1.0 + 1e-12)).all()
    assert (np.abs(taken - exact) <= (5.0 / 3.0) * half * size * (1.0 + 1e-12)).all()
    fine = rounded.max(axis=1) * 2.0 <= rounded.sum(axis=1)
    assert 0.5 < fine.mean() < 0.8
    assert np.array_equal(taken[fine], rounded[fine])


def test_a_sheet_of_metal_is_a_flat_body() -> None:
    with pytest.warns(
        rigid.MomentsWarning,
        match=r"^moments = \(21.88, 105.5, 127.4\): the nearest possible moments, \(21.8867, "
        r"105.507, 127.393\), are taken; the largest exceeds the sum of the others by 0.016 %$",
    ) as caught:
        body = rigid.Body((21.88, 105.5, 127.4))
    assert caught[0].filename == __file__
    first, second, third = body.moments
    assert first + second == third
    # 0.0194 of 2.0194 are 0.961 %.
    with pytest.warns(rigid.MomentsWarning, match=r"sum of the others by 0\.96 %$"):
        rigid.Body((1.0, 1.0, 2.0194))
    with pytest.warns(rigid.MomentsWarning):
        rates = rigid.free.euler_rhs((21.88, 105.5, 127.4), [1.0, 1.0, 1.0])
    assert rates.tolist() == rigid.free.euler_rhs(body, [1.0, 1.0, 1.0]).tolist()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert rigid.Body(body.moments) == body == rigid.Body.from_dict(body.to_dict())


def test_tensors_in_single_precision_are_tensors() -> None:
    turns = Rotation.random(500, random_state=1).as_matrix()
    moments = np.random.default_rng(1).dirichlet(np.ones(3), 500) @ (1.0 - np.eye(3))
    singles = turns.astype(np.float32) @ (
        moments.astype(np.float32)[:, :, np.newaxis] * np.swapaxes(turns, 1, 2).astype(np.float32)
    )
    assert singles.dtype == np.float32
    assert (singles != np.swapaxes(singles, 1, 2)).any(axis=(1, 2)).mean() > 0.9
    # Some ten roundings of 2**-24 of the largest moment.
    for found in (
        np.array([rigid.Body.from_tensor(tensor)[0].moments for tensor in singles]),
        inertia.principal_axes(singles).moments,
    ):
        assert np.abs(found - np.sort(moments, axis=1)).max() < 1e-6
    # A plate and a rod whose moments rounding has made impossible.
    for flat in ((1.0, 2.0, 3.0), (0.0, 1.0, 1.0)):
        for turn in turns[:50].astype(np.float32):
            tensor = turn @ (np.diag(flat).astype(np.float32) @ turn.T)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", rigid.MomentsWarning)
                made = inertia.MassProperties(mass=1.0, centre=[0, 0, 0], tensor=tensor)
                axes = inertia.principal_axes(tensor)
                assert rigid.fixed_axis.bearing_torques(tensor, 1.0).torque.shape == (3,)
                if flat[0]:
                    body, _ = rigid.Body.from_tensor(tensor)
                    assert np.abs(np.array(body.moments) - flat).max() < 2e-6
            assert np.abs(axes.moments - flat).max() < 2e-6
            assert np.abs(made.tensor - tensor).max() < 2e-6
            low, middle, high = np.linalg.eigvalsh(made.tensor)
            assert high - middle - low < 1e-14


@pytest.mark.parametrize("moments", PUBLISHED)
def test_published_moments_of_no_body_move_by_eulers_equations(
    moments: tuple[float, float, float], tmp_path: Path
) -> None:
    with pytest.raises(ValueError, match=r"nearest possible moments are .*; physical=False"):
        rigid.Body(moments)
    scene = rigid.FreeBody(rigid.Body(moments, physical=False))
    start, times = [1.0, 0.2, 0.5], np.linspace(0.0, 20.0, 21)
    truth, _ = solved(scene, start, [1.0, 0.0, 0.0, 0.0], times)
    run = rigid.simulate(scene, start, t=times)
    assert run.plan.method == "exact"
    # The truth itself drifts by some 1e-12 in 20 s.
    assert np.abs(run.omega - truth).max() < 1e-11
    for method in ("rk4", "dop853", "taylor16", "splitting4"):
        stepped = rigid.simulate(scene, start, t=times, method=method, accuracy=1e-6)
        assert np.abs(stepped.omega - truth).max() < 1e-6
        assert np.abs(stepped.omega - truth).max() <= stepped.error.max()
    motion = rigid.Motion(scene, start)
    for _ in range(20):
        motion.step(1.0 / 64.0)
    then = rigid.simulate(scene, start, t=[20.0 / 64.0]).omega[-1]
    assert np.abs(motion.omega - then).max() < 1e-5
    run.save(tmp_path / "run.npz")
    again = rigid.load_run(tmp_path / "run.npz")
    assert again.spec["scene"] == scene.to_dict()
    assert again.spec["scene"]["body"]["physical"] is False
    top = rigid.HeavyTop(rigid.Body(moments, physical=False), mgl=1.0, com=(1.0, 0.0, 0.0))
    assert rigid.simulate(top, start, t=[1.0]).status.max() == rigid.Status.OK


def test_maps_of_moments_of_no_body(tmp_path: Path) -> None:
    axes = {"I1": [3.0, 4.5, 20.0], "noise": [0.01, 0.1]}
    start = rigid.Start(omega=(0.0, 1.0, 0.0), noise=rigid.normal(0.1))
    asked: dict[str, Any] = {
        "axes": axes,
        "start": start,
        "stable": rigid.no_flip(axis=2),
        "t_end": 20.0,
    }
    asked |= {"samples": 64, "rng": 1, "progress": False}
    scene = rigid.FreeBody(rigid.Body((3.0, 5.0, 9.0), physical=False))
    made = rigid.stability_map(scene, **asked)
    assert (made.status == 0).all()
    # The middle axis, if I1 is 3 or 4.5, flips; the axis of the least moment, if I1 is 20, does not
    # flip under small noise.
    assert (made.share[:, :2] < 1.0).all()
    assert made.share[0, 2] == 1.0
    sample = made.replay(pixel=(0, 0), sample=3)
    assert sample.run.spec["scene"]["body"]["moments"] == [3.0, 5.0, 9.0]
    made.save(tmp_path / "map.npz")
    again = rigid.load_map(tmp_path / "map.npz")
    assert again.spec == made.spec
    assert again.spec.scene.body.physical is False
    possible = rigid.stability_map(rigid.FreeBody(rigid.Body((4.5, 5.0, 9.0))), **asked)
    assert possible.status[0].tolist() == [3, 0, 3]


def test_a_file_of_moments_of_no_body(tmp_path: Path) -> None:
    text = map_text(
        scene='kind = "free-body"\nmoments = [8, 4, 0.4]\nphysical = false',
        start="omega = [0, 1, 0]",
        x='name = "omega2"\nvalues = [1.0, 2.0]',
        stable='criterion = "no_flip"\naxis = 2',
    )
    (tmp_path / "map.toml").write_text(text)
    assert main(["map", str(tmp_path / "map.toml"), "--check"]) == 0


def test_what_needs_a_body_says_so() -> None:
    scene = rigid.FreeBody(rigid.Body((8.0, 4.0, 0.4), physical=False))
    run = rigid.simulate(scene, [1.0, 0.2, 0.5], t=np.linspace(0.0, 10.0, 101))
    with pytest.raises(ValueError, match=r"free = 'I1': the search stays within moments that a"):
        rigid.fit(scene, run.t, omega=run.omega, free="I1", sigma=0.01)
    assert "physical=False" in scene.words()
    page = run.animate(view="box").page
    assert "flat box: no body has the moments" in page
