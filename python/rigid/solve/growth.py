"""Growth of small deviation vectors of motions, and what it says of chaos."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model.criteria import Regular
from ..model.scene import scene_from_dict
from .plan import Plan
from .status import Status, sentences

__all__ = ["Growth"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Growth:
    """The result of :func:`lyapunov`. With a single body the leading axis ``n`` is absent.

    Attributes
    ----------
    t : ndarray, shape (m,)
        Times (s).
    log_growth : ndarray, shape (n, m)
        ``Λ(t) = ln |v(t)| / |v(0)|`` of the first deviation vector.
    megno : ndarray, shape (n, m)
        ``2 (Λ - mean of Λ)``: near 2 on regular motions, ``lambda t`` on chaotic ones.
    mean_megno : ndarray, shape (n, m)
        Its mean over the time: tends to 2 on regular motions, grows like ``lambda t / 2`` on
        chaotic ones.
    fli : ndarray, shape (n, m)
        Fast Lyapunov indicator: the largest ``Λ`` until then.
    spectrum : ndarray, shape (n, m, k)
        The ``k`` largest exponents (1/s) over the time, in descending order as they are found.
    zeros : ndarray of int, shape (n,)
        How many of all exponents are zero by theory, whatever the horizon: by symmetries and
        conserved quantities. Six of a free body off the separatrix, four of a top.
    sali : ndarray, shape (n, m), or None
        Smaller alignment index of the first two deviation vectors; None with one exponent.
    gali : ndarray, shape (n, m, k - 1), or None
        Generalised alignment indices ``GALI_2`` to ``GALI_k``; None with one exponent.
    error : ndarray, shape (n,)
        Estimated error of ``log_growth``, the largest at these times: three times the difference
        from a run with a method of another order in other steps, and rounding. NaN without that
        run.
    lost_from : ndarray, shape (n,)
        Time from which on the motion itself is lost to rounding or truncation: exponents from there
        on are those of a numerical motion. Infinite if there is none, NaN where it is not known.
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

        None if not all exponents were asked for, or under torque and damping.
        """
        complete = 6 if self.spec["of"] == "attitude" else 5
        if self.spectrum.shape[-1] != complete or scene_from_dict(self.spec["scene"]).forces:
            return None
        paired: Floats = np.abs(self.spectrum + self.spectrum[..., ::-1])
        return paired

    def reasons(self) -> tuple[Any, ...]:
        """The verdict on each body, and what it means, in a sentence each.

        With several leading axes the sentences are tuples of tuples.

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
