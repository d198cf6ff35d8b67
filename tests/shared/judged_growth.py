"""Random growth of deviation vectors, verdicts on it, lines of signals and drifts of lines, judged.

Each ``judge_`` makes one case of its number and compares it with a truth of its own.
"""

from dataclasses import replace
from typing import Any

import mpmath
import numpy as np

import rigid
from hard_starts import decades, direction, moments, turned_to
from judged import Judged
from physics import Floats, present
from quad_tangent import Acting, gram_schmidt, moved
from rigid.model.scene import Scene
from verdicts import ROUNDINGS

#: The methods that have a tangent.
MOVING_DEVIATIONS = [method.name for method in rigid.methods() if method.tangent]

#: A rounding of an input.
ROUNDING = 2.0**-53


# Growth of deviation vectors


def rounder(rng: np.random.Generator) -> Floats:
    """Moments of any body but the thinnest, whose unit of time is too short for a truth."""
    found = moments(rng)
    rounder: Floats = found + 1e-3 * found.max() * (found.min() < 1e-3 * found.max())
    return rounder


def _growing(rng: np.random.Generator, kind: str) -> tuple[Scene, Acting, Floats, Floats]:
    """A body with its start, also beside a saddle, with what acts on it twice."""
    shape, mgl, com = rounder(rng), decades(rng, -1.0, 1.0), direction(rng)
    omega, attitude = rng.normal(size=3) * decades(rng, -1.0, 1.0), rng.normal(size=4)
    near = decades(rng, -9.0, -1.0)
    if kind in ("lagrange", "upright"):
        shape[1], com = shape[0], np.array([0.0, 0.0, 1.0])
        shape[2] = min(shape[2], 1.95 * shape[0])
    if kind == "upright":
        attitude = turned_to(com, near, 1.0)
        omega = com * rng.uniform(0.0, 2.2) * np.sqrt(mgl * shape[0]) / shape[2]
    if kind == "middle axis":
        omega = np.eye(3)[np.argsort(shape)[1]] + near * rng.normal(size=3)
    outside: dict[str, Any] = {}
    acting: dict[str, Floats] = {}
    if kind == "damped" or (kind in ("driven", "space") and rng.random() < 0.3):
        acting["damping"] = np.diag(rng.random(3)) * decades(rng, -3.0, 0.0) * shape.min()
        outside["damping"] = acting["damping"]
    if kind in ("driven", "space"):
        name = "body" if kind == "driven" else "space"
        acting[name] = rng.normal(size=3) * decades(rng, -2.0, 0.0)
        outside["torque"] = getattr(rigid.Torque, name)(acting[name])
    body = rigid.Body(shape)
    if kind in ("top", "lagrange", "upright") or (outside and rng.random() < 0.5):
        acting["weight"] = mgl * com
        top = rigid.HeavyTop(body, mgl=mgl, com=com, **outside)
        return top, Acting(np.diag(shape), **acting), omega, attitude
    return rigid.FreeBody(body, **outside), Acting(np.diag(shape), **acting), omega, attitude


def _measured(attitude: Any, deviations: Any, scale: float, of: str) -> Any:
    """The vectors whose lengths are the sizes of deviation vectors, in 64 bits."""
    w, x, y, z = attitude / np.sqrt(attitude @ attitude)
    gamma = np.array([2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z])
    vectors = np.array(deviations)
    vectors[:, :3] /= np.longdouble(scale)
    if of == "rates":
        vectors[:, 3:] = np.cross(gamma, vectors[:, 3:])
    return vectors


def _true_growth(
    acting: Acting,
    omega: Floats,
    attitude: Floats,
    t: Floats,
    *,
    of: str,
    start: Floats,
    scale: float,
) -> Any:
    """Logarithms of sizes and of what is left across others, SALI, GALI and mean MEGNO."""
    motion = moved(
        acting, omega, attitude, t,
        deviations=start, scale=scale, of_attitude=of == "attitude", limit=1500,
    )  # fmt: skip
    if motion is None:
        return None
    first = _measured(np.longdouble(attitude), np.longdouble(start), scale, of)
    found: dict[str, Any] = {"log": [], "diagonal": [], "sali": [], "gali": []}
    for row in range(len(t)):
        state = np.longdouble(motion.high[row]) + motion.low[row]
        vectors = _measured(state[3:7], state[9:].reshape(-1, 6), scale, of)
        found["log"].append(0.5 * np.log((vectors[0] @ vectors[0]) / (first[0] @ first[0])))
        found["diagonal"].append(gram_schmidt(vectors) - gram_schmidt(first))
        units = vectors / np.sqrt((vectors**2).sum(axis=1))[:, None]
        pair = (units[0] + units[-1], units[0] - units[-1]) if len(units) == 2 else (units[0],) * 2
        if len(units) > 2:
            pair = (units[0] + units[1], units[0] - units[1])
        found["sali"].append(min(np.sqrt(one @ one) for one in pair))
        found["gali"].append(np.exp(np.cumsum(gram_schmidt(units)))[1:])
    found = {name: np.array(values, dtype=np.longdouble) for name, values in found.items()}
    return {**found, "mean_megno": motion.mean_megno}


GROWING = ("top", "top", "free", "lagrange", "upright", "middle axis", "driven", "damped")


def judge_growth(number: int, seed: int, kinds: tuple[str, ...] = GROWING) -> Judged:
    """Exponents, MEGNO, SALI and GALI; the stated error is that of the logarithm of growth.

    By a series in its own steps mean MEGNO is exact to 1e-6, the other indicators to 1e-8.
    """
    rng = np.random.default_rng([seed, number])
    kind = str(rng.choice(kinds))
    scene, acting, omega, attitude = _growing(rng, kind)
    scale = float(np.sqrt(omega @ omega + np.linalg.norm(acting.weight) / min(scene.body.moments)))
    t = decades(rng, -0.5, 2.0) / scale * np.append(np.sort(rng.uniform(0.05, 1.0, 2)), 1.0)
    of = str(rng.choice(["rates", "attitude"]))
    count = int(rng.integers(1, 6)) if rng.random() < 0.5 else 1
    start = rng.normal(size=(count, 6)) * np.array([scale] * 3 + [1.0] * 3)
    options: dict[str, Any] = {}
    if rng.random() < 0.4:
        options["method"] = str(rng.choice(MOVING_DEVIATIONS))
        if rng.random() < 0.4:
            options["step"] = decades(rng, -2.0, -0.3) / scale
    try:
        found = rigid.lyapunov(
            scene, omega, attitude, t=t, of=of, exponents=count, start=start,
            max_steps=10**6, **options,
        )  # fmt: skip
    except ValueError as error:
        return Judged(kind, "refused", words=str(error))
    if found.status not in (rigid.Status.OK, rigid.Status.COARSE) or found.lost_from <= t[-1]:
        return Judged(kind, "flagged")
    given: dict[str, Any] = {"of": of, "start": start, "scale": scale}
    true = _true_growth(acting, omega, attitude, t, **given)
    if true is None:
        return Judged(kind, "no truth")
    off = float(np.abs(found.log_growth - true["log"]).max())
    if kind not in ("top", "driven", "space", "damped") and found.verdict == "chaotic":
        return Judged(kind, "UNDETECTED", off, words="called chaotic")
    if "method" not in options and found.error < 1e-9:
        others = [np.abs(found.mean_megno - true["mean_megno"]).max() - 1e-6]
        others.append(np.abs(found.spectrum * t[:, None] - true["diagonal"]).max() - 1e-8)
        if count > 1:
            for name in ("sali", "gali"):
                known = true[name] > 1e-8
                relative = np.abs(getattr(found, name) / true[name] - 1.0)[known]
                others.append(relative.max(initial=0.0) - 1e-8)
        if max(others) > 0.0:
            return Judged(kind, "UNDETECTED", float(max(others)), words=f"indicators {others}")
    if off <= found.error:
        return Judged(kind, "right", off, float(found.error))
    shifts = []
    for _ in range(4):
        # Of the vectors, as in verdicts.py: beside a saddle steps round their small parts so too.
        rates, turn = (
            x + np.linalg.norm(x) * ROUNDING * rng.normal(size=x.shape) for x in (omega, attitude)
        )
        body = acting.inertia * (1.0 + ROUNDING * rng.normal(size=3))
        other = _true_growth(replace(acting, inertia=body), rates, turn, t, **given)
        shifts.append(np.inf if other is None else float(np.abs(other["log"] - true["log"]).max()))
    within = off <= 2.0 * ROUNDINGS * np.linalg.norm(shifts) + 4.0 * ROUNDING
    return Judged(
        kind, "within" if within else "UNDETECTED", off, float(found.error), f"of {of}, {options}"
    )


def judge_verdict(number: int, seed: int) -> Judged:
    """Free bodies and Lagrange tops, also beside separatrices: none is chaotic."""
    rng = np.random.default_rng([seed, number])
    kind = str(rng.choice(["free", "lagrange", "upright", "middle axis"]))
    scene, _, omega, attitude = _growing(rng, kind)
    fast = decades(rng, -3.0, 3.0)
    if isinstance(scene, rigid.HeavyTop):
        scene = rigid.HeavyTop(scene.body, mgl=scene.mgl * fast**2)
    t = decades(rng, 0.5, 3.5) / fast
    found = rigid.lyapunov(scene, fast * omega, attitude, t=[t], max_steps=10**6)
    verdict = str(found.verdict)
    words = {"regular": "right", "undecided": "flagged", "failed": "flagged"}
    return Judged(kind, words.get(verdict, "UNDETECTED"), words=f"{verdict} until {t:.3g} s")


# Lines


def judge_lines(number: int, seed: int) -> Judged:
    """One to three lines, real or complex, with white noise or without, near the ends of the band.

    Lines are farther from each other than ``8 pi / T``. A line below ten standard deviations of the
    noise in the transform is no line. Noise beyond the three standard deviations that are stated is
    a rounding of the inputs, so to speak.
    """
    rng = np.random.default_rng([seed, number])
    count, length = int(rng.choice([16, 17, 32, 64, 101, 400, 1001])), decades(rng, -1.0, 4.0)
    t = rng.choice([0.0, -0.5, 1.0, 100.0]) * length + np.linspace(0.0, length, count)
    real, lines = bool(rng.random() < 0.5), int(rng.integers(1, 4))
    noise = float(rng.choice([0.0, 0.0, 1e-12, 1e-6, 1e-2]))
    kind = f"{'real' if real else 'complex'}, noise {noise:g}"
    nyquist, apart = np.pi * (count - 1) / length, 8.2 * np.pi / length
    for _ in range(1000):
        frequency = rng.uniform(0.0 if real else -nyquist, nyquist, lines)
        if rng.random() < 0.3:
            frequency[0] = nyquist * (1.0 - decades(rng, -4.0, -0.5))
        elif real and rng.random() < 0.2:
            frequency[0] = apart * decades(rng, -3.0, 0.0)
        around = np.append(np.sort(frequency), frequency.min() + (np.inf if real else 2 * nyquist))
        if np.diff(around).min() > apart:
            break
    else:
        return Judged(kind, "no truth")
    sizes = 10.0 ** rng.uniform(-rng.choice([0.0, 1.0, 4.0, 8.0]), 0.0, lines)
    amplitude: Any = sizes * np.exp(2j * np.pi * rng.random(lines))
    phases = t.astype(np.longdouble)[:, None] * frequency
    z = np.exp(1j * phases) @ amplitude.astype(np.clongdouble)
    z = z + noise * sizes.max() * (rng.normal(size=count) + 1j * rng.normal(size=count))
    wanted = min(lines + int(rng.random() < 0.3), count // 8)
    found = rigid.frequencies(t, (z.real if real else z).astype(float if real else complex), wanted)
    floor = 10.0 * noise * sizes.max() / np.sqrt(count)
    worst = Judged(kind, "right", 0.0, 1.0)
    for got, size, error in zip(found.frequency, np.abs(found.amplitude), found.error, strict=True):
        there = sizes > max(floor, 1e-13 * sizes.max())
        if np.isnan(got) or size <= max(floor, 1e-9 * sizes.max()) or not there.any():
            continue
        off = np.abs(got - frequency)
        if not real:  # Nyquist's frequency and its negative are one
            off = np.minimum(off, np.abs(2.0 * nyquist - off))
        off = float(off[there].min())
        if off / error > worst.off / worst.stated:
            # The error is three standard deviations of the noise; six are none of it.
            noisy = "within" if noise and off <= 2.0 * error else "UNDETECTED"
            verdict, words = "right" if off <= error else noisy, f"{got} for {frequency.tolist()}"
            worst = Judged(kind, verdict, off, float(error), words)
    return worst


def polhode_rate(shape: Floats, omega: Floats) -> float:
    """``2 pi`` over the period of the rates of a free body, by its elliptic integral in 40 digits.

    Landau and Lifshitz, *Mechanics*, § 37, with the axes so ordered that ``L² > 2 T I_2``.
    """
    with mpmath.workdps(40):
        i, w = (
            [mpmath.mpf(float(x)) for x in values[np.argsort(shape)]] for values in (shape, omega)
        )
        energy = sum(a * b**2 for a, b in zip(i, w, strict=True))
        square = sum((a * b) ** 2 for a, b in zip(i, w, strict=True))
        if square < energy * i[1]:
            i = i[::-1]
        rate2 = (i[2] - i[1]) * (square - energy * i[0]) / (i[0] * i[1] * i[2])
        m = (i[1] - i[0]) * (energy * i[2] - square) / ((i[2] - i[1]) * (square - energy * i[0]))
        return float(mpmath.sqrt(rate2) * mpmath.pi / (2 * mpmath.ellipk(m)))


def judge_drift(number: int, seed: int) -> Judged:
    """Free bodies keep their frequency, and all lines of their rates are multiples of it."""
    rng = np.random.default_rng([seed, number])
    near = rng.random() < 0.4
    shape, omega = rounder(rng), rng.normal(size=3)
    if near:
        omega = np.eye(3)[np.argsort(shape)[1]] + decades(rng, -6.0, -1.0) * rng.normal(size=3)
    kind = "beside the separatrix" if near else "any polhode"
    if len(set(shape.tolist())) < 3:
        return Judged(kind, "no truth")
    rate = polhode_rate(shape, omega)
    turns, samples = decades(rng, 1.0, 2.0), rng.uniform(30.0, 50.0) * (4 if near else 1)
    t = np.linspace(0.0, turns * 2.0 * np.pi / rate, int(turns * samples))
    run = rigid.simulate(rigid.Body(shape), omega, t=t, check=False)
    if run.error > 1e-8 or len(t) > 12_000:
        return Judged(kind, "no truth")
    drift = rigid.frequency_drift(run)
    if np.isnan(drift.drift):  # rates that do not change have no line
        return Judged(kind, "no truth")
    line = rigid.frequencies(t, present(run.omega)[:, int(rng.integers(3))])
    multiple = np.round(line.frequency[0] / rate) * rate
    pairs = [(float(drift.drift), float(drift.error))]
    pairs.append((float(np.abs(line.frequency[0] - multiple)), float(line.error[0])))
    off, error = max(pairs, key=lambda pair: pair[0] / pair[1])
    return Judged(kind, "right" if off <= error else "UNDETECTED", off, error)
