"""Names of axes, mirrors and turns of space change no motion: the rates to the bit.

Each change is exact: it moves components and changes signs. One step, and a closed form at any
time, then differ by the order of a few sums in the attitude, in units of its own last place: its
length is 1. So do the rates of a top in another attitude, because its vertical is such a sum. More
steps add more roundings, which the stated error covers.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import rigid
from physics import EVERY_METHOD, present
from rigid.model.scene import Scene

Floats = NDArray[np.float64]
Change = Callable[[Scene, Floats, Floats], tuple[Scene, Floats, Floats]]

ULP = np.finfo(np.float64).eps
STEP = 1.0 / 32.0
BODIES = 60


def _scene(scene: Scene, moments: Floats, com: Floats) -> Scene:
    body = rigid.Body(moments.tolist())
    if isinstance(scene, rigid.HeavyTop):
        return rigid.HeavyTop(body, mgl=scene.mgl, com=com.tolist())
    return rigid.FreeBody(body)


def _com(scene: Scene) -> Floats:
    return np.array(scene.com if isinstance(scene, rigid.HeavyTop) else (0.0, 0.0, 1.0))


def renamed(scene: Scene, omega: Floats, attitude: Floats) -> tuple[Scene, Floats, Floats]:
    """The axes of body and space have each other's names."""
    turned = np.concatenate([attitude[..., :1], np.roll(attitude[..., 1:], 1, axis=-1)], axis=-1)
    moments = np.roll(scene.body.moments, 1)
    return _scene(scene, moments, _com(scene)), np.roll(omega, 1, axis=-1), turned


def mirrored(scene: Scene, omega: Floats, attitude: Floats) -> tuple[Scene, Floats, Floats]:
    """Body and space in a mirror across the first axis: rates are axial vectors."""
    signs = np.array([1.0, -1.0, -1.0])
    com = _com(scene) * [-1.0, 1.0, 1.0]
    return _scene(scene, np.array(scene.body.moments), com), omega * signs, attitude * [1.0, *signs]


def turned_in_the_body(
    scene: Scene, omega: Floats, attitude: Floats
) -> tuple[Scene, Floats, Floats]:
    """The second and the third axis of the body point backward: half a turn."""
    signs = np.array([1.0, -1.0, -1.0])
    w, x, y, z = np.moveaxis(attitude, -1, 0)
    return (
        _scene(scene, np.array(scene.body.moments), _com(scene) * signs),
        omega * signs,
        np.stack([-x, w, z, -y], axis=-1),
    )


def turned_in_space(scene: Scene, omega: Floats, attitude: Floats) -> tuple[Scene, Floats, Floats]:
    """Half a turn about the vertical."""
    w, x, y, z = np.moveaxis(attitude, -1, 0)
    return scene, omega, np.stack([-z, -y, x, w], axis=-1)


SCENES: dict[str, Scene] = {
    "free": rigid.FreeBody(rigid.Body((1.0, 1.3, 1.9))),
    "symmetric": rigid.FreeBody(rigid.Body((1.3, 1.3, 1.9))),
    "top": rigid.HeavyTop(rigid.Body((1.0, 1.3, 1.9)), mgl=1.2, com=(0.6, 0.0, -0.8)),
    "lagrange": rigid.HeavyTop(rigid.Body((1.3, 1.3, 0.7)), mgl=1.2),
}
TOPS = ("top", "lagrange")
CHANGES = (renamed, mirrored, turned_in_the_body, turned_in_space)


def differences(name: str, change: Change, t: list[float], **options: Any) -> tuple[Floats, Floats]:
    """Of rates and attitudes, between the changed motions and the motions of the changed starts.

    In units of the last place of the largest rate of the body, and of 1.
    """
    rng = np.random.default_rng(len(name))
    omega, attitude = rng.standard_normal((BODIES, 3)), rng.standard_normal((BODIES, 4))
    attitude /= np.linalg.norm(attitude, axis=1)[:, None]
    scene, *start = change(SCENES[name], omega, attitude)
    plain = rigid.simulate(SCENES[name], omega, attitude, t=t, check=False, **options)
    other = rigid.simulate(scene, *start, t=t, check=False, **options)
    _, rates, attitudes = change(SCENES[name], plain.omega, present(plain.attitude))
    found = present(other.attitude)
    # A quaternion and its opposite are one attitude.
    signs = np.sign(np.sum(found * attitudes, axis=-1, keepdims=True))
    last_place = ULP * np.abs(rates).max(axis=(1, 2), keepdims=True)
    return np.abs(other.omega - rates) / last_place, np.abs(found - signs * attitudes) / ULP


def is_meant(name: str, change: Change, tops: bool) -> bool:
    """Weight knows the vertical, and not every method knows weight."""
    return name not in TOPS or (tops and change is not renamed)


@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("method", EVERY_METHOD, ids=lambda method: method.name)
def test_a_step_knows_neither_names_nor_mirrors(
    method: rigid.Method, name: str, change: Change
) -> None:
    if not is_meant(name, change, method.tops):
        pytest.skip("not this method, or not with weight")
    rates, attitudes = differences(name, change, [STEP], method=method.name, step=STEP)
    turned_top = name in TOPS and change in (turned_in_the_body, turned_in_space)
    assert rates.max() <= (4.0 if turned_top else 0.0)
    assert attitudes.max() <= 4.0


@pytest.mark.parametrize(
    ("name", "change"),
    [
        *((name, change) for name in ("free", "symmetric") for change in CHANGES),
        ("lagrange", mirrored),
    ],
)
def test_a_closed_form_knows_neither_names_nor_mirrors(name: str, change: Change) -> None:
    rates, attitudes = differences(name, change, [-2.0, 0.5, 30.0], method="exact")
    assert not rates.any()
    assert attitudes.max() <= 4.0
