"""Running maps on the command line: maps with a store, and the commands that work on stores."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from .._checks.arguments import resolve_threads
from .._checks.extras import install_extra
from .._checks.inputs import require_readable
from .._checks.progress import Interrupted, terminated
from .._files import MAP, require_ending
from ..maps.result import StabilityMap
from ..maps.spec import MapSpec
from ..store.call import run_map
from .exit_codes import DONE, SAYS_NO, UNFINISHED
from .output import complain, require_new, say

__all__ = [
    "QUIET",
    "THREADS",
    "add_commands",
    "add_options",
    "compute_stored",
    "default_stem",
    "open_and_go_on",
    "require_shared",
    "run",
]


_FOLDER = "folder of a running map"
QUIET = "neither a progress bar in a terminal nor a line every 10 s elsewhere"
THREADS = "number of threads (default: all that this process may use)"


def _command(commands: Any, name: str, words: str) -> ArgumentParser:
    """A command with the same words in the list of commands and in its help."""
    parser: ArgumentParser = commands.add_parser(
        name, help=words, description=f"{words[0].upper()}{words[1:]}."
    )
    return parser


def add_options(parser: ArgumentParser, needs: str = "; needs --store") -> None:
    """The options of a map that is stored."""
    parser.add_argument("--part", metavar="K/N", help=f"compute only part K of N{needs}")
    parser.add_argument("--dask", metavar="ADDRESS", help=f"compute on this Dask cluster{needs}")


def add_commands(commands: Any) -> None:
    """The commands that work on stores."""
    resume = _command(commands, "resume", "go on with a running map")
    resume.add_argument("store", metavar="DIR", help=_FOLDER)
    resume.add_argument("--threads", type=int, metavar="N", help=THREADS)
    resume.add_argument(
        "--out",
        metavar="PATH",
        help="writes PATH.png and PATH.npz (default: DIR without its suffix)",
    )
    resume.add_argument("--force", action="store_true", help="replace existing files")
    resume.add_argument("--json", action="store_true", help="print JSON for other programs")
    resume.add_argument(
        "--no-progress", dest="progress", action="store_const", const=False, help=QUIET
    )
    add_options(resume, "")
    status = _command(commands, "status", "tell what a running map has and lacks")
    status.add_argument("store", metavar="DIR", help=_FOLDER)
    merge = _command(commands, "merge", "merge running maps of one specification")
    merge.add_argument("stores", metavar="DIR", nargs="+", help="folders of running maps")
    merge.add_argument("--into", required=True, metavar="DIR", help="a new folder, or one of these")
    diff = _command(commands, "diff", "tell how two maps differ")
    diff.add_argument("one", metavar="A", help="a folder of a running map, or a saved map")
    diff.add_argument("other", metavar="B", help="the map to compare with")
    verify = _command(commands, "verify", "compute stored numbers again, and compare")
    verify.add_argument("map", metavar="X", help="a folder of a running map, or a saved map")
    share = verify.add_mutually_exclusive_group()
    share.add_argument(
        "--share",
        type=float,
        default=0.01,
        metavar="F",
        help="share of the numbers, chosen at random (default: 0.01)",
    )
    share.add_argument(
        "--all", dest="share", action="store_const", const=1.0, help="all numbers that are stored"
    )
    verify.add_argument("--seed", type=int, default=0, metavar="N", help="key of the random choice")
    verify.add_argument("--threads", type=int, metavar="N", help=THREADS)
    pack = _command(commands, "pack", "write a running map as one file")
    pack.add_argument("store", metavar="DIR", help=_FOLDER)
    pack.add_argument("out", metavar="OUT", help="the file to write, in .npz or .zarr, or a URL")
    pack.add_argument(
        "--partial", action="store_true", help="also write a map that is not finished"
    )
    pack.add_argument("--force", action="store_true", help="replace an existing file")


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
    return pixels_done(folder, result_of(folder) if result is None else result)


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
