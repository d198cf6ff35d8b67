# Detumbling by a torque of your own

A satellite leaves its launcher tumbling. Its thrusters or magnets brake each axis by `-k omega`, but no harder than they can. Is it slow after ten
minutes? That depends on the gain `k` and on the first rate, so the answer is a map over both.

## Map the gain of a controller

The torque is a [callback](torque_and_damping.md#any-torque-by-a-callback), which numba compiles where it is installed:

```{code-block} python
import numpy as np, rigid

def brake(t, omega, attitude, data, torque):
    for k in range(3):
        torque[k] = max(-data[1], min(data[1], -data[0] * omega[k]))

def scene(gain):
    data = np.stack([gain, np.full_like(gain, 2e-3)], axis=-1)
    torque = rigid.Torque.call(brake, data, fastest=0.5)
    return rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), torque=torque)

settled = rigid.stability_map(
    scene,
    axes={
        "gain": np.linspace(2e-3, 3e-2, 29),
        "spin": np.linspace(0.05, 0.45, 33),
    },
    start=rigid.Start(spin=0.2, axis=3, noise=rigid.normal(0.02)),
    stable=~rigid.spin_above(0.01), t_end=600.0, samples=100,
)
settled.plot()
```

![Share of satellites that are slow after ten minutes, over gain and first rate](images/detumbling.png)

*Yellow: the satellite has settled. A small gain takes too long; above the border a satellite spins too fast for the largest torque.*

* `data` has a row for each pixel: the gain, which is an axis of the map, and the largest torque, 2 mN m.
* `~rigid.spin_above(0.01)` is true of a body whose `|omega|` falls below 0.01 rad/s before `t_end`: it has settled.
* `fastest` bounds the rates, from which the steps follow.

## Without numba

Python calls the function then. It takes the lock of the interpreter, so one thread works at a time, and a call takes some 5 µs. That is enough for a
small map:

```python
>>> import numpy as np
>>> import rigid
>>> def brake(t, omega, attitude, data, torque):
...     for k in range(3):
...         torque[k] = max(-data[1], min(data[1], -data[0] * omega[k]))
>>> def scene(gain):
...     data = np.stack([gain, np.full_like(gain, 2e-3)], axis=-1)
...     torque = rigid.Torque.call(brake, data, fastest=0.5)
...     return rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), torque=torque)
>>> settled = rigid.stability_map(
...     scene, axes={"gain": [4e-3, 1.2e-2, 3e-2], "spin": [0.1, 0.4]},
...     start=rigid.Start(spin=0.2, axis=3), stable=~rigid.spin_above(0.01),
...     t_end=600.0, samples=1, rng=2026,
... )
>>> settled.stable  # rows: the first rate; columns: the gain
array([[0, 1, 1],
       [0, 0, 1]])
```

A function of C works too, for example by cffi: `Torque.call(ffi.addressof(lib, "brake"), ...)`.

**Check it with a pencil.** The start has no noise here, and the body turns about axis 3 alone. While the torque is saturated the rate falls linearly,
until it is `2e-3 / k`. Then it falls as `exp(-k t / I3)`:

```python
>>> def time_to_settle(gain, rate, slow=0.01, most=2e-3, moment=2.0):
...     knee = min(rate, most / gain)
...     saturated = (rate - knee) * moment / most
...     return saturated + moment / gain * np.log(knee / slow)
>>> gains, rates = (4e-3, 1.2e-2, 3e-2), (0.1, 0.4)
>>> [[round(time_to_settle(k, rate)) for k in gains] for rate in rates]  # s
[[1151, 384, 160], [1844, 702, 460]]
```

The three pixels below 600 s are the stable pixels of the map.

## Find when one body has settled

A run estimates its error. A torque with corners, such as this one, is best left to steps that follow a `tolerance`: they become short at the
corners, and need neither a `step` nor `fastest`. `until` ends the run at an event, here when the body is slow.

```python
>>> torque = rigid.Torque.call(brake, [1.2e-2, 2e-3])
>>> body = rigid.Body((1.0, 1.5, 2.0))
>>> run = rigid.simulate(
...     rigid.FreeBody(body, torque=torque), [0.0, 0.0, 0.1],
...     t=np.linspace(0.0, 900.0, 10), tolerance=1e-9,
...     until=rigid.crosses("omega3", value=0.01),
... )
>>> round(float(run.end), 3), round(float(time_to_settle(1.2e-2, 0.1)), 3)  # s
(383.764, 383.764)
>>> bool(run.error < 1e-6)
True
```

## What a map does with a callback

* **Method.** `"dop853"` integrates each body, and again in half the steps. A body whose two runs disagree is undecided. `rk4` and `midpoint` are
  taken if you name them.
* **Between steps** the motion is a polynomial of order 7, by three further evaluations. What a criterion watches is computed there too.
* **Custom criteria.** A [custom criterion](criteria.md) takes steps by a tolerance, so `fastest` is not needed.
* **Files.** A file does not have the callback. A saved map can be read and drawn. `rigid.load_map(path, scene=scene)` gives the scene again, and
  then bodies can be replayed.
