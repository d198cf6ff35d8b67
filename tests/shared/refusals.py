"""Refusals as tables: a call, and the words of its message."""

import re
from collections.abc import Callable, Iterable
from typing import Any

import pytest


def refuses(
    rows: Iterable[tuple[Any, ...]],
    *,
    literal: bool = False,
    kind: type[Exception] | tuple[type[Exception], ...] = ValueError,
    by: Callable[[Any], object] | None = None,
) -> Callable[..., None]:
    """A test that each call raises an error with these words.

    Parameters
    ----------
    rows : iterable of tuple
        The call, or what `by` is given, the kind of the error if it is not that of all rows, and
        the words: a regular expression, or a list of texts that are all in the message.
    literal : bool
        Whether words are texts too.
    kind : type or tuple of type
        The kind of the errors of rows that name none.
    by : callable, optional
        Makes the call of each row with what stands first in it.
    """
    table = [(row[0], row[1] if len(row) > 2 else kind, row[-1]) for row in rows]
    firsts = (words if isinstance(words, str) else words[0] for *_, words in table)
    ids = [f"{number}: {first}" for number, first in enumerate(firsts)]

    @pytest.mark.parametrize(("call", "error", "words"), table, ids=ids)
    def test(call: Any, error: type[Exception], words: str | list[str]) -> None:
        with pytest.raises(error) as caught:
            call() if by is None else by(call)
        message = str(caught.value)
        assert "\n" not in message
        if isinstance(words, str) and not literal:
            assert re.search(words, message), message
        else:
            for part in [words] if isinstance(words, str) else words:
                assert part in message

    made: Callable[..., None] = test
    return made
