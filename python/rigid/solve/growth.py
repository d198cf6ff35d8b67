"""Growth of small deviation vectors along motions, and the verdict regular or chaotic."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .._checks.arguments import one_of, one_time, positive_int
from .._checks.arrays import Floats
from .._checks.shown import counted
from ..drawing.colours import CLASSES, on_ground
from ..drawing.figure import axes_to_draw_on, html_with_picture, name_classes
from ..model.batch import Shape
from ..model.criteria import Regular
from .columns import Column, Columns, Result
from .plan import Plan
from .status import Status, sentences

if TYPE_CHECKING:
    from matplotlib.axes import Axes


LABELS: Mapping[str, str] = {
    "exponent": "exponent (1/s)",
    "log_growth": "ln of the growth",
    "megno": "MEGNO",
    "mean_megno": "mean MEGNO",
    "fli": "FLI",
    "sali": "SALI",
}


class LyapunovTime(NamedTuple):
    """A Lyapunov time with its spread, from :meth:`Growth.lyapunov_time`.

    Attributes
    ----------
    time : ndarray, shape (n,)
        Time in which a deviation grows by the factor e (s).
    error : ndarray, shape (n,)
        Standard error, from the scatter of parts of the run (s).
    """

    time: Floats
    error: Floats


@dataclass(frozen=True, repr=False, eq=False)
class Growth(Result):
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
        Estimated error of ``log_growth``, the largest at these times, of a motion that is not
        regular at those before ``lost_from``: three times the difference from a run with a method
        of another order in other steps, and rounding. NaN without that run, and without such a
        time. It is no error of a Lyapunov exponent, whose spread :meth:`lyapunov_time` states.
    lost_from : ndarray, shape (n,)
        Time from which on the motion itself is lost to rounding or truncation: later exponents
        belong to a numerical motion, whose growth differs from run to run. Infinite if there is
        none, NaN where it is not known.
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

    Notes
    -----
    A table of :meth:`to_csv` has the indicators at each time, and the verdict.
    """

    _columns: Columns
    _shape: Shape
    plan: Plan
    spec: dict[str, Any]

    t = Column[Floats]("s", "t")
    log_growth = Column[Floats]("1", "body", "t")
    megno = Column[Floats]("1", "body", "t")
    mean_megno = Column[Floats]("1", "body", "t")
    fli = Column[Floats]("1", "body", "t")
    spectrum = Column[Floats]("1/s", "body", "t", "exponent")
    sali = Column[Floats | None]("1", "body", "t")
    gali = Column[Floats | None]("1", "body", "t", "order")
    zeros = Column[NDArray[np.intp]]("1", "body")
    error = Column[Floats]("1", "body")
    lost_from = Column[Floats]("s", "body")
    verdict = Column[NDArray[np.str_]]("", "body")
    energy_drift = Column[Floats]("1", "body")
    status = Column[NDArray[np.uint8]]("", "body")
    steps = Column[NDArray[np.uint64]]("1", "body")

    def __repr__(self) -> str:
        verdicts = np.ravel(self.verdict).tolist()
        counts = ", ".join(f"{verdicts.count(one)} {one}" for one in sorted(set(verdicts)))
        one = np.ndim(self.verdict) == 0
        each = "one body" if one else counted(len(verdicts), "body", "bodies")
        return f"<Growth: {each} at {counted(len(self.t), 'time')}; {counts or 'none'}>"

    def _repr_html_(self) -> str:
        return html_with_picture(lambda ax: self.plot(ax=ax), repr(self))

    @property
    def exponent(self) -> Floats:
        """``log_growth / t`` (1/s), shape (n, m)."""
        return self.log_growth / self.t

    @property
    def resolution(self) -> float:
        """The smallest exponent (1/s) that this horizon can show: ``10 / t[-1]``."""
        return Regular().resolution(float(self.t[-1]))

    def lyapunov_time(self, parts: int = 8) -> LyapunovTime:
        """The time in which a deviation grows by the factor e, and how well the run tells it.

        It is one over the exponent at the last time. Its error follows from the exponents of parts
        of the run of about equal length, which scatter: the standard error of their mean. This
        holds for numerical motions too, which are lost: they are motions of the same chaotic zone.

        Parameters
        ----------
        parts : int
            Number of parts, at least 4. They end at times of the run.

        Returns
        -------
        LyapunovTime
            ``time``, shape (n,), of the motions whose verdict is chaotic; infinite of the regular
            ones, NaN of all others. ``error``, shape (n,), one standard deviation; NaN of all but
            the chaotic ones. Both in s.

        Raises
        ------
        ValueError
            If there are fewer than 4 parts, or the run has too few times for them.

        Notes
        -----
        Parts that are shorter than some Lyapunov times depend on each other; the error is then too
        small. The first part has the time in which the deviation vector turns to the direction of
        the fastest growth. Of an ensemble in one chaotic zone, ``growth.exponent[:, -1]`` of many
        bodies shows the scatter directly.

        Examples
        --------
        >>> import numpy as np, rigid
        >>> top = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
        >>> times = np.linspace(100.0, 1600.0, 16)
        >>> growth = rigid.lyapunov(top, [0.3, 0.4, 1.0], [0.9, 0.3, 0.2, 0.1], t=times)
        >>> found = growth.lyapunov_time()
        >>> bool(3.0 < found.time < 4.5), bool(found.error < 0.5)
        (True, True)
        """
        count = positive_int("parts", parts, minimum=4)
        times = np.concatenate([[0.0], self.t])
        ends = np.linspace(0.0, times[-1], count + 1)
        places = np.abs(times - ends[:, np.newaxis]).argmin(axis=1)
        if len(np.unique(places)) <= count:
            raise ValueError(
                f"parts = {count}: the run has {len(self.t)} times; ask rigid.lyapunov for a time "
                "at the end of each part"
            )
        log = np.concatenate([np.zeros((*self.log_growth.shape[:-1], 1)), self.log_growth], axis=-1)
        spans = np.diff(times[places])
        exponent = self.log_growth[..., -1] / times[-1]
        of_parts = np.diff(log[..., places], axis=-1) - exponent[..., np.newaxis] * spans
        # Of equal parts this is the standard deviation over the root of their number.
        error = np.sqrt(count / (count - 1.0) * np.sum(of_parts**2, axis=-1)) / times[-1]
        chaotic = self.verdict == "chaotic"
        with np.errstate(divide="ignore", invalid="ignore"):
            time = np.where(chaotic, 1.0 / exponent, np.nan)
            spread = np.where(chaotic, error / exponent**2, np.nan)
        return LyapunovTime(np.where(self.verdict == "regular", np.inf, time)[()], spread[()])

    @property
    def pairing(self) -> Floats | None:
        """``|lambda_i + lambda_(k+1-i)|`` (1/s), which tends to zero, shape (n, m, k).

        None if not all exponents were requested, or under torque and damping.
        """
        complete = 6 if self.spec["of"] == "attitude" else 5
        if self.spectrum.shape[-1] != complete or self._scene.forces:
            return None
        return np.abs(self.spectrum + self.spectrum[..., ::-1])

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

    def _labels(self) -> Mapping[str, Any]:
        return {} if self.gali is None else {"order": np.arange(2, 2 + self.gali.shape[-1])}

    def _table(self) -> dict[str, NDArray[Any]]:
        return {**super()._table(), "verdict": np.asarray(self.verdict)[..., np.newaxis]}
