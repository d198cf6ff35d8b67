"""Odd arguments and damaged files: nothing but a refusal in words, or a result that is one.

    python tests/long/fuzz.py [--cases 20000] [--target NAME ...] [--seed 1] [--from 0]

Warnings are errors. A case may be refused by the exceptions that the target documents, in a message
of its own that is not long; all else is listed with its number.
"""

import argparse
import re
import resource
import signal
import sys
import time
import warnings
from collections import Counter
from pathlib import Path
from random import Random
from types import FrameType

sys.path.insert(0, str(Path(__file__).parents[1] / "shared"))

from fuzz_targets import REFUSALS, TARGETS, TOML_FILE

#: Address space (bytes), and seconds of processor time of a case: no case needs a tenth of them.
MEMORY, SECONDS = 6 * 2**30, 10.0

#: A message is short, and it is not one of Python's own, which know no argument.
LONGEST_MESSAGE = 600
BARE = re.compile(r"^Exceeds the limit|too large to convert")


class TooSlowError(Exception):
    """A case took too long."""


def _stop(_signal: int, _frame: FrameType | None) -> None:
    raise TooSlowError(f"more than {SECONDS:g} s")


def outcome(target: str, seed: int, number: int) -> str:
    """``accepted``, ``refused``, or what went wrong."""
    signal.setitimer(signal.ITIMER_VIRTUAL, SECONDS)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.filterwarnings("ignore", "sides = .* lighter than any solid")
            TARGETS[target](Random(f"{target} {seed} {number}"))
    except REFUSALS[target] as refusal:
        words = str(refusal)
        if not 10 <= len(words) <= LONGEST_MESSAGE:
            return f"a message of {len(words)} characters: {words[:80]!r}"
        if target == "toml" and not words.startswith(TOML_FILE):
            return f"a message without the file: {words[:80]}"
        if BARE.search(words):
            return f"a bare message: {words[:80]}"
        return "refused"
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt):
            raise
        return f"{type(error).__name__}: {' '.join(str(error).split())[:200]}"
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
    return "accepted"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=20_000, help="of each target")
    parser.add_argument("--target", nargs="*", choices=TARGETS, default=list(TARGETS))
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--from", type=int, default=0, dest="first", help="number of the first")
    chosen = parser.parse_args()
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    signal.signal(signal.SIGVTALRM, _stop)

    wrong = 0
    print(f"{'target':15} {'cases':>7} {'accepted':>9} {'refused':>9} {'other':>7} {'seconds':>8}")
    for target in chosen.target:
        begin = time.perf_counter()
        numbers = range(chosen.first, chosen.first + chosen.cases)
        found = {number: outcome(target, chosen.seed, number) for number in numbers}
        counts = Counter(found.values())
        accepted, refused = counts.pop("accepted", 0), counts.pop("refused", 0)
        other, seconds = sum(counts.values()), time.perf_counter() - begin
        wrong += other
        row = f"{target:15} {len(found):7} {accepted:9} {refused:9} {other:7} {seconds:8.0f}"
        print(row, flush=True)
        for words, count in counts.most_common():
            first = next(number for number, said in found.items() if said == words)
            print(f"    {count} x {words} (--target {target} --from {first} --cases 1)")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
