"""Refuses a call inside a kernel, on every instruction set.

    python benches/kernel_calls.py            # builds the library with symbols, then reads it
    python benches/kernel_calls.py LIBRARY    # reads that library, say rigid/_core.abi3.so

A kernel is fast because everything that it does is inlined into it: a call that is left makes a
step up to five times slower. Whether the compiler inlines a function without `#[inline(always)]`
depends on how the crate is cut into codegen units. This command reads the machine code, so it does
not depend on luck. It needs `objdump` and `nm` (binutils) and a library for x86-64 whose symbols
tell the types of a kernel: CARGO_PROFILE_RELEASE_STRIP=none, and RUSTFLAGS with
-Csymbol-mangling-version=v0. Exit status 1 if a call is refused.
"""

import argparse
import os
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

# The entry points of kernels, by their paths.
KERNEL = re.compile(
    r"\brigid::kernel::registry::kernels_of::\w+::(avx512|avx2|scalar)::(Packs<.*>::)?"
    r"(advance|processed|adaptive|alone|dense|invariants_of)\b"
    r"|as rigid::real::Real>::outlined::outlined::<rigid::simd::isa::By<"
    r".*rigid::exact::evaluate::(States|Exits)>>"
)

# What stands in their modules is one of them.
OF_KERNELS = "rigid::kernel::registry::kernels_of::"

# Parts that several kernels share are functions of their own, and are read as kernels are.
SHARED = re.compile(
    r"as rigid::real::Real>::outlined::outlined::"
    r"<rigid::(observe::((bounds::)?Look|MotionInside)|method::(taylor::Expansion|midpoint::TorqueInTheMiddle)"
    r"|forces::trajectory::PlaceOfRoot)<"
)
# What a kernel may call, and why.
ALLOWED = {
    "a refused index never returns": re.compile(
        r"^core::panicking::|^core::slice::index::.*_fail\b|^core::(option|result)::(unwrap|expect)_failed"
    ),
    "two kernels with one code share it": KERNEL,
    "what several kernels share is compiled once": SHARED,
}
# A function of the user is called by its address, by these kernels only: in steps of one body, or
# for those of a pack by one function of the library.
OF_THE_USER = re.compile(r"^call\s+\*|^<rigid::forces::function::TorqueRows>::call(::<\d+, \d+>)?$")
MAY_CALL_IT = re.compile(
    r"::(kernels_of::|observe::(Look|MotionInside)<).*::(Function(Frame|Turns)|StatesTurns)\b"
    r"|::midpoint::TorqueInTheMiddle<"
)
# The plain path is for processors without FMA: it rounds products as FMA does with the C library.
WITHOUT_FMA = re.compile(r"^(fma|rint|roundeven)$")
# What the compiler calls for a large copy. It is refused in two nested loops (steps and packs),
# but of these kernels, and why.
COPIES = re.compile(r"^(memcpy|memset|memmove)$")
MAY_COPY = {
    "the plain path is not for speed": re.compile(r"::scalar::"),
    "a state of 15 components is in memory, not in registers": re.compile(
        r"::(ForcedFrame|FurtherFrame)\b"
    ),
    "a state of eight bodies is in memory, not in registers": re.compile(
        r"::(Function(Frame|Turns)|StatesTurns)\b"
    ),
    "the set-up of a pack copies the tables of its drift": re.compile(r"::KickMoserVeselov\b"),
    "the set-up of a pack copies the functions of its damping": re.compile(r"::Exponential<"),
    "the set-up of a pack copies the numbers of twelve stages": re.compile(
        r"::Dop853::avx2::.*::(Rates|Axis|Attitude|Turns)\b"
    ),
    "the set-up of a pack copies the turns of its stages": re.compile(r"::OrbitTurns\b"),
    "a state of 23 components is in memory, not in registers": re.compile(
        r"::FurtherFrameTangent\b"
    ),
    "a state of a free body clears its multiples of the phase once": re.compile(
        r"::exact::evaluate::States\b"
    ),
}

HEADER = re.compile(r"^([0-9a-f]+) <(.*)>:$")
INSTRUCTION = re.compile(r"^\s*([0-9a-f]+):\s+(.*)$")
DIRECT = re.compile(r"\b(call|j\w+)\s+([0-9a-f]+) <(.*)>")
THROUGH_TABLE = re.compile(r"\b(?:call|jmp)\s+\*.*# ([0-9a-f]+)\b")
LOADED = re.compile(r"^mov\s+0x[0-9a-f]+\(%rip\),(%r\w+)\s+# ([0-9a-f]+)\b")


@dataclass
class Function:
    """The code of one function: where it is, where it jumps and what it calls."""

    name: str
    begin: int
    end: int = 0
    uses_fma: bool = False
    jumps: list[tuple[int, int, str]] = field(default_factory=list)
    calls: list[tuple[int, str]] = field(default_factory=list)
    computed: list[tuple[int, str]] = field(default_factory=list)
    loaded: dict[str, set[str]] = field(default_factory=dict)

    def finished(self) -> "Function":
        """The function when all its instructions are known.

        A jump that leaves it is a call. A call of a register may be one of any address that the
        function loads into it from the global offset table, or into any register if into none.
        """
        inside = [jump for jump in self.jumps if self.begin <= jump[1] <= self.end]
        outside = [jump for jump in self.jumps if not self.begin <= jump[1] <= self.end]
        calls = self.calls + [(at, name) for at, _, name in outside]
        for at, text in self.computed:
            register = text.rpartition("*")[2]
            names = self.loaded.get(register) or set().union(*self.loaded.values())
            calls += [(at, name) for name in sorted(names) or [text]]
        return Function(self.name, self.begin, self.end, self.uses_fma, inside, sorted(calls))

    def loops_around(self, at: int) -> int:
        """The number of jumps back that enclose that address."""
        return sum(to <= at <= last for last, to, _ in self.jumps)


def functions(listing: Iterable[str], table: Mapping[int, str]) -> Iterator[Function]:
    """The functions in the output of `objdump -d -C`.

    `table` has the function behind each address of the global offset table.
    """
    function: Function | None = None
    for line in listing:
        if header := HEADER.match(line):
            if function is not None:
                yield function.finished()
            function = Function(header[2], int(header[1], 16))
        elif function is not None and (instruction := INSTRUCTION.match(line)):
            at, text = int(instruction[1], 16), instruction[2]
            function.end = at
            function.uses_fma |= text.startswith(("vfm", "vfnm"))
            if direct := DIRECT.search(text):
                to, name = int(direct[2], 16), re.sub(r"\+0x[0-9a-f]+$", "", direct[3])
                if direct[1] == "call":
                    function.calls.append((at, name))
                else:
                    function.jumps.append((at, to, name))
            elif through := THROUGH_TABLE.search(text):
                function.calls.append((at, table.get(int(through[1], 16), text)))
            elif loaded := LOADED.search(text):
                if name := table.get(int(loaded[2], 16)):
                    function.loaded.setdefault(loaded[1], set()).add(name)
            elif re.match(r"(\w+ )?call\b", text):
                function.computed.append((at, text))
    if function is not None:
        yield function.finished()


def why_refused(kernel: Function, at: int, callee: str) -> str | None:
    """Why the kernel must not make that call; None if it may."""
    callee = re.sub(r"@.*$", "", callee)
    if any(allowed.search(callee) for allowed in ALLOWED.values()):
        return None
    if OF_THE_USER.search(callee) and MAY_CALL_IT.search(kernel.name):
        return None
    if WITHOUT_FMA.search(callee):
        return "although it has FMA" if kernel.uses_fma else None
    if COPIES.search(callee):
        may = kernel.loops_around(at) < 2 or any(of.search(kernel.name) for of in MAY_COPY.values())
        return None if may else "in every step"
    return "not inlined"


def lines(*command: str) -> Iterator[str]:
    """The lines that a command prints."""
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        yield from process.stdout
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, command)


def offset_table(library: str) -> dict[int, str]:
    """The function behind each address of the global offset table."""
    names = {}
    for line in lines("nm", "-C", "--defined-only", library):
        address, kind, name = line.rstrip("\n").split(" ", 2)
        if kind in "tTwW":
            names[int(address, 16)] = name
    table = {}
    for line in lines("objdump", "-R", library):
        if entry := re.match(
            r"^([0-9a-f]+) R_X86_64_(?:GLOB_DAT|JUMP_SLOT|RELATIVE)\s+(\S+)", line
        ):
            local = re.match(r"\*ABS\*\+0x([0-9a-f]+)", entry[2])
            table[int(entry[1], 16)] = names.get(int(local[1], 16), entry[2]) if local else entry[2]
    return table


def built() -> str:
    """The library, built by the profile of wheels with names that tell what a kernel is of."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", "target")) / "kernel-calls"
    environment = {
        **os.environ,
        "CARGO_TARGET_DIR": str(target),
        "CARGO_PROFILE_RELEASE_STRIP": "none",
        "RUSTFLAGS": "-Csymbol-mangling-version=v0",
    }
    command = "cargo rustc --locked --release --lib --features python --crate-type cdylib"
    subprocess.run(command.split(), check=True, env=environment)
    return str(target / "release" / "librigid.so")


def main() -> int:
    """Read the library and print what is refused."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("library", nargs="?")
    library = parser.parse_args().library or built()
    listing = lines("objdump", "-d", "-C", "--no-show-raw-insn", library)
    all_functions = list(functions(listing, offset_table(library)))
    kernels = [f for f in all_functions if KERNEL.search(f.name) or SHARED.search(f.name)]
    if not any("<" in kernel.name for kernel in kernels):
        print(f"{library}: no kernel has a name with types; see --help", file=sys.stderr)
        return 1
    # A kernel whose path has changed would not be read.
    if missed := [f.name for f in all_functions if OF_KERNELS in f.name and f not in kernels]:
        print(f"{missed[0]}: no kernel by its name, nor {len(missed) - 1} others", file=sys.stderr)
        return 1
    refused: Counter[tuple[str, str, str]] = Counter()
    for kernel in kernels:
        for at, callee in kernel.calls:
            if why := why_refused(kernel, at, callee):
                refused[kernel.name, callee, why] += 1
    for (kernel_name, callee, why), count in sorted(refused.items()):
        print(f"{kernel_name}\n    calls {callee}, {why} ({count} times)")
    print(f"{len(kernels)} kernels, {refused.total()} calls refused")
    return 1 if refused else 0


if __name__ == "__main__":
    sys.exit(main())
