"""The result of a report: its numbers, its picture, its file and its text."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from .._files import published
from ..drawing.figure import html_with_picture
from .data import ReportData
from .plot import plot_report
from .table import report_text

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.axes import Axes

__all__ = ["Report"]


class Report(ReportData):
    """Error against run time of all methods for one scene; made by :func:`rigid.report`.

    Attributes
    ----------
    spec : ReportSpec
        The request.
    rows : tuple of Row
        Method by method, from long steps to short ones. Each method differs from all others.
    same : dict of str to tuple of str
        The other names of a method, of schemes that make the same steps on these bodies.
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
        """Draw error against time, a line for each method, and the Pareto front.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Axes to draw on; by default those of a new figure; a notebook and
            ``plt.show()`` show it.

        Raises
        ------
        ImportError
            Without matplotlib.
        """
        return plot_report(self, ax=ax)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the JSON text to a file and return its path.

        The file appears whole or not at all; see :meth:`rigid.StabilityMap.save`.

        Raises
        ------
        OSError
            If the file cannot be written, or its name is that of something else than a file.
        """
        from pathlib import Path

        text = self.to_json() + "\n"
        with published(path) as file:
            file.write(text.encode())
        return Path(path)

    def __str__(self) -> str:
        return report_text(self)

    def __repr__(self) -> str:
        title = self.spec.title or self.spec.scene.words()
        partial = "" if self.complete else "; partial"
        return f"<Report: {title}; {len(self.rows)} runs by {len(self.methods)} methods{partial}>"

    def _repr_html_(self) -> str:
        return html_with_picture(self.plot, str(self))
