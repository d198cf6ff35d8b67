"""What a function takes from outside is part of the identity of its map."""

from __future__ import annotations

import copy
import dataclasses
import enum
import functools
import importlib
import json
import sys
import threading
from collections.abc import Callable, Sized
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

import rigid
import taking
from processes import python_process
from refusals import refuses
from rigid.model.sourced import Sourced
from small_maps import assert_same_map, small_map
from stores import go_on, stops_after
from taking import GLOBALS, HELD, Judge, below, with_closure

T = np.linspace(0.0, 20.0, 101)
ANY: Any = None


def map_by(judge: Callable[..., Any], **options: Any) -> rigid.StabilityMap:
    """A small map in closed form, which a function judges."""
    asked = {"stable": rigid.judged(judge, T, of="rates"), "t_end": None, "method": "auto"}
    return small_map(**{**asked, "axes": {"noise": [0.01, 0.1]}, **options})


def make_judge(how: str, limit: float, patch: pytest.MonkeyPatch) -> tuple[Judge, str]:
    """A function with a limit, and the name of the limit in what it takes."""
    if how in HELD:
        make, name = HELD[how]
        return make(limit), name
    judge, put, name = GLOBALS[how]
    put(patch, limit)
    return judge, name


@pytest.mark.parametrize("how", [*HELD, *GLOBALS])
def test_a_finished_map_is_not_the_answer_for_another_value(
    how: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The map of another limit is another map; that of the same one goes on, and is loaded."""
    path = tmp_path / "run"
    judge, name = make_judge(how, 0.1, monkeypatch)
    first = map_by(judge, store=path)
    file = first.save(tmp_path / "map.npz")
    same, _ = make_judge(how, 0.1, monkeypatch)
    assert map_by(same, store=path).receipt()["fingerprint"] == first.receipt()["fingerprint"]
    assert rigid.load_map(file, stable=same).replay(0, 0).outcome == first.replay(0, 0).outcome
    other, _ = make_judge(how, 1.0, monkeypatch)
    assert (map_by(other).stable > first.stable).any()
    with pytest.raises(ValueError, match=rf"holds another map .*captured\.{name}: "):
        map_by(other, store=path)
    for open_again in (rigid.load_map, rigid.open_store):
        with pytest.raises(ValueError, match=rf"stable = \w+: {name} is .*, and was .* in '\w+'"):
            open_again(file if open_again is rigid.load_map else path, stable=other)


def test_numbers_are_told_as_they_are(tmp_path: Path) -> None:
    path = tmp_path / "run"
    map_by(with_closure(0.1), store=path)
    with pytest.raises(ValueError, match=r"captured\.limit: \"0.1\" and \"1.0\""):
        map_by(with_closure(1.0), store=path)
    with pytest.raises(ValueError, match=r"limit is 1.0, and was 0.1 in 'judge', which made"):
        rigid.open_store(path, stable=with_closure(1.0))
    taken = dict(Sourced.of("stable", with_closure(np.float64(0.25))).captured)
    assert taken["limit"] == "float64 0.25"
    assert taken["below.np"] == "module numpy"


def test_a_replay_tells_the_cause(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also if the same body was replayed before, whose numbers are remembered."""
    result = map_by(taking.by_global)
    assert result.replay(0, 0).outcome in ("stable", "unstable")
    monkeypatch.setattr(taking, "LIMIT", 1.0)
    with pytest.raises(ValueError, match=r"has \d+: stable = by_global: LIMIT is 1.0, and was 0.1"):
        result.replay(0, 0)
    monkeypatch.setattr(taking, "LIMIT", 0.1)
    result.replay(0, 0)


def test_a_store_that_is_resumed_tells_the_cause(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The value changes after the function was given: stored rows come out otherwise."""
    path = tmp_path / "run"
    spec = map_by(taking.by_global, axes={"noise": np.geomspace(1e-3, 0.1, 20)}).spec
    with monkeypatch.context() as slow:
        slow.setattr("rigid.store.drive.GROWTH", 1)
        assert go_on(path, spec=spec, stop=stops_after(20)).reason == "interrupted"
    store = rigid.open_store(path, stable=taking.by_global)
    assert 0 < store.status().done < 20
    monkeypatch.setattr(taking, "LIMIT", 100.0)
    with pytest.raises(
        ValueError, match=r"LIMIT is 100\.0, and was 0\.1 .* has two results"
    ) as raised:
        store.resume(progress=False)
    assert "this build" not in str(raised.value)


def test_a_map_has_the_value_that_it_was_computed_with(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The criterion was made before the value changed."""
    stable = rigid.judged(taking.by_global, T, of="rates")
    monkeypatch.setattr(taking, "LIMIT", 1.0)
    result = map_by(taking.by_global, stable=stable)
    assert result.spec.to_dict()["stable"]["function"]["captured"]["LIMIT"] == "1.0"
    rigid.load_map(result.save(tmp_path / "map.npz"), stable=taking.by_global).replay(0, 0)
    again = rigid.stability_map(result.spec, progress=False)
    assert again.spec == result.spec
    monkeypatch.setattr(taking, "LIMIT", 0.1)
    assert rigid.stability_map(result.spec, progress=False).spec != result.spec


def test_scenes_take_values_too(tmp_path: Path) -> None:
    """A function that makes scenes, with a default that is no axis."""

    def bodies(length: Any, thickness: float = 0.5) -> rigid.FreeBody:
        moments = [length, 1.3 * length, 2.0 + thickness * length]
        return rigid.FreeBody(rigid.Body(np.stack(moments, axis=-1)))

    path, axes = tmp_path / "run", {"length": [1.5, 2.0]}
    small_map(bodies, axes=axes, store=path)
    with pytest.raises(
        ValueError, match=r"own\.function\.captured\.thickness: \"0.5\" and \"0.6\""
    ):
        small_map(functools.partial(bodies, thickness=0.6), axes=axes, store=path)


class Step(enum.Enum):
    """Its members are values of the class."""

    SMALL = 0.1
    LARGE = 9.0

    def times(self, factor: float) -> float:
        return self.value * factor * taking.LIMIT  # type: ignore[no-any-return]


class Pair(NamedTuple):
    """A tuple whose method takes a global."""

    low: float = 0.1

    def scaled(self) -> float:
        return self.low * taking.LIMIT  # type: ignore[no-any-return]


class Scaled(Sized):
    """Its property takes a global."""

    def __init__(self) -> None:
        self.table = {(1, 2): [np.zeros(2), {Step.SMALL}]}

    def __len__(self) -> int:
        return 0

    @property
    def limit(self) -> float:
        return 0.1 * taking.LIMIT  # type: ignore[no-any-return]


@dataclasses.dataclass(frozen=True, slots=True)
class Slots:
    """A class method of it takes a global."""

    low: float = 0.1

    @classmethod
    def scaled(cls) -> Slots:
        return cls(0.1 * taking.LIMIT)


@functools.lru_cache
def scaled(x: float) -> float:
    return x * taking.LIMIT  # type: ignore[no-any-return]


@pytest.mark.parametrize("value", [Step.SMALL, Step, Pair(), Scaled(), Slots(), scaled])
def test_copies_of_values_are_equal_and_take_what_their_methods_take(
    value: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A copy has the digest; a global that a method names is part of it."""
    one = Sourced.of("stable", with_closure(value))
    assert Sourced.of("stable", with_closure(copy.deepcopy(value))) == one
    monkeypatch.setattr(taking, "LIMIT", 1.0)
    assert Sourced.of("stable", with_closure(value)) != one


def test_members_of_one_enumeration_differ() -> None:
    small, large = (Sourced.of("stable", with_closure(one)) for one in Step)
    assert small != large


def test_a_list_of_one_value_is_not_the_value() -> None:
    values = (below, [below], [[below]], {0: below}, (below,))
    assert len({Sourced.of("stable", with_closure(one)) for one in values}) == 5


def test_digests_depend_on_no_order() -> None:
    """Sets and dicts have another order in each process, and a byte code other addresses."""
    code = (
        "import json, rigid, taking\nwords = {'a', 'b', 'c'}\n"
        "def judge(states):\n    return [one in {'x', 'y', 'z'} for one in words]\n"
        "print(json.dumps(taking.orders(), sort_keys=True))\n"
        "print(json.dumps(rigid.judged(judge, [1.0]).to_dict()['function'], sort_keys=True))\n"
    )
    told = {python_process(code, PYTHONHASHSEED=seed).stdout for seed in "012"}
    assert len(told) == 1
    assert set(json.loads(told.pop().splitlines()[1])["captured"]) == {"words"}


def test_equal_values_have_equal_digests_in_any_order() -> None:
    """A dict that was filled in another order is equal, and functions in it have the same names."""
    judges = {"low": with_closure(0.1), "high": with_closure(9.0)}
    swapped = dict(reversed(judges.items()))
    one, other = (Sourced.of("stable", with_closure(held)) for held in (judges, swapped))
    assert one == other
    assert dict(one.captured)["limit['low'].limit"] == "0.1"


def test_a_module_of_the_user_may_have_the_name_of_one_of_python(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "this.py").write_text("LIMIT = 0.1\ndef judge(states):\n    return LIMIT\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "this", raising=False)
    this: Any = importlib.import_module("this")
    taken = dict(Sourced.of("stable", with_closure(this.judge)).captured)
    assert taken["limit.LIMIT"] == "0.1"
    monkeypatch.delitem(sys.modules, "this")


def test_an_installed_package_of_the_user_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its functions take what they take in the folder where they are written."""
    package = tmp_path / "site-packages" / "judging_package"
    package.mkdir(parents=True)
    (package / "limits.py").write_text("LIMIT = 0.1\ndef low(x):\n    return x < LIMIT\n")
    (package / "__init__.py").write_text(
        "from .limits import low\ndef judge(states):\n    return low(states.omega)\n"
    )
    monkeypatch.syspath_prepend(package.parent)
    from judging_package import judge  # type: ignore[import-not-found, unused-ignore]

    own = dict(Sourced.of("stable", judge).captured)
    assert own["low.LIMIT"] == "0.1"
    named = dict(Sourced.of("stable", with_closure(judge)).captured)
    assert named["limit"] == "judging_package.judge"


def test_functions_without_a_source_differ_by_their_code() -> None:
    def made(text: str) -> Sourced:
        return Sourced.of("stable", eval(text))

    assert made("lambda a, b: a - b").sha256 == made("lambda a, b: a - b").sha256
    # The names are those of axes: the same instructions, another meaning.
    assert made("lambda a, b: a - b").sha256 != made("lambda b, a: b - a").sha256
    assert made("lambda a: [b for b in a]").sha256 != made("lambda a: [-b for b in a]").sha256


def nested(depth: int) -> list[Any]:
    """Lists in each other."""
    whole: list[Any] = []
    for _ in range(depth):
        whole = [whole]
    return whole


def test_a_function_without_a_source_is_doubted_unless_it_was_carried() -> None:
    made: dict[str, Any] = {}
    exec("def above(states):\n    return states", made)
    known = Sourced("above", "0" * 64, function=made["above"])
    assert "its source differs from 'above'" in known.doubt("stable")
    assert known.given("stable", made["above"], carried=True) == known


def test_what_wraps_a_function_is_another_one_unless_it_is_a_cache() -> None:
    def above(states: Any) -> Any:
        return states

    @functools.wraps(above)
    def below(states: Any) -> Any:
        return -above(states)

    class Twice:
        def __init__(self, function: Any) -> None:
            self.__wrapped__ = function

        def __call__(self, states: Any) -> Any:
            return 2.0 * self.__wrapped__(states)

    known, other, twice, cached = (
        Sourced.of("stable", one).sha256
        for one in (above, below, Twice(above), functools.cache(above))
    )
    assert len({known, other, twice}) == 3
    assert cached == known


test_what_has_no_digest_is_named = refuses(
    [
        (threading.Lock(), r"limit: a _thread\.lock has no digest \(cannot pickle"),
        ((k for k in range(3)), r"limit: a builtins\.generator has no digest"),
        ([1, {"log": threading.Lock()}], r"limit\[1\]\['log'\]: a _thread\.lock has no digest"),
        (taking, "limit: the module taking as a whole has no digest; write which of its names"),
        (nested(5000), "nested too deeply"),
    ],
    kind=TypeError,
    by=lambda value: rigid.judged(with_closure(value), T),
)


def test_modules_that_are_imported_while_a_function_runs_are_refused() -> None:
    def judge(states: rigid.States) -> Any:
        import math

        from taking import LIMIT

        return below(states, math.sqrt(LIMIT))

    with pytest.raises(TypeError, match="judge: taking: a module that is imported while the funct"):
        rigid.judged(judge, T)


def test_open_files_are_refused(tmp_path: Path) -> None:
    with (tmp_path / "log").open("w") as file:

        def judge(states: rigid.States) -> Any:
            file.write("judged")
            return states.omega[:, 0, 0] > 0.0

        with pytest.raises(TypeError, match=r"judge: file: a _io\.TextIOWrapper has no digest"):
            rigid.judged(judge, T)


def test_functions_of_installed_packages_are_told_by_name() -> None:
    from scipy import stats
    from scipy.special import j0, j1

    def judge_with(function: Any) -> dict[str, str]:
        return dict(Sourced.of("stable", with_closure(function)).captured)

    assert judge_with(np.linalg.norm)["limit"] == "numpy.linalg.norm"
    assert judge_with(len)["limit"] == "builtins.len"
    assert judge_with(j0)["limit"] != judge_with(j1)["limit"]
    law = stats.norm(0.0, 1.0)
    before = judge_with(law)["limit"]
    np.random.default_rng(0).normal()
    law.rvs()  # of the generator that all share
    assert judge_with(law)["limit"] == before
    assert judge_with(stats.norm(0.0, 2.0))["limit"] != before


def test_a_function_may_count_what_it_judges(tmp_path: Path) -> None:
    """Workers of this process have the function itself."""
    seen: list[int] = []

    def judge(states: rigid.States) -> Any:
        seen.append(len(states.omega))
        return below(states, 0.1)

    with ThreadPoolExecutor(2) as pool:
        counted = map_by(judge, store=tmp_path / "run", executor=pool)
    assert sum(seen) == counted.samples.sum()
    assert counted.replay(1, 3).outcome in ("stable", "unstable")
    assert_same_map(counted, map_by(with_closure(0.1)))


def test_an_object_that_remembers_is_the_same_object() -> None:
    one, other = taking.Judging(0.1), taking.Judging(0.1)
    assert one.used == 1
    assert Sourced.of("stable", one) == Sourced.of("stable", other)


def test_many_names_share_a_digest_and_the_file_is_read(tmp_path: Path) -> None:
    values = {f"a_quantity_with_a_long_name_{k}": lambda x, k=k: x + k for k in range(400)}

    class Many:
        def __init__(self, last: float) -> None:
            vars(self).update(values, last_of_all=last)

        def __call__(self, states: rigid.States) -> Any:
            return below(states, self.last_of_all)  # type: ignore[attr-defined]

    result = map_by(Many(0.1))
    (more,) = (n for n in result.spec.to_dict()["stable"]["function"]["captured"] if "more" in n)
    path = result.save(tmp_path / "map.npz")
    rigid.load_map(path, stable=Many(0.1)).replay(0, 0)
    with pytest.raises(ValueError, match=f"(last_of_all|{more}) is"):
        rigid.load_map(path, stable=Many(0.2))
