"""The results of a report and of a long run: numbers, picture, file and text."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from ..drawing.figure import html_with_picture
from .data import ReportData
from .long_data import LongRunData
from .long_plot import plot_long_run
from .long_table import long_text
from .plot import plot_report
from .table import report_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["LongRun", "Report"]


class Report(ReportData):
    """Error against run time of all methods for one scene; made by :func:`rigid.report`.

    Attributes
    ----------
    spec : ReportSpec
        The request.
    rows : tuple of Row
        Method by method, from long steps to short ones. Each method differs from all others.
    same : dict of str to tuple of str
        The other names of a method, of methods that make the same steps on these bodies.
    reference : Reference
        The solution that errors are measured against, and its uncertainty.
    refused : dict of str to str
        Methods that are not applicable, and why.
    ended : dict of str to str
        Reason why a method was not run with shorter steps: its error reached the smallest
        requested error, the rounding error or the uncertainty of the reference, or the time limit
        was reached.
    machine : dict of str to str
        Processor, instruction set, versions.
    complete : bool
        Whether the run came to its end; after Ctrl-C a report is partial.
    rounds : int
        Timings of each row.
    elapsed : float
        Seconds that the report took.
    """

    __slots__ = ()

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw error against time, the best of each family of methods, and the Pareto front.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Axes to draw on; by default the axes of a new figure; a notebook and
            ``plt.show()`` show it.

        Returns
        -------
        matplotlib Axes

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
        """
        return plot_report(self, ax=ax)

    def __str__(self) -> str:
        return report_text(self)

    def __repr__(self) -> str:
        title = self.spec.title or self.spec.scene.words()
        partial = "" if self.complete else "; partial"
        return f"<Report: {title}; {len(self.rows)} runs by {len(self.methods)} methods{partial}>"

    def _repr_html_(self) -> str:
        return html_with_picture(self.plot, str(self))


class LongRun(LongRunData):
    """Errors of energy, momentum and phase over ever more revolutions; by :func:`rigid.long_run`.

    Attributes
    ----------
    spec : ReportSpec
        The scene and its start, with the longest horizon.
    revolutions : tuple of float
        Lengths of the runs.
    rows : tuple of LongRow
        Method by method, from long steps to short ones.
    same : dict of str to tuple of str
        The other names of a method, of methods that make the same steps on these bodies.
    references : tuple of Reference
        The reference of the phase, over each number of revolutions as far as it is known.
    refused : dict of str to str
        Methods that are not applicable, and why.
    machine : dict of str to str
        Processor, instruction set, versions.
    complete : bool
        Whether the run came to its end; after Ctrl-C it is partial.
    elapsed : float
        Seconds that it took.
    """

    __slots__ = ()

    def plot(self) -> NDArray[Any]:
        """Draw the errors against time, and their growth with the revolutions.

        Returns
        -------
        ndarray of matplotlib Axes, shape (2, 3)
            Columns: energy, momentum, phase. Upper row: error over the most revolutions against
            time per revolution; lower row: error against revolutions, of the step of each method
            that takes about the same time.

        Raises
        ------
        ImportError
            Without matplotlib.

        Examples
        --------
        >>> import rigid
        >>> result = rigid.long_run(
        ...     rigid.Body((1.0, 1.5, 2.0)), [1.0, 0.2, 0.3], revolutions=[10, 100], methods=["rk4"]
        ... )
        >>> result.plot().shape
        (2, 3)
        """
        return plot_long_run(self)

    def __str__(self) -> str:
        return long_text(self)

    def __repr__(self) -> str:
        title = self.spec.title or self.spec.scene.words()
        partial = "" if self.complete else "; partial"
        most = self.revolutions[self.horizon]
        return f"<LongRun: {title}; {most:g} revolutions by {len(self.methods)} methods{partial}>"

    def _repr_html_(self) -> str:
        def draw(ax: Axes) -> None:
            figure = ax.get_figure(root=True)
            ax.remove()
            plot_long_run(self, figure)

        return html_with_picture(draw, str(self))
