"""Growth of small deviation vectors along motions, and the verdict regular or chaotic."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._checks.arguments import one_of, one_time
from ..drawing.classes import name_classes
from ..drawing.colours import CLASSES, on_ground
from ..drawing.figure import axes_to_draw_on, html_with_picture
from ..model.criteria import Regular
from ..model.scene import scene_from_dict
from .archive import write_arrays
from .dataset import as_dataset
from .plan import Plan
from .status import Status, sentences
from .tidy import body_columns, write_table

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes

__all__ = ["Growth"]

Floats = NDArray[np.float64]

ARRAYS: Mapping[str, tuple[str, tuple[str, ...]]] = {
    "log_growth": ("1", ("t",)),
    "megno": ("1", ("t",)),
    "mean_megno": ("1", ("t",)),
    "fli": ("1", ("t",)),
    "spectrum": ("1/s", ("t", "exponent")),
    "sali": ("1", ("t",)),
    "gali": ("1", ("t", "order")),
    "zeros": ("1", ()),
    "error": ("1", ()),
    "lost_from": ("s", ()),
    "verdict": ("", ()),
    "energy_drift": ("1", ()),
    "status": ("", ()),
    "steps": ("1", ()),
}
"""Unit and axes, after the axes of the bodies, of each array."""

LABELS: Mapping[str, str] = {
    "exponent": "exponent (1/s)",
    "log_growth": "ln of the growth",
    "megno": "MEGNO",
    "mean_megno": "mean MEGNO",
    "fli": "FLI",
    "sali": "SALI",
}


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Growth:
    """Exponents and chaos indicators of motions over time, from :func:`lyapunov`.

    With a single body the leading axis ``n`` is absent.

    Attributes
    ----------
    t : ndarray, shape (m,)
        Times (s).
    log_growth : ndarray, shape (n, m)
        ``Λ(t) = ln |v(t)| / |v(0)|`` of the first deviation vector.
    megno : ndarray, shape (n, m)
        ``2 (Λ - mean of Λ)``: near 2 on regular motions, ``lambda t`` on chaotic ones.
    mean_megno : ndarray, shape (n, m)
        Mean of MEGNO over the time: tends to 2 on regular motions, grows like ``lambda t / 2`` on
        chaotic ones.
    fli : ndarray, shape (n, m)
        Fast Lyapunov indicator: the largest ``Λ`` until then.
    spectrum : ndarray, shape (n, m, k)
        The ``k`` largest exponents (1/s) over the time, in descending order as they are found.
    zeros : ndarray of int, shape (n,)
        Number of exponents that are zero by theory, whatever the horizon, by symmetries and
        conserved quantities: six of a free body off the separatrix, four of a top.
    sali : ndarray, shape (n, m), or None
        Smaller alignment index of the first two deviation vectors; None with one exponent.
    gali : ndarray, shape (n, m, k - 1), or None
        Generalised alignment indices ``GALI_2`` to ``GALI_k``; None with one exponent.
    error : ndarray, shape (n,)
        Estimated error of ``log_growth``, the largest at these times: three times the difference
        from a run with a method of another order in other steps, and rounding. NaN without that
        run.
    lost_from : ndarray, shape (n,)
        Time from which on the motion itself is lost to rounding or truncation: later exponents
        belong to a numerical motion. Infinite if there is none, NaN where it is not known.
    verdict : ndarray of str, shape (n,)
        At the last time: ``"regular"``, ``"chaotic"``, ``"undecided"``, or ``"failed"`` for a body
        that was not run to its end. A free body or a Lagrange top without torque and damping is
        never chaotic: beside a separatrix it is undecided while its deviation vectors grow.
    energy_drift : ndarray, shape (n,)
        Largest error of the energy, as in :class:`Run`.
    status : ndarray of uint8, shape (n,)
        A :class:`Status` for each body.
    steps : ndarray of uint64, shape (n,)
        Steps taken.
    plan : Plan
        The method and the reasons.
    spec : dict
        Scene, method, step, norm and number of exponents, as a dict.
    """

    t: Floats
    log_growth: Floats
    megno: Floats
    mean_megno: Floats
    fli: Floats
    spectrum: Floats
    zeros: NDArray[np.intp]
    sali: Floats | None
    gali: Floats | None
    error: Floats
    lost_from: Floats
    verdict: NDArray[np.str_]
    energy_drift: Floats
    status: NDArray[np.uint8]
    steps: NDArray[np.uint64]
    plan: Plan
    spec: dict[str, Any]

    def __repr__(self) -> str:
        verdicts = np.ravel(self.verdict).tolist()
        counts = ", ".join(f"{verdicts.count(one)} {one}" for one in sorted(set(verdicts)))
        each = "one body" if np.ndim(self.verdict) == 0 else f"{len(verdicts)} bodies"
        return f"<Growth: {each} at {len(self.t)} times; {counts or 'none'}>"

    def _repr_html_(self) -> str:
        return html_with_picture(lambda ax: self.plot(ax=ax), repr(self))

    @property
    def exponent(self) -> Floats:
        """``log_growth / t`` (1/s), shape (n, m)."""
        exponent: Floats = self.log_growth / self.t
        return exponent

    @property
    def resolution(self) -> float:
        """The smallest exponent (1/s) that this horizon can show: ``10 / t[-1]``."""
        return Regular().resolution(float(self.t[-1]))

    @property
    def pairing(self) -> Floats | None:
        """``|lambda_i + lambda_(k+1-i)|`` (1/s), which tends to zero, shape (n, m, k).

        None if not all exponents were requested, or under torque and damping.
        """
        complete = 6 if self.spec["of"] == "attitude" else 5
        if self.spectrum.shape[-1] != complete or scene_from_dict(self.spec["scene"]).forces:
            return None
        paired: Floats = np.abs(self.spectrum + self.spectrum[..., ::-1])
        return paired

    def reasons(self) -> tuple[Any, ...]:
        """A sentence for each body: the verdict and its meaning.

        With several leading axes the sentences are tuples of tuples.

        Returns
        -------
        tuple of str

        Examples
        --------
        >>> import rigid
        >>> box = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
        >>> for words in rigid.lyapunov(box, [[1.0, 0.1, 0.1]], t=[200.0]).reasons():
        ...     print(words)
        regular: no growth like exp(k t) with k above 0.05 1/s until t = 200 s; the mean MEGNO is \
1.83
        """
        columns = [self.verdict, self.status, self.mean_megno[..., -1], self.exponent[..., -1]]
        return sentences(self._words, *columns, self.lost_from)

    def _words(self, verdict: str, status: int, mean: float, exponent: float, lost: float) -> str:
        until = f"until t = {self.t[-1]:g} s; the mean MEGNO is {mean:.3g}"
        if verdict == "failed":
            return f"failed: {Status(status).name.lower().replace('_', ' ')}; take shorter steps"
        if verdict == "regular":
            return (
                f"regular: no growth like exp(k t) with k above {self.resolution:.3g} 1/s {until}"
            )
        if verdict == "undecided":
            return f"undecided {until}; take a longer time"
        words = f"chaotic: exponent {exponent:.3g} 1/s {until} and grows"
        if np.isfinite(lost):
            words += f"; the motion itself is lost from t = {lost:.4g} s on"
        return words

    def plot(self, what: str = "exponent", *, ax: Axes | None = None) -> Axes:
        """Draw an indicator over the time, a line for each body in the colour of its verdict.

        Parameters
        ----------
        what : {"exponent", "log_growth", "megno", "mean_megno", "fli", "sali"}
            The indicator; exponent and SALI on logarithmic axes.
        ax : matplotlib Axes, optional
            By default the axes of a new figure.

        Returns
        -------
        matplotlib Axes

        Raises
        ------
        ImportError
            Without matplotlib.
        ValueError
            If the indicator is unknown, SALI was not computed, or there is a single time.

        Examples
        --------
        >>> import numpy as np, rigid
        >>> box = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
        >>> growth = rigid.lyapunov(box, [1.0, 0.1, 0.1], t=np.linspace(10.0, 200.0, 20))
        >>> growth.plot("mean_megno").get_ylabel()
        'mean MEGNO'
        """
        values = getattr(self, one_of("what", what, LABELS))
        if values is None:
            raise ValueError("what = 'sali': needs two exponents; call lyapunov(..., exponents=2)")
        if len(self.t) < 2:
            raise one_time("a plot", self.t)
        ax = axes_to_draw_on(ax)
        lines = np.reshape(values, (-1, len(self.t)))
        verdicts = np.ravel(self.verdict).tolist()
        inks = {word: on_ground(ax, ink) for word, ink in CLASSES.items() if word in verdicts}
        # Of many bodies each line is faint, so that a crowd shows its density.
        alpha = max(0.1, max(len(lines) - 1, 1) ** -0.5)
        for line, word in zip(lines, verdicts, strict=True):
            ax.plot(self.t, line, color=inks[word], alpha=alpha, linewidth=1.0)
        name_classes(ax, inks)
        if what in ("exponent", "sali"):
            ax.set(xscale="log", yscale="log")
        ax.set(xlabel="t (s)", ylabel=LABELS[what])
        return ax

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Save the arrays as an ``.npz`` file, which :func:`numpy.load` reads.

        Its arrays are the attributes by name; ``spec`` and ``plan`` are JSON texts. The file
        appears whole or not at all; see :meth:`rigid.StabilityMap.save`.

        Parameters
        ----------
        path : path-like

        Returns
        -------
        Path
            The path.

        Raises
        ------
        ValueError
            If the name does not end in ``.npz``.
        OSError
            Naming the path, if the file cannot be written.

        Examples
        --------
        >>> import os, tempfile, numpy as np, rigid
        >>> box = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
        >>> growth = rigid.lyapunov(box, [1.0, 0.1, 0.1], t=[100.0, 200.0])
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     with np.load(growth.save(os.path.join(folder, "growth.npz"))) as file:
        ...         str(file["verdict"])
        'regular'
        """
        texts = {"spec": json.dumps(self.spec), "plan": self.plan.to_json()}
        words = {name: np.array(text) for name, text in texts.items()}
        return write_arrays(path, {"t": self.t, **words, **self._arrays()})

    def to_xarray(self) -> xarray.Dataset:
        """The indicators as an xarray ``Dataset`` with names, units, and times as a coordinate.

        Returns
        -------
        xarray.Dataset

        Raises
        ------
        ImportError
            Without xarray.

        Examples
        --------
        >>> import rigid
        >>> box = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
        >>> growth = rigid.lyapunov(box, [[1.0, 0.1, 0.1]] * 2, t=[100.0, 200.0])
        >>> dict(growth.to_xarray().log_growth.sizes)
        {'body': 2, 't': 2}
        """
        bodies = tuple(f"body{k or ''}" for k in range(np.ndim(self.status)))
        arrays = {
            name: ((*bodies, *ARRAYS[name][1]), array, {"units": ARRAYS[name][0]})
            for name, array in self._arrays().items()
        }
        coordinates: dict[str, Any] = {"t": ("t", self.t, {"units": "s"})}
        if self.gali is not None:
            coordinates["order"] = np.arange(2, 2 + self.gali.shape[-1])
        attributes = {"spec": json.dumps(self.spec), "plan": self.plan.to_json()}
        return as_dataset(arrays, coordinates, attributes)

    def to_csv(self, path: str | os.PathLike[str]) -> Path:
        """Write a tidy table: a row for each body and time, a column for each indicator.

        Parameters
        ----------
        path : path-like

        Returns
        -------
        Path
            The path.

        Raises
        ------
        ValueError
            If the name does not end in ``.csv`` or ``.txt``.
        OSError
            Naming the path, if the file cannot be written.

        Examples
        --------
        >>> import os, tempfile, rigid
        >>> box = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
        >>> growth = rigid.lyapunov(box, [1.0, 0.1, 0.1], t=[100.0, 200.0])
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = growth.to_csv(os.path.join(folder, "growth.csv"))
        ...     print(path.read_text().splitlines()[0].split(",")[:3])
        ['t', 'log_growth', 'megno']
        """
        columns = {**body_columns(np.shape(self.status), 1), "t": self.t}
        for name, array in self._arrays().items():
            if ARRAYS[name][1] == ("t",):
                columns[name] = array
            elif ARRAYS[name][1] != ():
                first = 1 if name == "spectrum" else 2
                word = "exponent" if name == "spectrum" else name
                columns |= {f"{word}{first + k}": array[..., k] for k in range(array.shape[-1])}
        return write_table(path, {**columns, "verdict": np.asarray(self.verdict)[..., np.newaxis]})

    def _arrays(self) -> dict[str, NDArray[Any]]:
        """The arrays that there are, without the times."""
        known = {name: getattr(self, name) for name in ARRAYS}
        return {name: np.asarray(array) for name, array in known.items() if array is not None}
