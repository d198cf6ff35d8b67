"""The sentence above a film is true of the motion."""

import json
import re
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rigid
from films import ASYMMETRIC, BOX, OBLATE, TILTED, TOP, film_of, run_of
from rigid.solve.recording import turns_over

THIN = rigid.FreeBody(rigid.Body.box(0.25, 0.08, 0.01, mass=0.3))


def said(page: str) -> str:
    found = re.search(r'"story":"(.*?)"', page)
    assert found
    return json.loads(f'"{found[1]}"')  # type: ignore[no-any-return]


def sign_changes(scene: Any, throw: Any, t_end: float) -> Any:
    """Times at which the rate about axis 2 changes sign, by SciPy from Euler's equations."""
    a, b, c = scene.body.moments

    def euler(_: float, rates: Any) -> list[float]:
        x, y, z = rates
        return [(b - c) / a * y * z, (c - a) / b * z * x, (a - b) / c * x * y]

    found = solve_ivp(
        euler, (0.0, t_end), throw, rtol=1e-12, atol=1e-12, events=lambda _, rates: rates[1]
    )
    return found.t_events[0]


@pytest.mark.parametrize("frames", [2, 301])
def test_the_story_of_a_throw_counts_its_flips_even_between_frames(frames: int) -> None:
    throw = [0.01, 10.0, 0.01]
    flips = sign_changes(THIN, throw, 8.0)
    assert len(flips) == 4
    for t_end, words in [
        (0.5 * flips[0], "does not turn over"),
        (0.5 * (flips[0] + flips[1]), "turns over once"),
        (0.5 * (flips[1] + flips[2]), "turns over twice"),
        (0.5 * (flips[2] + flips[3]), "turns over 3 times"),
    ]:
        story = film_of(run_of(THIN, throw, t=np.linspace(0.0, t_end, frames))).story
        assert story.startswith("A box spins at 10 rad/s about its middle axis, and ")
        assert words in story


def test_a_throw_turns_over_as_late_as_its_film_begins() -> None:
    # The film begins 0.4 s after the throw, and the axis turns over as late as in the whole motion.
    throw = [0.01, 10.0, 0.01]
    flips = sign_changes(THIN, throw, 8.0)
    run = run_of(THIN, throw, t=np.linspace(0.4, 6.0, 8))
    first, count = turns_over(THIN, run.t, run.omega)
    # SciPy errs by 1e-12 a step. Each period depends on the logarithm of the distance 0.01 from the
    # unstable axis, so a thousand steps shift a flip by 1e-7 s at most.
    assert first == pytest.approx(flips[0], abs=1e-6)
    assert count == 3


@pytest.mark.parametrize(
    ("scene", "omega", "attitude", "words"),
    [
        (OBLATE, (0.1, 0.0, 5.0), None, "A symmetric body turns freely: its cone rolls"),
        (ASYMMETRIC, (0.9, 0.1, 1.3), None, "its inertia ellipsoid rolls on a plane"),
        (BOX, (0.9, 0.1, 1.3), None, "A box turns freely for 2 s: L is at rest in space"),
        (BOX, (5.0, 0.01, 0.0), None, "about its longest axis, and does not turn over in 2 s."),
        (
            TOP,
            (0.0, 0.0, 5.0),
            [1.0, 0, 0, 0],
            "about the vertical: in all frames of 2 s its tilt is 0°.",
        ),
        (
            TOP,
            (0.0, 0.0, 5.0),
            TILTED,
            "A heavy top starts at a tilt of 60°: in the frames of 2 s its tilt is between 60°",
        ),
        (
            rigid.FreeBody(BOX.body, torque=rigid.Torque.body((0, 0, 1e-3)), damping=1e-4),
            (0.9, 0.1, 1.3),
            None,
            "A box turns for 2 s under torque and damping.",
        ),
        (
            rigid.FreeBody(BOX.body, orbit=rigid.Orbit(np.pi), rotor=(0.0, 0.0, 1e-4)),
            (0.9, 0.1, 1.3),
            None,
            "A box turns for 2 s (a period of its orbit), under the gravity gradient and a rotor.",
        ),
    ],
)
def test_the_story_is_that_of_the_motion(scene: Any, omega: Any, attitude: Any, words: str) -> None:
    assert words in film_of(run_of(scene, omega, attitude)).story


def test_the_story_of_two_throws_tells_them_apart() -> None:
    near, far = [0.01, 10.0, 0.0], [1e-6, 10.0, 0.0]
    first, second = (rigid.exact.flip_times(THIN, one, count=1)[0] for one in (near, far))
    for throws, t_end, words in [
        ([near, far], 1.8, f"the left box turns over at {first:.2g} s, the right box does not."),
        ([far, near], 1.8, f"the right box turns over at {first:.2g} s, the left box does not."),
        ([near, far], 2.2, f"turns over at {first:.2g} s, the right box at {second:.2g} s."),
        ([near, far], 0.8, "neither box turns over in 0.8 s."),
    ]:
        story = said(run_of(THIN, throws, t=np.linspace(0.0, t_end, 101)).animate().page)
        assert story.startswith("Two throws that differ by 0.01 rad/s: ")
        assert story.endswith(words)
    tops = run_of(TOP, [[0.0, 0.0, 5.0], [0.0, 0.1, 0.5]], TILTED, t=np.linspace(0.0, 6.0, 301))
    tilt = np.rad2deg(np.arccos(tops.gamma[..., 2])).max(axis=1)
    story = said(tops.animate().page)
    assert story.startswith("Two starts that differ by 4.5 rad/s: ")
    assert story.endswith(
        f"in the frames the left top tilts up to {tilt[0]:.0f}°, the right top up to "
        f"{tilt[1]:.0f}°."
    )
    equal = run_of(TOP, [[0.0, 0.0, 5.0]] * 2, TILTED)
    assert said(equal.animate().page) == "The same motion on both sides."
    bodies = run_of(rigid.FreeBody(OBLATE.body), [[1.0, 1.0, 1.0], [0.9, 1.0, 1.0]])
    assert said(bodies.animate().page) == "Two starts that differ by 0.1 rad/s."
    given = "One word, then <another>."
    assert said(bodies.animate(caption=given).page) == given


@pytest.mark.parametrize(
    ("forces", "words"),
    [
        ({"orbit": rigid.Orbit(np.pi)}, "A body turns for 2 s (a period of its orbit)."),
        (
            {"orbit": rigid.Orbit(2.5 * np.pi, 0.2), "drag": 0.1},
            "A body turns for 2 s (2.5 periods of its orbit), under the gravity gradient and drag.",
        ),
        (
            {"orbit": rigid.Orbit.flyby(gm=8.0, periapsis=4.0, speed=2.0, time=1.5)},
            "A body turns for 2 s and passes a planet at t = 1.5 s.",
        ),
        (
            {"orbit": rigid.Orbit.flyby(gm=8.0, periapsis=4.0, speed=2.0, time=3.0)},
            "A body turns for 2 s before it passes a planet.",
        ),
        (
            {"orbit": rigid.Orbit.flyby(gm=8.0, periapsis=4.0, speed=2.0, time=-3.0)},
            "A body turns for 2 s after it passes a planet.",
        ),
    ],
)
def test_the_story_of_a_body_on_an_orbit_says_where_it_is(
    forces: dict[str, Any], words: str
) -> None:
    assert film_of(run_of(rigid.FreeBody(ASYMMETRIC.body, **forces))).story == words
