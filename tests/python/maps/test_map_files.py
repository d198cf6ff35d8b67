"""A map in a file, as JSON, as an xarray Dataset: nothing lost, nothing of the machine, no code."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
import pickle
import random
import tracemalloc
import zipfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

import rigid
from rigid import _core
from rigid._checks.arguments import MESSAGE
from rigid.maps.data import STORED
from rigid.maps.file import file_size
from small_maps import NAMED, assert_same_map, in_blocks, saved_bytes, small_map

FREE: dict[str, Any] = {
    "axes": {"I1": np.linspace(0.4, 3.6, 5), "noise": [0.01, 0.1]},  # the ends are impossible
    "start": rigid.Start(spin=1.0, axis=2, noise=rigid.normal(0.0)),
}


@pytest.fixture
def arrays(tmp_path: Path) -> Iterator[dict[str, Any]]:
    """What a good file holds."""
    with np.load(small_map(**FREE).save(tmp_path / "good.npz")) as file:
        yield dict(file)


# Round trips


def test_measurements_of_the_machine_are_not_saved(tmp_path: Path) -> None:
    result = small_map()
    assert (result.nanoseconds > 0.0).all()
    assert result.elapsed > 0.0
    loaded = rigid.load_map(str(result.save(str(tmp_path / "map.npz"))))
    assert np.isnan(loaded.nanoseconds).all()
    assert np.isnan(loaded.elapsed)
    assert loaded.threads == 0
    with np.load(tmp_path / "map.npz") as file:
        assert set(file.files) == {"spec.json", "x", "y", "share", "lower", "upper"} | set(STORED)
        text = file["spec.json"].tobytes().decode()
    for word in ("nanoseconds", "elapsed", "threads", "isa", "hostname"):
        assert f'"{word}"' not in text


def test_any_program_can_read_the_data(tmp_path: Path) -> None:
    result = small_map()
    path = result.save(tmp_path / "map.npz")
    with zipfile.ZipFile(path) as archive:
        for entry in archive.infolist():
            assert entry.date_time == (1980, 1, 1, 0, 0, 0)
            assert entry.compress_type == zipfile.ZIP_STORED
            assert entry.create_system == 3
    with np.load(path, allow_pickle=False) as file:
        for name in ("stable", "share", "status", "earliest"):
            np.testing.assert_array_equal(file[name], getattr(result, name))
        header = json.loads(file["spec.json"].tobytes())
        np.testing.assert_array_equal(file["x"], result.spec.axes[0].values)
        np.testing.assert_array_equal(file["y"], result.spec.axes[1].values)
    assert header["format"] == "rigid stability map"
    assert header["spec"] == json.loads(result.spec.to_json())


# Files that are no maps


def without_digest(whole: bytes) -> bytes:
    """The archive alone, as other programs write it: its comment is empty."""
    return whole[:-73] + bytes(2)


def sealed(archive: bytes) -> bytes:
    return archive + b"sha256 " + hashlib.sha256(archive).hexdigest().encode()


def refused(path: Path) -> str:
    """The one line that refuses a file."""
    with pytest.raises(ValueError) as caught:
        rigid.load_map(path)
    message = str(caught.value)
    assert "\n" not in message
    assert str(path) in message
    assert len(message) <= len(str(path)) + 1 + MESSAGE
    return message


def test_a_missing_file_is_not_found(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        rigid.load_map(tmp_path / "nothing.npz")


class Bomb:
    """Something whose unpickling would be seen."""

    armed = True

    def __reduce__(self) -> tuple[Callable[..., None], tuple[type[Bomb], str, bool]]:
        return setattr, (Bomb, "armed", False)


@pytest.mark.parametrize("name", ["spec.json", "stable"])
def test_nothing_is_unpickled(name: str, arrays: dict[str, Any], tmp_path: Path) -> None:
    arrays[name] = np.array([Bomb()], dtype=object)
    np.savez(tmp_path / "bomb.npz", allow_pickle=True, **arrays)
    assert f"is damaged: {name} has type object" in refused(tmp_path / "bomb.npz")
    assert Bomb.armed
    with np.load(tmp_path / "bomb.npz", allow_pickle=True) as file:  # that would have been it
        file[name]
    assert not Bomb.armed
    Bomb.armed = True


@pytest.mark.parametrize("keep", [0.1, 0.5, 0.9, 0.999])
def test_a_truncated_file_is_refused(keep: float, tmp_path: Path) -> None:
    whole = saved_bytes(small_map(), tmp_path)
    (tmp_path / "cut.npz").write_bytes(whole[: int(keep * len(whole))])
    assert "is not a stability map" in refused(tmp_path / "cut.npz")


def flips(places: Iterable[int], whole: bytes, path: Path) -> Iterator[Path]:
    """A file with one bit flipped, for each place."""
    generator = random.Random(7)
    for place in places:
        damaged = bytearray(whole)
        damaged[place] ^= 1 << generator.randrange(8)
        path.write_bytes(damaged)
        yield path


def test_a_flipped_bit_is_refused_wherever_it_is(tmp_path: Path) -> None:
    # One digest is of all bytes: some of each array, and all of what follows the last one.
    whole = saved_bytes(small_map(samples=1, axes={"spin": [1.0]}), tmp_path)
    directory = whole.index(b"PK\x01\x02")
    places = [*range(0, directory, 16), *range(directory, len(whole))]
    for damaged in flips(places, whole, tmp_path / "flipped.npz"):
        refused(damaged)


def test_in_an_archive_without_a_digest_a_flipped_bit_is_refused_or_harmless(
    tmp_path: Path,
) -> None:
    # Harmless: in a date, say. Every array has a checksum, and no other error may come through.
    result = small_map(samples=3)
    whole = without_digest(saved_bytes(result, tmp_path))
    directory = whole.index(b"PK\x01\x02")  # where the table of contents begins
    sample = random.Random(7).sample(range(directory), 300)
    places = [*range(directory, len(whole), 3), *sample]
    refusals = []
    for damaged in flips(places, whole, tmp_path / "flipped.npz"):
        try:
            assert_same_map(rigid.load_map(damaged), result)
        except ValueError as error:
            refusals.append(str(error))
    assert len(refusals) > 250
    assert not any("\n" in line for line in refusals)


def test_the_digest_is_that_of_all_bytes_before_it(tmp_path: Path) -> None:
    result = small_map(samples=3)
    whole = saved_bytes(result, tmp_path)
    archive, digest = whole[:-71], whole[-71:]
    assert digest == b"sha256 " + hashlib.sha256(archive).hexdigest().encode()
    with zipfile.ZipFile(tmp_path / "map.npz") as file:
        assert file.comment == digest
        assert file.testzip() is None
    (tmp_path / "without.npz").write_bytes(without_digest(whole))
    assert_same_map(rigid.load_map(tmp_path / "without.npz"), result)
    (tmp_path / "longer.npz").write_bytes(without_digest(whole) + digest)
    assert "digest and content differ" in refused(tmp_path / "longer.npz")
    # A right digest of an archive whose comment has another length.
    (tmp_path / "other.npz").write_bytes(sealed(without_digest(whole)))
    assert "is not a zip file" in refused(tmp_path / "other.npz")


def header_of(arrays: dict[str, Any]) -> Any:
    return json.loads(arrays["spec.json"].tobytes())


def with_header(arrays: dict[str, Any], header: object, path: Path) -> Path:
    text = json.dumps(header).encode()
    np.savez(path, **{**arrays, "spec.json": np.frombuffer(text, dtype=np.uint8)})
    return path


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"format": "something else"}, "its header is another one"),
        ({"format_version": 2}, "has format version 2, this version of rigid reads 1: read it"),
        ({"format_version": None}, "has format version None"),
        ({"spec": {}}, "holds a broken specification"),
        ({"spec": 3}, "holds a broken specification"),
        ({"spec": []}, "holds a broken specification"),
    ],
)
def test_other_headers_are_refused(
    change: dict[str, Any], complaint: str, arrays: dict[str, Any], tmp_path: Path
) -> None:
    header = header_of(arrays)
    assert rigid.load_map(with_header(arrays, header, tmp_path / "good.npz")).complete
    assert complaint in refused(with_header(arrays, {**header, **change}, tmp_path / "bad.npz"))


@pytest.mark.parametrize("bad", [[], 3, "a", None, {}])
@pytest.mark.parametrize("key", ["scene", "start", "axes", "stable", "method", "samples", "seed"])
def test_broken_specifications_are_refused(
    key: str, bad: object, arrays: dict[str, Any], tmp_path: Path
) -> None:
    if (key, bad) in (("samples", 3), ("seed", 3)):
        return  # these are good
    header = header_of(arrays)
    header["spec"][key] = bad
    path = with_header(arrays, header, tmp_path / "bad.npz")
    assert "holds a broken specification" in refused(path)


def test_a_header_that_is_no_json_is_refused(arrays: dict[str, Any], tmp_path: Path) -> None:
    for content in (b"{", b"\xff\xfe", b"[1, 2]", b"null"):
        np.savez(
            tmp_path / "bad.npz",
            **{**arrays, "spec.json": np.frombuffer(content, dtype=np.uint8)},
        )
        assert "is not a stability map" in refused(tmp_path / "bad.npz")


def test_arrays_of_another_shape_or_type_are_refused(
    arrays: dict[str, Any], tmp_path: Path
) -> None:
    path = tmp_path / "bad.npz"
    np.savez(path, **{**arrays, "stable": arrays["stable"][:, :-1]})
    assert "stable has shape (2, 4), expected (2, 5)" in refused(path)
    np.savez(path, **{**arrays, "stable": arrays["stable"] * 1.0})
    assert "stable has type float64" in refused(path)
    np.savez(path, **{name: array for name, array in arrays.items() if name != "unstable"})
    assert "unstable" in refused(path)


def test_arrays_of_the_other_byte_order_are_read(arrays: dict[str, Any], tmp_path: Path) -> None:
    swapped = {name: array.astype(array.dtype.newbyteorder(">")) for name, array in arrays.items()}
    np.savez(tmp_path / "big.npz", **swapped)
    assert_same_map(rigid.load_map(tmp_path / "big.npz"), small_map(**FREE))


# Files that want to take memory, time or trust


@contextmanager
def at_most(size: int) -> Iterator[None]:
    """Python and NumPy take no more memory than so many bytes."""
    tracemalloc.start()
    try:
        yield
        assert tracemalloc.get_traced_memory()[1] < size
    finally:
        tracemalloc.stop()


def test_a_compressed_file_is_refused_before_it_is_unpacked(
    arrays: dict[str, Any], tmp_path: Path
) -> None:
    path = tmp_path / "bomb.npz"
    np.savez_compressed(path, **{**arrays, "stable": np.zeros(10**7, dtype=np.int64)})
    assert path.stat().st_size < 10**6
    with at_most(10**6):
        assert "is not a stability map: spec.json.npy is compressed" in refused(path)


def test_a_long_specification_of_a_small_map_is_refused_before_it_is_read(
    arrays: dict[str, Any], tmp_path: Path
) -> None:
    header = header_of(arrays) | {"more": "[" * 10**6}
    path = with_header(arrays, header, tmp_path / "bomb.npz")
    with at_most(10**6):
        assert "its specification is longer than its arrays" in refused(path)


def test_a_specification_may_fill_a_quarter_of_the_file_and_not_a_byte_more(
    arrays: dict[str, Any], tmp_path: Path
) -> None:
    """And 65536 bytes: those of titles."""
    path, header = tmp_path / "long.npz", header_of(arrays)
    plain = with_header(arrays, header | {"more": "x" * 100_000}, path).stat().st_size
    held = len(json.dumps(header | {"more": "x" * 100_000})) + 128  # with the head of the array
    # The file grows with the specification s: s = 65536 + (plain - held + s) / 4, rounded down.
    most = max(s for s in range(held - 30_000, held) if s <= 2**16 + (plain - held + s) // 4)
    for more, is_read in ((0, True), (1, False)):
        with_header(arrays, header | {"more": "x" * (100_000 + most - held + more)}, path)
        if is_read:
            assert rigid.load_map(path).complete
        else:
            assert "its specification is longer than its arrays" in refused(path)


def test_a_specification_of_more_pixels_than_the_file_has_is_refused(
    arrays: dict[str, Any], tmp_path: Path
) -> None:
    """A grid of many pixels takes much memory before it is compared with any array."""
    header = header_of(arrays)
    header["spec"]["method"] = "exact"  # it asks for the closed forms of all pixels
    for axis in header["spec"]["axes"]:
        axis["values"] = list(range(1, 400))
    path = with_header(arrays, header, tmp_path / "bomb.npz")
    assert "axes: 2 of lengths" in refused(path)
    header["spec"]["axes"] *= 2
    assert "axes: 4 of lengths" in refused(with_header(arrays, header, path))


def test_an_array_that_claims_to_be_large_is_refused_before_it_is_made(
    arrays: dict[str, Any], tmp_path: Path
) -> None:
    path = tmp_path / "bomb.npz"
    with zipfile.ZipFile(path, "w") as archive:
        for name, array in arrays.items():
            content = BytesIO()
            np.save(content, array)
            data = content.getvalue()
            if name == "stable":
                data = data.replace(b"(2, 5), }" + b" " * 9, b"(2, 5000000000), }")
                assert len(data) == len(content.getvalue())
            archive.writestr(f"{name}.npy", data)
    with at_most(10**6):
        assert "stable has shape (2, 5000000000), expected (2, 5)" in refused(path)


def test_a_large_directory_is_refused_before_it_is_read(tmp_path: Path) -> None:
    path = tmp_path / "bomb.npz"
    with zipfile.ZipFile(path, "w") as archive:
        for number in range(2000):
            archive.writestr(f"{number:040}", b"")
    with at_most(10**5):
        assert "its directory is larger than 65536 B" in refused(path)


def test_a_pipe_is_refused_and_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.npz")
    assert "it is no regular file" in refused(tmp_path / "pipe.npz")
    assert "it is a folder" in refused(tmp_path)


def test_a_long_name_in_an_archive_makes_no_long_message(tmp_path: Path) -> None:
    whole = bytearray(saved_bytes(small_map(samples=1), tmp_path))
    path = tmp_path / "long.npz"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("spec.json.npy", bytes(whole[:3000]))
        archive.writestr("n" * 5000, b"")
    data = path.read_bytes().replace(b"n" * 5000, b"\xff" * 5000, 1)
    path.write_bytes(data)
    refused(path)
    with_header({}, {"format": "rigid stability map", "format_version": "v" * 5000}, path)
    assert "has format version vvv" in refused(path)


@pytest.mark.parametrize(
    ("name", "value", "rule"),
    [
        ("stable", -1, "stable[1, 2] = -1: must not be negative"),
        ("steps", -1, "steps[1, 2] = -1: must not be negative"),
        ("earliest", -1.0, "earliest[1, 2] = -1.0: must not be negative"),
        ("unstable", 21, "unstable[1, 2] = 21: more bodies than samples, 20"),
        ("undecided", 1, "the classes have more bodies than 20"),
        ("checked", 21, "checked[1, 2] = 21: more bodies than the classes"),
        ("exact", 21, "exact[1, 2] = 21: more bodies than the classes"),
        ("drifted", 1, "failed[1, 2] = 0: must be the sum of its reasons"),
        ("status", 4, "status[1, 2] = 4: is no known code"),
        ("status", 3, "stable[1, 2] = 20: more bodies than samples"),
    ],
)
def test_numbers_that_no_computation_gives_are_refused(
    name: str, value: float, rule: str, arrays: dict[str, Any], tmp_path: Path
) -> None:
    assert arrays["stable"][1, 2] == 20
    arrays[name] = arrays[name].copy()
    arrays[name][1, 2] = value
    np.savez(tmp_path / "bad.npz", **arrays)
    message = refused(tmp_path / "bad.npz")
    assert "is damaged: " in message
    assert rule in message


def test_a_title_longer_than_a_file_may_hold_is_refused() -> None:
    with pytest.raises(ValueError, match="title of 1001 characters: must have at most 1000"):
        small_map(title="t" * 1001, samples=1)
    with pytest.raises(TypeError, match=r"version = \[\]: must be a string"):
        dataclasses.replace(small_map(samples=1).spec, version=[])  # type: ignore[arg-type]


@pytest.mark.parametrize("points", [1, 20_000])
def test_the_largest_honest_specification_is_read(points: int, tmp_path: Path) -> None:
    """Values with all their digits, and a title that JSON writes with twelve bytes a letter."""
    values = -np.geomspace(1e-300, 1e-200, points)[::-1] * 1.2345678901234567
    result = small_map(
        axes={"omega1": values},
        start=rigid.Start(omega=(0.0, 1.0, 0.0)),
        stable=rigid.no_flip(2),
        samples=1,
        t_end=1e-6,
        title="\U0001f300" * 1000,
    )
    path = result.save(tmp_path / "long.npz")
    assert path.stat().st_size <= file_size(result.spec) <= path.stat().st_size + 25 * 1024
    assert_same_map(rigid.load_map(path), result)


# Files of a core that computed other bits


def test_a_map_of_another_arithmetic_is_not_replayed_in_silence(
    arrays: dict[str, Any], tmp_path: Path
) -> None:
    """Another arithmetic differs in the last bits, as does a start with another last bit."""
    header = header_of(arrays)
    header["spec"]["start"]["spin"] = float(np.nextafter(1.0, 2.0))
    header["spec"]["version"] = "0.0.9"
    loaded = rigid.load_map(with_header(arrays, header, tmp_path / "map.npz"))
    rule = f"this build of rigid {rigid.__version__} does not give the bits of rigid 0.0.9, which"
    for pixel in np.flatnonzero(loaded.status == 0):
        with pytest.raises(ValueError, match=rule):
            loaded.replay(int(pixel), 0)


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("earliest", {"earliest": -1e-14}),
        ("energy_drift", {"energy_drift": 1e-16}),
        ("steps", {"steps": -1}),
        ("stable", {"stable": -1, "unstable": 1}),
    ],
)
def test_a_pixel_whose_numbers_are_not_ours_is_not_replayed(
    name: str, change: dict[str, float], tmp_path: Path
) -> None:
    with np.load(small_map().save(tmp_path / "map.npz")) as file:
        arrays = dict(file)
    mixed = np.argwhere((arrays["stable"] > 0) & (arrays["unstable"] > 0))
    pixel = max(map(tuple, mixed.tolist()), key=lambda index: arrays["earliest"][index])
    for array, difference in change.items():
        arrays[array][pixel] += difference
    np.savez(tmp_path / "other.npz", **arrays)
    loaded = rigid.load_map(tmp_path / "other.npz")
    with pytest.raises(ValueError, match=f"its bodies computed again give {name} = "):
        loaded.replay(pixel, 3)
    assert loaded.replay((4, 2), 3).outcome == small_map().replay((4, 2), 3).outcome


def test_of_a_pixel_of_many_steps_one_body_is_compared(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rigid.maps.replay.MOST_STEPS", 0)
    result = small_map()
    pixel = (4, 2)
    bodies = [result.replay(pixel, sample) for sample in range(20)]
    assert sum(body.outcome == "unstable" for body in bodies) == result.unstable[pixel] > 0
    with np.load(result.save(tmp_path / "map.npz")) as file:
        arrays = dict(file)
    arrays["unstable"], arrays["stable"] = arrays["stable"], arrays["unstable"]
    arrays["stable"][pixel], arrays["unstable"][pixel] = 20, 0
    np.savez(tmp_path / "other.npz", **arrays)
    loaded = rigid.load_map(tmp_path / "other.npz")
    sample = next(body.sample for body in bodies if body.outcome == "unstable")
    told = f"sample {sample} computed again give unstable = 1, the map has 0"
    with pytest.raises(ValueError, match=told):
        loaded.replay(pixel, sample)


def test_a_stable_pixel_in_closed_form_is_vouched_for_by_the_first_to_leave(
    tmp_path: Path,
) -> None:
    """Where no body leaves and nothing drifts, only counts are known."""
    with np.load(small_map(method="exact").save(tmp_path / "map.npz")) as file:
        arrays = dict(file)
    stable = np.unravel_index(np.argmax(arrays["earliest"]), arrays["earliest"].shape)
    assert arrays["stable"][stable] == 20
    first = np.unravel_index(np.argmin(arrays["earliest"]), arrays["earliest"].shape)
    arrays["earliest"][first] = np.nextafter(arrays["earliest"][first], 0.0)
    np.savez(tmp_path / "other.npz", **arrays)
    told = rf"pixel = \({first[0]}, {first[1]}\): its bodies computed again give earliest = "
    with pytest.raises(ValueError, match=told):
        rigid.load_map(tmp_path / "other.npz").replay((int(stable[0]), int(stable[1])), 0)


def test_a_body_that_a_partial_map_does_not_have_can_be_replayed() -> None:
    def stop(progress: rigid.Progress) -> None:
        raise KeyboardInterrupt

    with in_blocks(2):
        partial = small_map(samples=100, t_end=5.0, progress=stop, partial=True)
    assert partial.samples.ravel()[:2].tolist() == [100, 0]
    for pixel, sample in ((0, 19), (0, 99), (1, 9), (2, 0)):
        ours, theirs = (
            one.replay(pixel, sample) for one in (partial, small_map(samples=100, t_end=5.0))
        )
        assert ours.run.omega.tobytes() == theirs.run.omega.tobytes()


# xarray


def test_dataset_has_named_dimensions_units_and_the_specification() -> None:
    result = small_map(title="A title")
    dataset = result.to_xarray()
    assert dict(dataset.sizes) == {"noise": 5, "I2_over_I1": 7}
    assert dataset["share"].dims == ("noise", "I2_over_I1")
    growth = {"growth", "megno", "largest_exponent", "exponent", "mean_megno"}  # of `regular` alone
    assert not growth & set(dataset)
    for name in {*NAMED} - growth:
        np.testing.assert_array_equal(dataset[name].values, getattr(result, name))
        assert dataset[name].attrs["long_name"]
    np.testing.assert_array_equal(dataset["I2_over_I1"], result.spec.axes[0].values)
    np.testing.assert_array_equal(dataset["noise"], result.spec.axes[1].values)
    assert dataset["noise"].attrs["units"] == "rad/s"
    assert dataset["I2_over_I1"].attrs["units"] == "1"
    assert dataset["I2_over_I1"].attrs["long_name"] == "I2/I1"
    assert dataset["earliest"].attrs["units"] == "s"
    for name in ("share", "lower", "upper", "energy_drift", "momentum_drift", "unit_drift"):
        assert dataset[name].attrs["units"] == "1"
    for name in ("share", "lower", "upper"):
        assert "no flip about axis 2 until t = 20 s" in dataset[name].attrs["long_name"]
    assert dataset.attrs["title"] == "A title"
    assert dataset.attrs["criterion"] == "no flip about axis 2 until t = 20 s"
    assert dataset.attrs["complete"] == 1
    assert dataset.attrs["rigid_version"] == rigid.__version__
    assert rigid.MapSpec.from_json(dataset.attrs["spec"]) == result.spec


def test_dataset_of_a_line_and_of_a_loaded_map(tmp_path: Path) -> None:
    result = small_map(axes={"spin": [1.0, 2.0]})
    dataset = rigid.load_map(result.save(tmp_path / "map.npz")).to_xarray()
    assert dataset["share"].dims == ("spin",)
    assert dataset["spin"].attrs["units"] == "rad/s"
    xarray.testing.assert_identical(
        dataset.drop_vars("nanoseconds"), result.to_xarray().drop_vars("nanoseconds")
    )


def test_every_column_of_the_core_is_an_attribute_with_type_unit_and_meaning() -> None:
    result = rigid.stability_map(
        rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.0),
        axes={"spin": [1.0, 3.0]},
        stable=rigid.regular(),
        t_end=10.0,
        samples=2,
        rng=1,
    )
    dataset = result.to_xarray()  # a map of `regular` has every column
    rows = _core.map_columns()
    assert [row["name"] for row in rows if row["reproducible"]] == list(STORED)[:-1]
    for row in rows:
        name = row["name"]
        assert getattr(result, name).dtype == row["dtype"]
        assert getattr(result, name).shape == result.spec.shape
        assert name in dir(result)
        assert dataset[name].attrs == {"long_name": row["words"], "units": row["unit"]}
    with pytest.raises(AttributeError, match="'StabilityMap' object has no attribute 'stabel'"):
        _ = result.stabel


@pytest.mark.parametrize("damped", [False, True])
def test_a_map_survives_a_pickle(damped: bool) -> None:
    scene = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), damping=0.1 if damped else None)
    result = small_map(scene, axes={"spin": [1.0, 2.0]}, samples=2)
    again = pickle.loads(pickle.dumps(result))
    assert again.spec == result.spec
    assert_same_map(again, result)
    assert again.replay(1, 0).outcome == result.replay(1, 0).outcome


def test_status_flags_say_what_they_mean() -> None:
    dataset = small_map(**FREE).to_xarray()
    meanings = dataset["status"].attrs["flag_meanings"].split()
    assert meanings == ["possible", "not_finite", "not_positive", "triangle_inequality_broken"]
    assert dataset["status"].attrs["flag_values"] == [0, 1, 2, 3]
    assert set(np.unique(dataset["status"])) == {0, 3}
