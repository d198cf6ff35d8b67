"""Draw ``running-maps.png``, a stored map that was stopped twice and went on.

``python docs/images/running_maps.py``
"""

import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import rigid

SIDES, NOISE = np.linspace(0.012, 0.248, 80), np.geomspace(1e-3, 1.0, 60)


def stop_at(share: float) -> Callable[[rigid.Progress], None]:
    """A progress callback that ends the call, as Ctrl-C does, once a share is done."""

    def show(progress: rigid.Progress) -> None:
        if progress.done >= share * progress.total:
            raise KeyboardInterrupt

    return show


def go_on(store: Path, share: float) -> rigid.StabilityMap:
    """The map after this share of its bodies."""
    return rigid.stability_map(
        rigid.Body.box(0.25, 0.08, 0.01, mass=0.3),
        axes={"b": SIDES, "noise": NOISE},
        samples=256,
        t_end=1.0,
        stable=rigid.no_flip(),
        start=rigid.Start(spin=10.0, axis=2, noise=rigid.normal(1e-3)),
        method="rk4",
        rng=2026,
        threads=1,
        store=store,
        progress=stop_at(share),
        partial=True,
    )


with tempfile.TemporaryDirectory() as folder:
    states = [go_on(Path(folder) / "run.rigid", share) for share in (0.06, 0.25, 2.0)]

figure = Figure(figsize=(8.0, 2.9), layout="constrained")
panels = figure.subplots(1, 3, sharey=True)
for ax, state in zip(panels, states, strict=True):
    shown = ax.pcolormesh(
        1e3 * SIDES, NOISE, state.share, vmin=0.0, vmax=1.0, cmap="cividis", shading="nearest"
    )
    ax.set(yscale="log", facecolor="#eeeeee", xlabel="side b (mm)")
    ax.set_title(f"{np.mean(~np.isnan(state.share)):.0%} of the pixels", fontsize=10)
panels[0].set_ylabel("disturbance (rad/s)")
figure.colorbar(shown, ax=panels, label="share without a flip", pad=0.01)
figure.savefig(Path(__file__).with_name("running-maps.png"), dpi=160)
