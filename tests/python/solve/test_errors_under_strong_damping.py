"""What a run says of its error is true where damping ends some rates at once and others slowly.

The truth is a collocation in 80 bits that follows the layer; ``tests/long/strong_damping.py`` takes
thousands of random runs.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import quad_motion
import rigid
import stiff_motion
from adversarial import Case
from physics import Floats
from strong_damping import judge
from verdicts import JUDGED, true_errors

UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])


def case(
    moments: Any, damping: Any, omega: Any, t: Any, attitude: Floats = UPRIGHT, **options: Any
) -> Case:
    scene = rigid.FreeBody(rigid.Body(moments), damping=damping)
    return Case("damped", scene, np.array(omega), attitude, np.array(t), options)


#: Nearly singular matrices: while the fast rates end, the slow one turns the body by a radian.
LAYERS = {
    "two times": case(
        (0.7723251553356494, 1.5040861659575544, 0.9026996853898018),
        [
            [309.25454043108954, 423.59983134937397, -172.91099802925422],
            [423.59983134937397, 1922.598771165088, -349.41640421887837],
            [-172.91099802925422, -349.41640421887837, 107.83386503590341],
        ],
        [1.07928097945697, 0.0, 0.0],
        [0.45914278197532227, 2.7991823127361806],
    ),
    "one undamped direction": case(
        (1.0, 1.0, 0.14389358244923742),
        [
            [27.362880803551846, -27.710823023043083, 1.657197520978254],
            [-27.710823023043083, 35.88382719025225, 12.659952744126633],
            [1.657197520978254, 12.659952744126633, 40.69353112541327],
        ],
        [0.0, 0.0, 0.48208103116157425],
        [8.635742026598802],
    ),
    "a given accuracy": case(
        (0.4439704850288112, 0.9045757936294382, 1.2075108217627957),
        [
            [280.5631096846059, -53.05573435835372, 210.49581210466727],
            [-53.05573435835372, 336.62722772680604, 164.5604628071044],
            [210.49581210466727, 164.5604628071044, 285.9220895634355],
        ],
        [0.0, 2.2580019794235464, 0.0],
        [6.452073302889339, 8.480305243155309, 12.623809798120963, 16.56864808683995],
        method="etd4",
        accuracy=2.8730975771968227e-4,
    ),
    "40000 damping times": case(
        (0.8434667207272508, 1.142998180503973, 1.311395894522842),
        [
            [28949.900775246657, 2173.8893705839027, 8080.53867069897],
            [2173.8893705839027, 15317.272571947622, 922.5183224386078],
            [8080.53867069897, 922.5183224386078, 19621.812155119846],
        ],
        [6.113737387286868, 0.0, 0.0],
        [1.0355132068328998],
        method="etd4",
    ),
}


def test_the_truth_agrees_with_a_series_in_128_bits() -> None:
    layer = LAYERS["two times"]
    top = rigid.HeavyTop(
        rigid.Body((1.0, 1.6, 0.8)),
        mgl=2.0,
        com=(0.0, 0.6, 0.8),
        damping=(8.0, 3.0, 0.1),
        torque=rigid.Torque.body((0.3, -0.2, 0.5)),
    )
    for scene, omega, attitude, t in (
        (layer.scene, layer.omega, layer.attitude, layer.t),
        (top, [0.4, 1.0, -0.3], [0.5, -0.3, 0.7, 0.4], [0.5, 4.0]),
    ):
        truth = stiff_motion.motion(scene, omega, attitude, t)
        series = quad_motion.motion(scene, omega, attitude, t, limit=20000)
        assert truth is not None
        assert series is not None
        # The collocation keeps about the square of its tolerance of 1e-12, in numbers of 1e-19.
        np.testing.assert_allclose(truth.high[:, :7], series.high[:, :7], rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("name", LAYERS)
def test_a_layer_shorter_than_a_step_turns_the_body_by_what_is_stated(name: str) -> None:
    layer = LAYERS[name]
    run, row = layer.run()
    truth = stiff_motion.motion(layer.scene, layer.omega, layer.attitude, layer.t)
    assert truth is not None
    assert run.status in JUDGED
    stated = max(float(run.error), layer.options.get("accuracy", 0.0))
    assert true_errors(layer, run, row, truth).max() <= stated


def test_random_matrices_of_strong_damping_have_true_errors() -> None:
    found = [judge(number, seed=20) for number in range(60)]
    claimed = [one for one in found if one is not None and one.is_claimed]
    assert len(claimed) > 40
    assert all(one.excess <= 1.0 for one in claimed)
