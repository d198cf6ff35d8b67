"""Running maps on the command line: maps with a store, and the commands that work on stores."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from .._checks.arguments import resolve_threads
from .._checks.extras import install_extra
from .._checks.inputs import require_readable
from .._checks.progress import Interrupted, terminated
from .._files import MAP, require_ending
from ..maps.spec import MapSpec
from ..store.call import run_map
from ..store.result import StabilityMap
from .exit_codes import DONE, SAYS_NO, UNFINISHED
from .output import complain, require_new, say


def run(options: Namespace) -> int:
    """Run ``status``, ``merge``, ``diff``, ``verify`` or ``pack``; returns the exit code."""
    from ..store.store import diff, merge, open_store
    from ..store.verify import verify

    code = DONE
    for path in _inputs(options):
        require_readable(path)
    if options.command == "status":
        status = open_store(options.store).status()
        say(str(status))
        code = SAYS_NO if status.damage else DONE
    elif options.command == "merge":
        say(str(merge(options.stores, options.into).status()))
    elif options.command == "diff":
        difference = diff(options.one, options.other)
        say(str(difference))
        code = DONE if difference.same else SAYS_NO
    elif options.command == "verify":
        threads = resolve_threads(options.threads)
        found = verify(options.map, share=options.share, seed=options.seed, threads=threads)
        say(str(found))
        code = DONE if found.ok else SAYS_NO
    else:
        code = _pack(options)
    return code


def _inputs(options: Namespace) -> list[str]:
    """The files and folders that a command reads."""
    named = (getattr(options, name, None) for name in ("store", "map", "one", "other"))
    return [path for path in named if path is not None] + getattr(options, "stores", [])


def _pack(options: Namespace) -> int:
    """Write the map of a store, if the map is complete or a partial map is requested."""
    from ..store.store import open_store, pack

    if "://" not in options.out:
        target = Path(options.out)
        require_ending(options.out, MAP, "OUT")
        require_new(target, "OUT", force=options.force)
    result = open_store(options.store).result()
    if not result.ended:
        words = _stored(options.store, result)
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


def compute_stored(spec: MapSpec, options: Namespace, *, seeded: bool) -> StabilityMap | int:
    """The whole map of a specification in ``options.store``, or the exit code."""
    return _computed(
        options,
        lambda **how: run_map(spec, store=options.store, seeded=seeded, **how),
    )


def open_and_go_on(options: Namespace) -> StabilityMap | int:
    """The whole map of a folder, or the exit code."""
    from ..store.store import open_store

    require_readable(options.store)
    store = open_store(options.store)
    return _computed(options, store.resume)


def _computed(options: Namespace, compute: Any) -> StabilityMap | int:
    from ..store.store import PoisonedError

    part = "" if options.part is None else f" --part {options.part}"
    goes_on = f"rigid resume {options.store}{part} goes on"
    try:
        with _executor(options.dask) as executor:
            result: StabilityMap = compute(
                executor=executor,
                threads=resolve_threads(options.threads),
                threads_per_task=1,
                part=options.part,
                progress=options.progress,
                partial=False,
            )
    except Interrupted as stopped:
        if stopped.partial.ended:
            return stopped.partial  # type: ignore[no-any-return]
        how = "terminated" if terminated() else "interrupted"
        raise KeyboardInterrupt(f"{how}; {str(stopped).partition(';')[0]}; {goes_on}") from None
    except PoisonedError as error:
        complain(f"{error}; {goes_on}")
        return SAYS_NO
    except OSError as error:
        raise OSError(f"{error}; {_stored_in(options.store)}{goes_on}") from None
    if result.ended:
        if options.part is None or not result.computed or _claims(options.store):
            return result
        say(f"the map is complete, another part writes it; rigid resume {options.store} does too")
        return DONE
    complain(
        f"this part is done, others are missing; {_stored(options.store, result)}; "
        f"rigid resume {options.store} computes them all"
    )
    return UNFINISHED


def _claims(path: str) -> bool:
    from ..store.running import claims_result

    return claims_result(path)


def _stored(path: str, result: StabilityMap | None = None) -> str:
    """How much a folder holds; by default as it is now."""
    from ..store.resume import pixels_done, result_of
    from ..store.running import Folder

    folder = Folder(path)
    return pixels_done(folder, result_of(folder, StabilityMap) if result is None else result)


def _stored_in(path: str) -> str:
    """How much a folder holds, if it can be read."""
    try:
        return f"{_stored(path)}; "
    except (OSError, ValueError):
        return ""


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


def default_stem(store: str) -> str:
    """The name of the files of a running map, in the folder beside it."""
    return str(Path(store.rstrip("/")).with_suffix(""))
