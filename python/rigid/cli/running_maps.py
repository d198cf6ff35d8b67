"""Running maps on the command line: maps with a store, and the commands that work on stores."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from .._checks.arguments import resolve_threads
from .._checks.extras import install_extra
from .._checks.inputs import require_readable
from .._checks.progress import Interrupted, terminated
from .._checks.shown import wrapped
from .._files import MAP, require_ending
from ..store.result import StabilityMap
from .output import DONE, SAYS_NO, UNFINISHED, complain, require_new, say


def run(options: Namespace) -> int:
    """Run ``status``, ``merge``, ``diff``, ``verify`` or ``pack``; returns the exit code."""
    from ..store.compare import diff, verify
    from ..store.store import merge, open_store

    inputs = [getattr(options, name, None) for name in ("store", "map", "one", "other")]
    for path in filter(None, inputs + getattr(options, "stores", [])):
        require_readable(path)
    found: object
    if options.command == "status":
        found = status = open_store(options.store).status()
        agrees = not status.damage
    elif options.command == "merge":
        found, agrees = merge(options.stores, options.into).status(), True
    elif options.command == "diff":
        found = difference = diff(options.one, options.other)
        agrees = difference.same
    elif options.command == "verify":
        threads = resolve_threads(options.threads)
        found = again = verify(options.map, share=options.share, seed=options.seed, threads=threads)
        agrees = again.ok
    else:
        return _pack(options)
    say(wrapped(str(found)))
    return DONE if agrees else SAYS_NO


def _pack(options: Namespace) -> int:
    """Write the map of a store, if the map is complete or a partial map is requested."""
    from ..store.resume import pixels_done
    from ..store.running import Folder
    from ..store.store import open_store, pack

    if "://" not in options.out:
        target = Path(options.out)
        require_ending(options.out, MAP, "OUT")
        require_new(target, "OUT", force=options.force)
    result = open_store(options.store).result()
    if not result.ended:
        words = pixels_done(Folder(options.store))
        if not options.partial:
            complain(
                f"{words}, nothing is written; rigid resume {options.store} goes on, "
                "--partial writes what there is"
            )
            return UNFINISHED
        complain(f"{words}, the map written is partial")
    say(str(pack(result, options.out)))
    return DONE


def require_shared(options: Namespace, *, seeded: bool) -> None:
    """Raise ValueError if a part of a map, or a cluster, has no common folder or no common seed."""
    for name in ("part", "dask"):
        if getattr(options, name) is not None and options.store is None:
            raise ValueError(f"--{name}: needs --store")
    if options.part is not None:
        from ..store.resume import Part

        Part.of(options.part)
    if options.part is not None and not seeded:
        raise ValueError("--part: the file must tell the seed, or --seed: parts need the same one")


def computed(
    options: Namespace, compute: Callable[..., StabilityMap], **how: Any
) -> StabilityMap | int:
    """The whole map that ``compute`` returns, in the folder ``options.store``, or the exit code."""
    from ..store.resume import pixels_done
    from ..store.running import Folder, claims_result
    from ..store.store import PoisonedError

    part = "" if options.part is None else f" --part {options.part}"
    goes_on = f"rigid resume {options.store}{part} goes on"
    try:
        with _executor(options.dask) as executor:
            result = compute(
                executor=executor,
                threads=resolve_threads(options.threads),
                threads_per_task=1,
                part=options.part,
                progress=options.progress,
                partial=False,
                **how,
            )
    except Interrupted as stopped:
        if stopped.partial.ended:
            return stopped.partial  # type: ignore[no-any-return]
        word = "terminated" if terminated() else "interrupted"
        raise KeyboardInterrupt(f"{word}; {str(stopped).partition(';')[0]}; {goes_on}") from None
    except PoisonedError as error:
        complain(f"{error}; {goes_on}")
        return SAYS_NO
    except OSError as error:
        try:
            done = f"{pixels_done(Folder(options.store))}; "
        except (OSError, ValueError):
            done = ""
        raise OSError(f"{error}; {done}{goes_on}") from None
    if result.ended:
        if options.part is None or not result.computed or claims_result(options.store):
            return result
        words = "the map is complete, another part writes it; "
        say(wrapped(f"{words}rigid resume {options.store} does too", indent=2))
        return DONE
    complain(
        f"this part is done, others are missing; {pixels_done(Folder(options.store))}; "
        f"rigid resume {options.store} computes them all"
    )
    return UNFINISHED


@contextmanager
def _executor(address: str | None) -> Iterator[Any]:
    """A client of the Dask cluster at an address."""
    if address is None:
        yield None
        return
    try:
        from distributed import Client
    except ImportError:
        raise ValueError(install_extra("--dask needs Dask", "dask")) from None
    try:
        client = Client(address)  # type: ignore[no-untyped-call]
    except OSError as error:
        raise ValueError(f"--dask = {address!r}: no scheduler answers ({error})") from None
    with client:
        yield client
