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
    by: Callable[..., object] | None = None,
) -> Callable[..., None]:
    """A test that each call raises an error with these words.

    Parameters
    ----------
    rows : iterable of tuple
        The call, or what `by` is given, one or more; the kind of the error if it is not that of
        all rows; and the words: a regular expression, or a list of texts that are all in the
        message.
    literal : bool
        Whether words are texts too.
    kind : type or tuple of type
        The kind of the errors of rows that name none.
    by : callable, optional
        Makes the call of each row with what stands first in it.
    """
    table = []
    for *given, words in rows:
        own = given.pop() if _is_kind(given[-1]) else kind
        table.append((given, own, words))
    firsts = (words if isinstance(words, str) else words[0] for *_, words in table)
    ids = [f"{number}: {first}" for number, first in enumerate(firsts)]

    @pytest.mark.parametrize(("given", "error", "words"), table, ids=ids)
    def test(given: list[Any], error: type[Exception], words: str | list[str]) -> None:
        with pytest.raises(error) as caught:
            given[0]() if by is None else by(*given)
        message = str(caught.value)
        assert "\n" not in message
        if isinstance(words, str) and not literal:
            assert re.search(words, message), message
        else:
            for part in [words] if isinstance(words, str) else words:
                assert part in message

    made: Callable[..., None] = test
    return made


def _is_kind(given: object) -> bool:
    """Whether this is an exception, or some of them."""
    kinds = given if isinstance(given, tuple) and given else (given,)
    return all(isinstance(one, type) and issubclass(one, Exception) for one in kinds)
