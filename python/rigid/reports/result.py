"""The result of a report: numbers, picture, file and text."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .._checks.shown import counted
from ..drawing.figure import html_with_picture
from .data import ReportData
from .plot import plot_report
from .table import report_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class Report(ReportData):
    """Error against run time of all methods for one scene; made by :func:`rigid.report`.

    Attributes
    ----------
    spec : ReportSpec
        The request.
    rows : tuple of Row
        Method by method, of each horizon from long steps to short ones. Each method differs from
        all others.
    same : dict of str to tuple of str
        The other names of a method, of methods that make the same steps on these bodies.
    references : tuple of Reference
        The solution over each horizon that errors are measured against, and its uncertainty.
    refused : dict of str to str
        Methods that are not applicable, and why.
    ended : dict of str to str
        Reason why a method was not run with shorter steps: its error reached the smallest
        requested error, the rounding error or the uncertainty of the reference, or the time limit
        was reached; over revolutions also that the step was the shortest.
    machine : dict of str to str
        Processor, instruction set, versions.
    complete : bool
        Whether the run came to its end; after Ctrl-C a report is partial.
    rounds : int
        Repeated timings of each row; over revolutions none is repeated.
    elapsed : float
        Seconds that the report took.
    """

    __slots__ = ()

    def plot(self, ax: Axes | None = None) -> Any:
        """Draw error against time of each method, and the Pareto front.

        Each method has a line in the colour of its family, and its name at the end. Over
        revolutions two columns show the errors of energy, momentum and, if it is known, phase: over
        the :attr:`horizon` against time per revolution, and against revolutions, of the step of
        each method that takes about the same time.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Axes to draw on; by default the axes of a new figure; a notebook and
            ``plt.show()`` show it. Over revolutions a grid of axes replaces these.

        Returns
        -------
        matplotlib Axes
            Over revolutions an ndarray of these, shape (2, 3), or (2, 2) without the phase.

        Raises
        ------
        ImportError
            Without matplotlib.

        Examples
        --------
        >>> import rigid
        >>> book = rigid.FreeBody(rigid.Body.box(0.25, 0.08, 0.01, mass=0.3))
        >>> result = rigid.report(
        ...     book, [0.1, 10.0, 0.1], t_end=0.5, methods=["exact", "rk4"], errors=[1e-3],
        ...     seconds=0.3,
        ... )
        >>> result.plot().get_yscale()
        'log'
        >>> result = rigid.report(book, [0.1, 10.0, 0.1], revolutions=[10, 100], methods=["rk4"])
        >>> result.plot().shape
        (2, 3)
        """
        return plot_report(self, ax)

    def __str__(self) -> str:
        return report_text(self)

    def __repr__(self) -> str:
        title = self.spec.title or self.spec.scene.words()
        partial = "" if self.complete else "; partial"
        over = f" over {self.horizon:g} revolutions" if self.spec.revolutions else ""
        by = counted(len(self.methods), "method")
        runs = f"{counted(len(self.rows), 'run')} by {by}{over}"
        return f"<Report: {title}; {runs}{partial}>"

    def _repr_html_(self) -> str:
        return html_with_picture(self.plot, str(self))
