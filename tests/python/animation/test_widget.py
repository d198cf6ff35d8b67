"""The map explorer in a notebook: its finer maps, and its view in a browser."""

import base64
import json
import sys
import threading
from importlib import import_module, resources
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid
from pages import unpacked
from rigid.animation.widget import MapWidget
from rigid.store.zooms import zoomed

ASK: dict[str, Any] = {
    "samples": 70,
    "t_end": 20.0,
    "stable": rigid.no_flip(2),
    "start": rigid.Start(spin=1.0, axis=2, noise=rigid.normal(1e-3)),
    "rng": 2026,
}
SPINS = np.arange(1.0, 9.0)
MAP = rigid.stability_map(
    rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0))),
    axes={"spin": SPINS, "noise": [1e-3, 1e-2, 1e-1, 1.0]},
    **ASK,
)
# Cells of half a unit of the spin, and half of the decades of the noise.
VIEW = [2.0, 6.0, float(np.log(1e-3)), float(np.log(1e-1))]


def content_of(widget: MapWidget) -> dict[str, Any]:
    content: dict[str, Any] = json.loads(widget._content)
    return content


def zoom(widget: MapWidget, region: dict[str, Any] | None) -> None:
    """A zoom of the view, as its model asks for it, until it is answered."""
    before = set(threading.enumerate())
    widget.set_state({"_region": region})
    for thread in set(threading.enumerate()) - before:
        thread.join()


def messages(widget: MapWidget, monkeypatch: pytest.MonkeyPatch) -> list[dict[str, Any]]:
    """What the widget sends to its view."""
    sent: list[dict[str, Any]] = []
    monkeypatch.setattr(widget, "send", sent.append)
    return sent


# Finer maps


def test_a_zoom_computes_the_map_of_its_region() -> None:
    widget = MAP.widget(threads=1)
    region = {"view": VIEW, "at": []}
    zoom(widget, region)
    finer = widget.result
    spins, noises = (np.array(axis.values) for axis in finer.spec.axes)
    assert (spins == 2.25 + 0.5 * np.arange(8)).all()
    # The logarithm and its inverse err by 1e-16 of a logarithm of -7.
    np.testing.assert_allclose(noises, 1e-3 * 10 ** (0.25 + 0.5 * np.arange(4)), rtol=4e-15)
    direct = rigid.stability_map(
        rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0))), axes={"spin": spins, "noise": noises}, **ASK
    )
    assert finer.receipt() == direct.receipt()
    shown = content_of(widget)
    (share,) = (layer for layer in shown["layers"] if layer["name"] == "share")
    np.testing.assert_array_equal(unpacked(share["data"]), direct.share.ravel().astype(np.float32))
    assert (shown["region"], widget._said) == (region, "")
    for axis, ends in zip(shown["axes"], (VIEW[:2], VIEW[2:]), strict=True):
        np.testing.assert_allclose([axis["edges"][0], axis["edges"][-1]], ends, rtol=1e-14)
    assert shown["all"][:2] == [0.5, 8.5]
    np.testing.assert_allclose(shown["all"][2:], np.log([10**-3.5, 10**0.5]), rtol=1e-14)
    # Back to the whole map.
    zoom(widget, None)
    assert widget.result is MAP
    assert "all" not in content_of(widget)
    # Only a zoom changes what is shown.
    with pytest.raises(AttributeError):
        widget.result = MAP


def test_finer_maps_stay_between_the_values_of_the_whole_map() -> None:
    falling = MAP.spec.replace(axes={"spin": SPINS[::-1], "noise": [0.0, 0.5, 1.0]})
    # Cells at the border of the whole map reach beyond its values.
    finer = zoomed(falling, [6.5, 8.5, -0.25, 0.25], [])
    spins, noises = (axis.values for axis in finer.axes)
    np.testing.assert_allclose(spins, np.linspace(8.0, 6.625, 8), rtol=1e-15)
    np.testing.assert_allclose(noises, np.linspace(0.0, 0.25 - 0.5 / 6, 3), rtol=1e-15)
    scaled = zoomed(MAP.spec, [0.5, 8.5, *np.log([10**-3.5, 10**-2.5])], [])
    assert scaled.axes[0].values == tuple(SPINS)
    assert 1e-3 <= min(scaled.axes[1].values) < 1e-3 * (1.0 + 1e-14)


def test_other_axes_keep_the_value_that_is_chosen() -> None:
    deep = MAP.spec.replace(
        axes={"spin": SPINS, "noise": [0.1, 0.2], "limit": [0.5, 1.0], "t_end": [5.0, 10.0, 20.0]},
        stable=rigid.tilt_below(1.0, axis=2),
    )
    finer = zoomed(deep, [2.0, 4.0, 0.05, 0.25], [1, 2])
    assert [axis.values for axis in finer.axes[1:]] == [(0.1, 0.2), (1.0,), (20.0,)]
    single = zoomed(deep.replace(axes={"spin": [3.0]}), [2.0, 3.5, 0.0, 1.0], [])
    assert single.axes[0].values == (3.0,)


def test_refined_maps_and_maps_of_own_scenes_are_zoomed_too() -> None:
    def rod(length: Any) -> rigid.FreeBody:
        return rigid.FreeBody(rigid.Body(np.stack([0.1 + 0 * length, length**2, length**2], -1)))

    own = rigid.stability_map(
        rod,
        axes={"length": [1.0, 1.5, 2.0], "spin": np.linspace(1.0, 2.0, 9)},
        refine=2,
        **ASK | {"stable": rigid.tilt_below(0.5, axis=1)},
    )
    widget = own.widget()
    zoom(widget, {"view": [1.25, 1.75, 1.25, 1.75], "at": []})
    assert widget._said == ""
    np.testing.assert_allclose(widget.result.spec.axes[0].values, [1 + 1 / 3, 1.5, 1 + 2 / 3])
    assert widget.result.receipt() == rigid.stability_map(widget.result.spec).receipt()


def test_a_newer_zoom_overtakes_a_computation(monkeypatch: pytest.MonkeyPatch) -> None:
    # Chaotic tops to a horizon that takes minutes.
    long = rigid.stability_map(
        rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8)),
        axes={"spin": [2.0, 3.0]},
        samples=1,
        t_end=1.0,
        stable=rigid.tilt_below(3.0),
        rng=1,
    )
    widget = long.widget(threads=1)
    slow = long.spec.replace(axes={"spin": np.linspace(2.0, 3.0, 400)}, t_end=2e3, samples=64)
    begun = threading.Event()
    say = widget._say

    def said(number: int, words: str) -> None:
        say(number, words)
        if words.endswith("%"):
            begun.set()

    monkeypatch.setattr(widget, "_say", said)
    monkeypatch.setattr("rigid.store.zooms.zoomed", lambda *_: slow)
    before = set(threading.enumerate())
    widget.set_state({"_region": {"view": [2.0, 2.5, 0.0, 1.0], "at": []}})
    (first,) = set(threading.enumerate()) - before
    assert begun.wait(60.0)
    assert widget._said.startswith("computing the finer map: ")
    monkeypatch.undo()
    zoom(widget, {"view": [2.25, 2.75, 0.0, 1.0], "at": []})
    first.join(60.0)  # it ends with the chunk of its bodies
    assert not first.is_alive()
    assert widget.result.spec.axes[0].values == (2.375, 2.625)
    assert widget._said == ""


def test_the_view_tells_what_goes_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    widget = MAP.widget()
    near = float(np.nextafter(2.0, 3.0))
    zoom(widget, {"view": [2.0, near, *VIEW[2:]], "at": []})
    assert widget._said == (
        "The finer map cannot be computed: axes['spin']: must increase or decrease strictly"
    )
    assert widget.result is MAP
    zoom(widget, None)
    assert widget._said == ""
    sent = messages(widget, monkeypatch)
    widget._handle_custom_msg({"pixel": 99, "zoom": 2}, [])
    assert sent[0]["pixel"] == 99
    assert sent[0]["error"].startswith("The bodies cannot be computed: pixel = 99")


def test_a_click_lists_the_bodies_of_the_map_that_is_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    widget = MAP.widget()
    zoom(widget, {"view": VIEW, "at": []})
    sent = messages(widget, monkeypatch)
    widget._handle_custom_msg({"pixel": 29, "zoom": 0}, [])
    assert not sent  # this map is shown no longer
    widget._handle_custom_msg({"pixel": 29, "zoom": 1}, [])
    bodies = json.loads(sent[0]["bodies"])
    count = content_of(widget)["samples"]
    assert count == 64
    for sample in (0, 63):
        seen = widget.result.replay((3, 5), sample)
        assert (unpacked(bodies["omega"]).reshape(-1, 3)[sample] == seen.omega).all()
        assert (unpacked(bodies["attitude"]).reshape(-1, 4)[sample] == seen.attitude).all()
        words = content_of(widget)["classes"][unpacked(bodies["outcome"])[sample]]
        assert words == seen.outcome


def test_functions_that_are_not_known_are_asked_for(tmp_path: Path) -> None:
    judged = rigid.stability_map(
        rigid.FreeBody,
        axes={"spin": [1.0, 2.0]},
        samples=2,
        stable=rigid.judged(lambda states: states.omega[:, -1, 0] > 0.0, [0.0, 5.0]),
        rng=1,
    )
    loaded = rigid.load_map(judged.save(tmp_path / "judged.npz"))
    with pytest.raises(ValueError, match="stable"):
        loaded.widget()


def test_without_anywidget_an_error_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "anywidget", None)
    monkeypatch.delitem(sys.modules, "rigid.animation.widget")
    words = r"^a widget needs anywidget: pip install 'rigid-rotation\[notebook\]'$"
    with pytest.raises(ImportError, match=words):
        import_module("rigid.animation.widget")


# In a browser

TRAITS = ("_page", "_content", "_region", "_said")

# What anywidget gives to the script of a widget: a model with the traits, and an element.
STAND_IN = """<!doctype html><meta charset="utf-8"><div id="cell"></div><script>
const calls = {}, state = JSON.parse(STATE);
const tell = (name, value) => (calls[name] ?? []).forEach(call => call(value));
const take = answer => {
  for (const [name, value] of Object.entries(answer.state)) {
    if (state[name] === value) continue;
    state[name] = value;
    tell(`change:${name}`);
  }
  answer.messages.forEach(message => tell("msg:custom", message));
};
const changed = {};
const model = {
  get: name => state[name],
  set: (name, value) => {
    if (JSON.stringify(state[name]) !== JSON.stringify(value)) changed[name] = state[name] = value;
  },
  save_changes: async () => {
    const told = {...changed};
    for (const name in changed) delete changed[name];
    if (Object.keys(told).length) take(await kernel("state", told));
  },
  send: async message => take(await kernel("message", message)),
  on: (name, call) => (calls[name] ??= []).push(call),
  off: (name, call) => { calls[name] = calls[name].filter(one => one !== call); },
};
const el = document.getElementById("cell");
import(SCRIPT).then(async made => {
  window.clean = await made.default.render({model, el});
});
</script>"""


class Notebook:
    """A widget in a browser, whose kernel is this process."""

    def __init__(self, opens: Any, widget: MapWidget, folder: Path, **options: Any) -> None:
        self.widget = widget
        self.sent: list[dict[str, Any]] = []
        widget.send = self.sent.append
        script = resources.files("rigid.animation").joinpath("page", "widget.js").read_bytes()
        address = "data:text/javascript;base64," + base64.b64encode(script).decode()
        state = json.dumps(json.dumps(self.state())).replace("<", "\\u003c")
        path = folder / "notebook.html"
        path.write_text(STAND_IN.replace("SCRIPT", json.dumps(address)).replace("STATE", state))
        self.opened = opens(path, functions={"kernel": self.answer}, **options)
        self.page = self.opened.page
        self.page.wait_for_selector("iframe")
        self.frame = self.page.frames[1]
        self.frame.wait_for_selector(".map[data-ready]")

    def state(self) -> dict[str, Any]:
        return {name: getattr(self.widget, name) for name in TRAITS}

    def answer(self, kind: str, content: dict[str, Any]) -> dict[str, Any]:
        """What the kernel says to a change of the state, or to a message."""
        self.sent.clear()
        if kind == "state":
            zoom(self.widget, content["_region"])
        else:
            self.widget._handle_custom_msg(content, [])
        return {"state": self.state(), "messages": list(self.sent)}


@pytest.mark.browser
@pytest.mark.parametrize(("width", "scheme"), [(1000, "light"), (375, "dark")])
def test_the_view_zooms_in_and_back(opens: Any, width: int, scheme: str, tmp_path: Path) -> None:
    notebook = Notebook(opens, MAP.widget(), tmp_path, width=width, height=760, scheme=scheme)
    frame, page = notebook.frame, notebook.page
    place = frame.locator(".map").bounding_box()
    page.mouse.move(place["x"] + 0.6 * place["width"], place["y"] + 0.4 * place["height"])
    page.mouse.wheel(0, -600)
    wanted = frame.evaluate("explorer.view")
    assert wanted[1] - wanted[0] == pytest.approx(8.0 * np.exp(-0.9))
    frame.wait_for_function("explorer.map.region")
    finer = notebook.widget.result
    assert finer is not MAP
    # The map of the view: as many pixels, between the borders of the view.
    assert finer.share.shape == MAP.share.shape
    assert frame.evaluate("explorer.map.region.view") == wanted
    np.testing.assert_allclose(frame.evaluate("explorer.view"), wanted, rtol=1e-13)
    spins = frame.evaluate("explorer.map.axes[0].values")
    assert tuple(spins) == finer.spec.axes[0].values
    # A layer stays chosen, and bodies are those of the finer map.
    frame.locator("select.layer").select_option("upper")
    frame.locator(".map").focus()
    page.keyboard.press("ArrowRight")
    frame.wait_for_selector("canvas.stage")
    assert frame.locator(".python").text_content() == "widget.result.replay(pixel=(2, 5), sample=0)"
    assert frame.locator(".chosen").text_content().startswith("spin = ")
    assert frame.locator(".dots button").count() == 64
    seen = finer.starts(0, pixel=(2, 5))
    assert frame.evaluate("explorer.bodies.start(0)[0]") == seen.omega.tolist()
    page.keyboard.press("n")
    following = frame.evaluate("explorer.order[explorer.order.indexOf(0) + 1]")
    line = f"widget.result.replay(pixel=(2, 5), sample={following})"
    assert frame.locator(".python").text_content() == line
    assert frame.evaluate("document.documentElement.scrollWidth") <= width
    # Out again, beyond the finer map.
    frame.locator(".map").focus()
    page.keyboard.press("-")
    out = frame.evaluate("explorer.view")
    assert out[1] - out[0] == pytest.approx((wanted[1] - wanted[0]) / 0.7)
    frame.wait_for_function("explorer.map.zoom === 2")
    np.testing.assert_allclose(frame.evaluate("explorer.view"), out, rtol=1e-13)
    frame.locator("button.whole").click()
    frame.wait_for_function("explorer.map.region === null")
    assert notebook.widget.result is MAP
    assert frame.evaluate("explorer.layer.name") == "upper"
    assert frame.evaluate("explorer.player.root.hidden")
    assert frame.locator(".chosen").text_content() == "Click a pixel to see its bodies."


@pytest.mark.browser
def test_the_view_says_why_there_is_no_finer_map(
    opens: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise ValueError("axes: too fine")

    monkeypatch.setattr("rigid.store.zooms.zoomed", fail)
    notebook = Notebook(opens, MAP.widget(), tmp_path)
    notebook.frame.evaluate("explorer.view = [2, 3, -6, -5]; explorer.kept()")
    notebook.frame.wait_for_selector(".said:not(:empty)")
    words = notebook.frame.locator(".said").text_content()
    assert words == "The finer map cannot be computed: axes: too fine"
    assert notebook.frame.evaluate("explorer.map.region") is None


@pytest.mark.browser
def test_a_moved_frame_shows_the_map_and_the_body_again(opens: Any, tmp_path: Path) -> None:
    notebook = Notebook(opens, MAP.widget(), tmp_path)
    notebook.frame.evaluate("explorer.view = [2, 6, -6, -3]; explorer.kept()")
    notebook.frame.wait_for_function("explorer.map.region")
    notebook.frame.evaluate("explorer.choose(9, 3)")
    notebook.frame.wait_for_selector("canvas.stage")
    notebook.page.evaluate("const moved = el.firstChild; moved.remove(); el.append(moved)")
    notebook.page.wait_for_function("el.firstChild.contentWindow.explorer?.player")
    (frame,) = notebook.page.frames[1:]
    assert frame.evaluate("[explorer.pixel, explorer.sample]") == [9, 3]
    assert frame.evaluate("explorer.map.region.view") == [2, 6, -6, -3]
    # The cell is deleted.
    notebook.page.evaluate("clean()")
    assert notebook.page.evaluate("Object.values(calls).flat().length") == 0


@pytest.mark.browser
def test_a_frame_moved_while_it_zooms_asks_for_the_finer_map(opens: Any, tmp_path: Path) -> None:
    notebook = Notebook(opens, MAP.widget(), tmp_path)
    notebook.frame.evaluate("explorer.view = [2, 6, -6, -3]; explorer.kept()")
    # The new page is slower than the pause after a zoom of the old one.
    notebook.page.evaluate("""() => {
      const moved = el.firstChild;
      moved.addEventListener("load", () => {
        for (const begun = performance.now(); performance.now() < begun + 700;);
      });
      moved.remove();
      el.append(moved);
    }""")
    notebook.page.wait_for_function("el.firstChild.contentWindow.explorer?.map?.region")
    (frame,) = notebook.page.frames[1:]
    assert frame.evaluate("explorer.map.region.view") == [2, 6, -6, -3]
