"""What is fuzzed: a case of a target is made from a random number, run, and its result checked."""

import io
import json
import math
import warnings
import zipfile
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import odd_values as odd
import rigid
from rigid.cli.toml_map import parse_spec
from rigid.cli.toml_report import parse_report
from rigid.cli.toml_table import SpecError
from rigid.model.parameters import PARAMETERS

MAX_STEPS = 3000


# simulate and plan


def _asked(rng: Random, scene: Any, rate: float, method: str | None) -> dict[str, Any]:
    """A step, an accuracy or a tolerance, where the method has one."""
    kind = rng.random()
    if kind < 0.25:
        return {"step": odd.number(rng, odd.decades(rng, -3, 1) / rate)}
    if kind < 0.5:
        return {"accuracy": odd.number(rng, odd.decades(rng, -9, -1))}
    if kind < 0.6 and isinstance(method, str) and method.startswith("taylor"):
        return {"tolerance": odd.number(rng, odd.decades(rng, -16, -1))}
    return {}


def simulate(rng: Random) -> None:
    scene = odd.scene(rng)
    count = rng.choice([None, None, 1, 2, 5])
    omega = odd.rates(rng, count)
    rate = odd.fastest(scene, omega)
    t = odd.times(rng, rate)
    options: dict[str, Any] = {"method": odd.method(rng, scene)}
    options |= _asked(rng, scene, rate, options["method"])
    for name, value in (
        ("record", rng.choice(["attitude", "axis", "rates"])),
        ("check", rng.random() < 0.8),
        ("threads", rng.choice([None, 1, 2])),
    ):
        if rng.random() < 0.3:
            options[name] = odd.perhaps(rng, value)
    if rng.random() < 0.25:
        options |= events(rng, rate)
        if rng.random() < 0.7:  # other methods are refused
            options["method"] = rng.choice([None, "taylor12", "taylor20"])
    most = odd.whole(rng, rng.choice([1, 50, MAX_STEPS]))
    if isinstance(most, (int, np.integer)):
        most = min(most, MAX_STEPS)
    run = rigid.simulate(
        scene,
        odd.array(rng, omega),
        odd.attitude(rng, count),
        t=odd.array(rng, t),
        max_steps=most,
        **options,
    )
    check_run(run)
    check_events(run)


def events(rng: Random, rate: float) -> dict[str, Any]:
    """Options of a run that watches some events, perhaps until one of them."""
    made = []
    for _ in range(rng.choice([1, 1, 2, 5])):
        name = rng.choice(["omega", "gamma", "tilt", "L"]) + str(rng.choice([1, 2, 3]))
        size = {"o": rate, "g": 1.0, "t": 3.1, "L": rate}[name[0]]
        value = odd.number(rng, size * rng.choice([0.0, rng.uniform(-1.0, 1.0), rng.random()]))
        direction = rng.choice([0, 1, -1])
        if rng.random() < 0.3:
            made.append(rigid.turns(name, direction))
        else:
            made.append(rigid.crosses(name, value, direction))
    options: dict[str, Any] = {"events": made}
    if rng.random() < 0.3:
        options["until"] = odd.perhaps(rng, made[0])
    # Bodies that turn long have many.
    options["count"] = odd.whole(rng, rng.choice([1, 3, 1000]))
    return options


def check_events(run: rigid.Run) -> None:
    """Events are inside the run, in the order of their times, at states of rigid bodies."""
    for found in run.events:
        assert run.end is not None
        assert (found.t > 0.0).all()
        assert (found.t <= np.ravel(run.end)[found.body]).all()
        assert (np.diff(found.body) >= 0).all()
        assert (np.diff(found.t)[np.diff(found.body) == 0] >= 0.0).all()
        assert np.isfinite(found.omega).all()
        assert (np.abs(np.linalg.norm(found.gamma, axis=1) - 1.0) < 0.5).all()


def check_run(run: rigid.Run) -> None:
    """States that are called ok are finite and turn as rigid bodies do."""
    fine = np.isin(run.status, (rigid.Status.OK, rigid.Status.FLAGGED, rigid.Status.DRIFTED))
    for name in ("omega", "gamma", "attitude", "work"):
        values = getattr(run, name)
        if values is not None and run.end is not None:
            # There are none after the end of a body.
            after = run.t > np.asarray(run.end)[..., np.newaxis]
            values = np.where(
                after.reshape(after.shape + (1,) * (values.ndim - after.ndim)), 0, values
            )
        assert values is None or np.isfinite(values[fine]).all(), f"{name} is not finite"
    for name in ("energy_drift", "momentum_drift", "unit_drift"):
        drift = np.asarray(getattr(run, name))[run.status == rigid.Status.OK]
        assert np.all(drift <= 0.1), f"{name} = {drift.max()} is called ok"
    # Bodies may have times of their own.
    assert run.omega.shape[-2:] == (run.t.shape[-1], 3)
    assert all(run.reasons())


def plan(rng: Random) -> None:
    scene = odd.scene(rng)
    omega = odd.rates(rng, None)
    rate = odd.fastest(scene, omega)
    question = odd.perhaps(rng, rng.choice(["attitude", "axis", "rates", criterion(rng, scene)]))
    method = odd.method(rng, scene, maps=not isinstance(question, str))
    options = _asked(rng, scene, rate, None)
    if not isinstance(question, str):
        options.pop("accuracy", None)
    given = {
        "omega": odd.array(rng, omega),
        "t_end": odd.number(rng, odd.decades(rng, -3, 6) / rate),
    }
    if isinstance(question, str):
        given["attitude"] = odd.attitude(rng, None)
    made = rigid.plan(scene, question, method=method, **given, **options)
    assert made.cost is None
    assert made.error is None or 0.0 <= made.error < math.inf
    assert rigid.Plan.from_json(made.to_json()) == made, "changed by JSON"
    assert str(made)


# Maps


def criterion(rng: Random, scene: Any) -> Any:
    """One that the scene knows, about any axis."""
    if rng.random() < 0.5 or (scene.forces and not scene.directions):
        return rigid.no_flip(odd.perhaps(rng, rng.choice([1, 2, 3])))
    reference: str | None = "vertical" if scene.directions else "start"
    if not scene.forces:
        reference = rng.choice([reference, "start", None])
    axis = odd.perhaps(rng, rng.choice([1, 2, 3, -1, -3]))
    return rigid.tilt_below(odd.number(rng, rng.uniform(0.01, 3.1)), axis=axis, reference=reference)


def _start(rng: Random, scene: Any) -> rigid.Start:
    laws: list[Callable[..., rigid.Noise]] = [rigid.normal, rigid.uniform, rigid.direction]
    law = rng.choice(laws)
    given: dict[str, Any] = {}
    if rng.random() < 0.7:
        given["noise"] = law(odd.number(rng, odd.decades(rng, -9, 0)))
    if scene.directions and rng.random() < 0.5:
        given["attitude_noise"] = rng.choice(
            [law(odd.decades(rng, -9, 0)), rigid.uniform_attitude()]
        )
    if rng.random() < 0.5:
        return rigid.Start(omega=odd.array(rng, odd.rates(rng, None)), **given)
    return rigid.Start(
        spin=odd.number(rng, rng.gauss(0.0, 3.0)),
        axis=odd.whole(rng, rng.choice([1, 2, 3])),
        tilt=odd.number(rng, rng.uniform(-3.0, 3.0)),
        **given,
    )


def _axes(rng: Random, scene: Any, start: rigid.Start) -> dict[str, Any]:
    """One or two parameters that have a meaning here, rarely any."""
    able = [name for name, known in PARAMETERS.items() if not known.why_not(scene, start)]
    axes: dict[str, Any] = {}
    for _ in range(rng.choice([1, 1, 2])):
        name = odd.perhaps(rng, rng.choice(able))
        known = PARAMETERS.get(name) if isinstance(name, str) else None
        low = 0.0 if known is None else max(known.lowest, -3.0)
        high = 3.0 if known is None else min(known.highest, 3.0)
        if known is not None and known.place == "moments":
            low, high = 0.5, 1.5
        values = sorted(rng.uniform(low, high) for _ in range(rng.choice([1, 2, 3])))
        axes[name] = odd.array(rng, values)
    return axes


def stability_map(rng: Random) -> rigid.StabilityMap:
    scene = odd.scene(rng, constant=True)
    start = _start(rng, scene)
    rate = max(odd.fastest(scene, np.array(start.omega or [start.spin, 0.0, 0.0])), 1e-6)
    options: dict[str, Any] = {}
    for name, value in (
        ("method", odd.method(rng, scene, maps=True)),
        ("check", odd.number(rng, rng.choice([0.0, 0.07, 0.5, 1.0]))),
        ("step", odd.number(rng, odd.decades(rng, -3, 0) / rate)),
        ("rng", odd.perhaps(rng, rng.choice([0, 1, 2**127, 2**128 - 1]))),
        ("title", odd.perhaps(rng, rng.choice(["", "ω × 𝄞", "a\nb"]))),
        ("threads", odd.whole(rng, rng.choice([1, 2]))),
    ):
        if rng.random() < 0.3:
            options[name] = value
    samples = odd.whole(rng, rng.choice([1, 2, 5]))
    made = rigid.stability_map(
        scene,
        axes=_axes(rng, scene, start),
        samples=samples if np.ndim(samples) == 0 and samples in range(9) else 9,
        t_end=odd.number(rng, odd.decades(rng, -3, 1.5) / rate),
        stable=criterion(rng, scene),
        start=start,
        progress=False,
        max_steps=MAX_STEPS,
        **options,
    )
    check_map(made)
    return made


def check_map(made: rigid.StabilityMap) -> None:
    """The counts add up, the shares are shares."""
    counts = [np.asarray(getattr(made, name)) for name in ("stable", "unstable")]
    counts += [np.asarray(getattr(made, name)) for name in ("undecided", "failed")]
    assert np.all(np.array(counts) >= 0), "a negative count"
    assert np.all(np.sum(counts, axis=0) <= made.spec.samples), "more bodies than samples"
    known = np.isfinite(made.share)
    low, share, high = (values[known] for values in (made.lower, made.share, made.upper))
    assert ((low >= 0.0) & (low <= share) & (share <= high) & (high <= 1.0)).all(), "no share"
    assert made.summary()


# Files


@cache
def _saved() -> tuple[bytes, ...]:
    """The bytes of some maps of every kind."""
    normal = rigid.normal(1e-2)
    top = rigid.HeavyTop(rigid.Body((1.0, 1.2, 0.5)), mgl=1.0, damping=0.1)
    requests: list[dict[str, Any]] = [
        {"scene": rigid.FreeBody, "axes": {"I2/I1": [1.2, 1.5]}, "stable": rigid.no_flip()},
        {
            "scene": rigid.HeavyTop,
            "axes": {"spin": [1.0, 3.0, 5.0], "attitude_noise": [1e-3, 1e-1]},
            "stable": rigid.tilt_below(0.5),
        },
        {
            "scene": top,
            "axes": {"damping3": [0.1, 0.2]},
            "stable": rigid.tilt_below(1.0, axis=3),
            "start": rigid.Start(spin=2.0, noise=normal),
            "title": "damped",
        },
    ]
    with TemporaryDirectory() as folder:
        path = Path(folder, "map.npz")
        made = []
        for request in requests:
            scene = request.pop("scene")
            result = rigid.stability_map(
                scene, samples=4, t_end=2.0, rng=1, progress=False, **request
            )
            result.save(path)
            made.append(path.read_bytes())
    return tuple(made)


def _members(content: bytes) -> dict[str, bytes]:
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def _zipped(members: list[tuple[str, bytes]], compression: int) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", compression) as archive, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a name may come twice
        for name, content in members:
            archive.writestr(zipfile.ZipInfo(name), content, compression)
    return file.getvalue()


def _npy(values: Any, **header: Any) -> bytes:
    """An array as a file, with a header that may be wrong."""
    file = io.BytesIO()
    content: bytes = values.tobytes()
    given = {"descr": values.dtype.str, "fortran_order": False, "shape": values.shape} | header
    np.lib.format.write_array_header_1_0(file, given)
    return file.getvalue() + content


def _spoilt_bytes(rng: Random, content: bytes) -> bytes:
    """Bytes flipped, cut, repeated or put in."""
    data = bytearray(content)
    for _ in range(rng.choice([1, 1, 2, 8])):
        at = rng.randrange(len(data))
        kind = rng.random()
        if kind < 0.5:
            data[at] ^= 1 << rng.randrange(8)
        elif kind < 0.6:
            del data[at:]
        elif kind < 0.8:
            del data[at : at + rng.randrange(1, 40)]
        else:
            data[at:at] = rng.randbytes(rng.randrange(1, 40))
        if not data:
            break
    return bytes(data)


def _spoilt_json(rng: Random, value: Any) -> Any:
    """A leaf of a document replaced, a key gone or one too many."""
    if isinstance(value, dict) and value and rng.random() < 0.97:
        changed = dict(value)
        key = rng.choice(list(value))
        kind = rng.random()
        if kind < 0.92:
            changed[key] = _spoilt_json(rng, value[key])
        elif kind < 0.96:
            del changed[key]
        else:
            changed[rng.choice(["", "x", "version", key + "2"])] = 1
        return changed
    if isinstance(value, list) and value and rng.random() < 0.97:
        place = rng.randrange(len(value))
        return [_spoilt_json(rng, one) if k == place else one for k, one in enumerate(value)]
    if isinstance(value, float) and rng.random() < 0.9:
        return value * rng.choice([1.0, 0.999, 0.5])
    if isinstance(value, int) and rng.random() < 0.8:
        return value + rng.choice([0, 1])
    if (value is None or isinstance(value, str)) and rng.random() < 0.7:
        return value
    return rng.choice(
        [0, 1, -1, 2, 1e308, -1e308, 10**400, 1e-320, True, None, "", "x", [], [1.0] * 3, {}, 0.5]
    )


def _spoilt_array(rng: Random, content: bytes) -> bytes:
    values = np.load(io.BytesIO(content))
    kind = rng.random()
    if kind < 0.35:  # other numbers, some of which a map may hold
        flat = values.copy().ravel()
        flat[rng.randrange(flat.size)] = rng.choice([0, 1, 1, 255 if flat.itemsize == 1 else -1])
        return _npy(flat.reshape(values.shape))
    if kind < 0.5:
        other = rng.choice(["<f4", "<i4", ">i8", "<u8", "u1", "<c16", "?"])
        with np.errstate(invalid="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # not every type holds the numbers
            return _npy(values.astype(other))
    if kind < 0.6:
        return _npy(values, fortran_order=True)
    if kind < 0.7:
        return _npy(values, shape=rng.choice([(), (10**12,), (2**31, 2**31), (-1,), (0,), (1, 6)]))
    if kind < 0.8:
        return _npy(values, descr=rng.choice(["|O", "<f8", "|V8", "<U2", "<M8[s]", "nonsense"]))
    if kind < 0.9:
        return _npy(np.tile(values, rng.choice([2, 10])))
    return _spoilt_bytes(rng, content)


def load_map(rng: Random) -> None:
    content = rng.choice(_saved())
    kind = rng.random()
    if kind < 0.06:
        # With its digest, which sees all damage, or without, as other programs write archives.
        content = _spoilt_bytes(rng, rng.choice([content, content[:-73] + bytes(2)]))
    elif kind < 0.85:
        members = _members(content)
        for _ in range(rng.choice([0, 1, 1, 1, 1, 2])):
            name = rng.choice([*members, *["spec.json.npy"] * 3 * len(members)])
            if name == "spec.json.npy":
                header = json.loads(np.load(io.BytesIO(members[name])).tobytes())
                if rng.random() < 0.95 and isinstance(header, dict) and "spec" in header:
                    header["spec"] = _spoilt_json(rng, header["spec"])
                else:
                    header = _spoilt_json(rng, header)
                text = np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)
                members[name] = _npy(text)
            else:
                members[name] = _spoilt_array(rng, members[name])
        rows = list(members.items())
        if rng.random() < 0.4:
            rng.shuffle(rows)
        if rng.random() < 0.1:
            rows.append((rng.choice(["../../x.npy", "/etc/x", "n\x01", "share.npy"]), b"x"))
        if rng.random() < 0.05:
            rows.pop(rng.randrange(len(rows)))
        packed = rng.random() < 0.03
        content = _zipped(rows, zipfile.ZIP_DEFLATED if packed else zipfile.ZIP_STORED)
    with TemporaryDirectory() as folder:
        path = Path(folder, rng.choice(["map.npz", "ω.npz", "x"]))
        path.write_bytes(content)
        loaded = rigid.load_map(path)
        check_map(loaded)
        again = loaded.save(Path(folder, "again.npz"))
        assert again.read_bytes() == rigid.load_map(again).save(again).read_bytes()
        assert {entry.name for entry in Path(folder).iterdir()} == {path.name, "again.npz"}


# TOML


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, list):
        return f"[{', '.join(map(_toml, value))}]"
    if isinstance(value, dict):
        return f"{{{', '.join(f'{json.dumps(key)} = {_toml(v)}' for key, v in value.items())}}}"
    return repr(value)


def _document(tables: Mapping[str, Any]) -> str:
    lines = [f"{key} = {_toml(v)}" for key, v in tables.items() if not isinstance(v, dict)]
    for name, table in tables.items():
        if isinstance(table, dict):
            lines += [f"[{name}]", *(f"{key} = {_toml(value)}" for key, value in table.items())]
    return "\n".join(lines) + "\n"


def _toml_scene(rng: Random) -> dict[str, Any]:
    top = rng.random() < 0.5
    table: dict[str, Any] = {"kind": "heavy-top" if top else "free-body"}
    if rng.random() < 0.6:
        table["moments"] = odd.moments(rng)
    else:
        table["box"] = [odd.decades(rng, -3, 3) for _ in range(3)]
        table["mass"] = odd.decades(rng, -6, 6)
    if top:
        table["mgl"] = odd.decades(rng, -3, 3)
        if rng.random() < 0.5:
            table["com"] = odd.unit(rng).tolist()
    if rng.random() < 0.2:
        table["damping"] = rng.choice([0.1, 0, [0.1, 0, 2.0]])
    if rng.random() < 0.2:
        table[rng.choice(["torque", "torque_in_space"])] = [0.1, 0, -2.0]
    return table


def _toml_axis(rng: Random) -> dict[str, Any]:
    name = rng.choice(["I1", "I2", "I2/I1", "I3/I1", "spin", "tilt", "noise", "damping1"])
    first, last = rng.uniform(0.5, 0.9), rng.uniform(1.1, 2.0)
    if rng.random() < 0.3:
        return {"name": name, "values": [first, 1, last]}
    table: dict[str, Any] = {
        "name": name,
        "from": first,
        "to": last,
        "count": rng.choice([2, 3, 50]),
    }
    if rng.random() < 0.3:
        table["scale"] = rng.choice(["log", "linear"])
    return table


def _toml_tables(rng: Random) -> dict[str, Any]:
    scene = _toml_scene(rng)
    tables: dict[str, Any] = {"title": rng.choice(["A", "ω"])} if rng.random() < 0.5 else {}
    driven = {"damping", "torque", "torque_in_space"} & set(scene)
    start: dict[str, Any] = {"spin": rng.gauss(0, 3), "axis": rng.choice([1, 2, 3])}
    tables["scene"], tables["x"] = scene, _toml_axis(rng)
    start["noise"] = {"kind": rng.choice(["normal", "uniform", "direction"])}
    if tables["x"]["name"] != "noise":
        start["noise"]["size"] = odd.decades(rng, -6, 0)
    tables["start"] = start
    tables["stable"] = {"criterion": "tilt_below", "angle": rng.uniform(0.1, 3.0)}
    damped = driven or tables["x"]["name"] == "damping1"
    if (damped and scene["kind"] == "free-body") or rng.random() < 0.3:
        tables["stable"] = {"criterion": "no_flip", "axis": rng.choice([1, 2, 3])}
    tables["run"] = {"t_end": odd.decades(rng, -3, 3), "samples": rng.choice([1, 64, 10**6])}
    if rng.random() < 0.3:
        tables["run"] |= {"seed": rng.choice([0, 2**127]), "check": rng.choice([0, 0.5, 1.0])}
    return tables


def _toml_report(rng: Random) -> dict[str, Any]:
    run: dict[str, Any] = {"t_end": odd.decades(rng, -1, 2)}
    if rng.random() < 0.5:
        run |= {"bodies": rng.choice([1, 100]), "errors": [1e-3, 1e-6], "seed": 3}
    if rng.random() < 0.3:
        run["revolutions"] = [run.pop("t_end")]
    start = {"omega": [rng.gauss(0, 1) for _ in range(3)], "tilt": rng.uniform(-3, 3)}
    return {"scene": _toml_scene(rng), "start": start, "run": run}


def _spoilt_tables(rng: Random, tables: dict[str, Any]) -> dict[str, Any]:
    name = rng.choice(list(tables))
    value = tables[name]
    if not isinstance(value, dict) or not value:
        return tables | {name: rng.choice(TOML_MISTAKES)}
    key = rng.choice(list(value))
    kind = rng.random()
    if kind < 0.7:
        changed = value | {key: rng.choice(TOML_MISTAKES)}
    elif kind < 0.85:
        changed = {k: v for k, v in value.items() if k != key}
    else:
        changed = value | {rng.choice(["", "é", key + "s", "count"]): rng.choice(TOML_MISTAKES)}
    return tables | {name: changed}


TOML_MISTAKES: tuple[Any, ...] = (
    *(0, -1, 1, 2.5, 1e308, -1e308, 1e-320, 10**12, 10**18, 10**400, math.inf, math.nan, True),
    *("", "x", "spin", [], [[]], [1.0, "2"], [1.0] * 3, [[1.0] * 3] * 3, {}, {"kind": "normal"}),
)


def _spoilt_text(rng: Random, text: str) -> str:
    kind = rng.random()
    at = rng.randrange(len(text) + 1)
    if kind < 0.3:
        return text[:at] + rng.choice("\x00\x7f\"'[]{}=\n.#é𝄞") + text[at:]
    if kind < 0.5:
        return text[:at] + text[at + rng.randrange(1, 9) :]
    if kind < 0.6:
        return text + f"\n[deep]\na = {'[' * 2000}{']' * 2000}\n"
    if kind < 0.7:
        return text + f"\n[far]\n{'a.' * rng.choice([10, 2000])}a = 1\n"
    if kind < 0.8:
        return text.replace("= ", f"= {'9' * rng.choice([30, 5000])}", 1)
    return text * 2


TOML_FILE = "odd.toml"


def toml(rng: Random) -> None:
    is_map = rng.random() < 0.7
    tables = _toml_tables(rng) if is_map else _toml_report(rng)
    if rng.random() < 0.25:
        tables = _spoilt_tables(rng, tables)
    text = _document(tables)
    if rng.random() < 0.08:
        text = _spoilt_text(rng, text)
    if is_map:
        spec = parse_spec(text, TOML_FILE)
        assert rigid.MapSpec.from_json(spec.to_json()) == spec, "changed by JSON"
    else:
        assert parse_report(text, TOML_FILE).t_end > 0.0


# Closed forms


def exact(rng: Random) -> None:
    kind = rng.randrange(9)
    count = rng.choice([None, 1, 3])
    omega = odd.rates(rng, count)
    if kind == 0:
        found: list[Any] = [
            rigid.exact.flip_times(
                rigid.FreeBody(odd.body(rng)),
                odd.array(rng, omega),
                axis=odd.perhaps(rng, rng.choice([None, 1, 2, 3])),
                count=odd.whole(rng, rng.choice([1, 2, 30])),
            )
        ]
    elif kind == 1:
        motion = rigid.exact.free_body(odd.body(rng), odd.array(rng, omega))
        found = [motion.period]
    elif kind in (2, 3, 4, 5):
        first = odd.decades(rng, -3, 3)
        shape = (first, first, first * rng.uniform(0.01, 1.99))
        top = rigid.HeavyTop(
            rigid.Body(odd.array(rng, shape)), mgl=odd.number(rng, odd.decades(rng, -3, 3))
        )
        if kind == 2:
            motion_of_top = rigid.exact.lagrange_top(
                top, odd.array(rng, omega), odd.attitude(rng, count)
            )
            found = [motion_of_top.period]
        elif kind == 3:
            found = [
                rigid.exact.tilt_time(
                    top,
                    odd.array(rng, omega),
                    odd.attitude(rng, count),
                    limit=odd.number(rng, rng.uniform(0.01, 3.1)),
                )
            ]
        elif kind == 4:
            rates = rigid.exact.steady_precession(
                top,
                odd.array(rng, [rng.uniform(0, 3) for _ in range(4)]),
                odd.number(rng, rng.gauss(0, 10)),
            )
            found = list(rates)
        else:
            found = [
                rigid.exact.sleeping_spin(top),
                rigid.exact.pendulum_period(
                    top,
                    odd.array(rng, [rng.uniform(0.0, 3.1) for _ in range(3)]),
                    axis=odd.whole(rng, rng.choice([1, 2])),
                ),
            ]
    else:
        values = [odd.array(rng, [odd.decades(rng, -20, 20) for _ in range(3)]) for _ in range(4)]
        if kind == 6:
            found = [rng.choice([rigid.exact.carlson_rf, rigid.exact.carlson_rd])(*values[:3])]
        elif kind == 7:
            found = [rigid.exact.carlson_rj(*values), rigid.exact.carlson_rc(*values[:2])]
        else:
            found = [rigid.exact.agm(*values[:2])]
            mc = odd.array(
                rng, [rng.choice([0.0, 1.0, odd.decades(rng, -30, 0)]) for _ in range(3)]
            )
            parts = rigid.exact.jacobi(odd.array(rng, [rng.gauss(0, 10) for _ in range(3)]), mc)
            assert all(np.all(np.abs(part) <= 1.0 + 1e-12) for part in parts), "above one"
    for values in found:
        assert not np.isnan(values).any() or kind == 4, "not a number"


# Arrays

#: Functions of arrays alone, with the shapes of their arrays; n is a small number, or 0.
ARRAY_FUNCTIONS: tuple[tuple[Callable[..., Any], tuple[tuple[str | int, ...], ...]], ...] = (
    (rigid.Body, ((3,),)),
    (rigid.exact.agm, (("n",), ("n",))),
    (rigid.exact.carlson_rf, (("n",), ("n",), ("n",))),
    (rigid.exact.jacobi, (("n",), ("n",))),
    (rigid.rotations.exp_quaternion, (("n", 3),)),
    (rigid.rotations.canonical_quaternion, (("n", 4),)),
    (rigid.rotations.euler_to_matrix, (("n", 3),)),
    (rigid.rotations.hat, (("n", 3),)),
    (rigid.inertia.rotational_energy, (("n", 3), (3,))),
    (rigid.frames.transport, (("n", 3), ("n", 3), ("n", 3))),
)

ODD_NUMBERS = (math.nan, math.inf, -math.inf, -0.0, 0.0, 5e-324, -1e-310, 1e308, -1e308, 2.0**53)


def arrays(rng: Random) -> None:
    """Every form of the same numbers has the same result, or the same refusal."""
    function, shapes = rng.choice(ARRAY_FUNCTIONS)
    n = rng.choice([0, 1, 2, 3])
    share = rng.choice([0.0, 0.0, 0.3])
    plain = []
    for kinds in shapes:
        shape = tuple(n if size == "n" else int(size) for size in kinds)
        if rng.random() < 0.03:
            shape = rng.choice([(), (2,), (0,), (5, 2), (1, 1, 3), *(shape[:-1], (*shape, 1))])
        values = [
            rng.choice(ODD_NUMBERS) if rng.random() < share else rng.uniform(0.5, 0.9)
            for _ in range(math.prod(shape))
        ]
        plain.append(np.array(values).reshape(shape))
    expected = _said(function, plain)
    found = _said(function, [odd.form(rng, one) if one.size and one.ndim else one for one in plain])
    assert found == expected, "another result, or another refusal"
    if isinstance(expected, tuple):
        kind, words = expected
        raise kind(words)


def _said(function: Callable[..., Any], given: list[Any]) -> bytes | tuple[type[Exception], str]:
    """The bytes of a result, or its refusal."""
    try:
        with np.errstate(all="ignore"):
            found = function(*given)
    except (TypeError, ValueError) as error:
        # Before the rule stands the value, as it was given.
        return type(error), str(error).rsplit(": ", 1)[-1]
    if isinstance(found, rigid.Body):
        found = found.moments
    return b"".join(
        np.asarray(part).tobytes() for part in (found if isinstance(found, tuple) else (found,))
    )


TARGETS: Mapping[str, Callable[[Random], object]] = {
    "load_map": load_map,
    "toml": toml,
    "simulate": simulate,
    "stability_map": stability_map,
    "plan": plan,
    "exact": exact,
    "arrays": arrays,
}

#: What each may raise; nothing else, and no warning.
REFUSALS: Mapping[str, tuple[type[Exception], ...]] = {
    "load_map": (ValueError,),
    "toml": (SpecError,),
    **dict.fromkeys(
        ("simulate", "stability_map", "plan", "exact", "arrays"), (ValueError, TypeError)
    ),
}
