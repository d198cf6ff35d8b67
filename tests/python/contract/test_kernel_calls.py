"""The command that refuses calls inside kernels reads machine code: it must see what is wrong."""

import importlib.util
import sys
from pathlib import Path

import pytest

_PATH = Path(__file__).parents[3] / "benches" / "kernel_calls.py"
_SPEC = importlib.util.spec_from_file_location("kernel_calls", _PATH)
assert _SPEC is not None
assert _SPEC.loader is not None
kernel_calls = importlib.util.module_from_spec(_SPEC)
sys.modules["kernel_calls"] = kernel_calls
_SPEC.loader.exec_module(kernel_calls)

KERNEL = "rigid::kernel::registry::kernels_of::Taylor::avx2::advance"
TABLE = {0x9000: "memcpy@GLIBC_2.14", 0x9008: "fma@GLIBC_2.2.5", 0x9010: "rigid::method::only"}


def refused(*instructions: str, name: str = KERNEL) -> list[tuple[str, str]]:
    """What is refused of a function of these instructions, which begin at 0x100."""
    listing = [f"{0x100:016x} <{name}>:"]
    listing += [f"     {0x100 + 4 * i:x}:\t{text}" for i, text in enumerate(instructions)]
    (function,) = kernel_calls.functions(listing, TABLE)
    assert kernel_calls.KERNEL.search(function.name)
    why = [(name, kernel_calls.why_refused(function, at, name)) for at, name in function.calls]
    return [(name, reason) for name, reason in why if reason is not None]


@pytest.mark.parametrize(
    "call",
    [
        "call   200 <rigid::method::only>",
        "addr32 call 200 <rigid::method::only>",
        "call   *0x8f10(%rip)        # 9010 <_GLOBAL_OFFSET_TABLE_+0x10>",
        "jmp    200 <rigid::method::only>",
        "jmp    210 <rigid::method::only+0x10>",
        "jmp    *0x8f10(%rip)        # 9010 <_GLOBAL_OFFSET_TABLE_+0x10>",
    ],
)
def test_a_call_inside_a_kernel_is_refused(call: str) -> None:
    assert refused("push   %rbp", call, "ret") == [("rigid::method::only", "not inlined")]


def test_a_call_to_an_address_that_is_computed_is_refused() -> None:
    assert refused("call   *%rax") == [("call   *%rax", "not inlined")]


def test_kernels_under_the_torque_of_a_function_call_its_address() -> None:
    called = (
        "rigid::kernel::registry::kernels_of::Rk4::avx2::advance::<rigid::scene::FunctionFrame>"
    )
    assert not refused("call   *0x28(%rax)", name=called)
    assert refused("call   200 <rigid::method::only>", name=called)


def test_a_call_of_a_register_is_one_of_what_is_loaded_there() -> None:
    fma = "mov    0x8f08(%rip),%rbx        # 9008 <_GLOBAL_OFFSET_TABLE_+0x8>"
    other = "mov    0x8f10(%rip),%r12        # 9010 <_GLOBAL_OFFSET_TABLE_+0x10>"
    plain = "rigid::kernel::registry::kernels_of::Taylor::scalar::advance"
    assert not refused(fma, "call   *%rbx", name=plain)
    assert refused(fma, other, "call   *%r12", name=plain) == [
        ("rigid::method::only", "not inlined")
    ]


def test_jumps_within_a_kernel_and_refused_indices_are_no_calls() -> None:
    assert not refused(
        "je     10c <rigid::kernel::registry::kernels_of::Taylor::avx2::advance+0xc>",
        "jmp    100 <rigid::kernel::registry::kernels_of::Taylor::avx2::advance>",
        "call   300 <core::panicking::panic_bounds_check>",
        "call   400 <core::slice::index::slice_end_index_len_fail>",
    )


def test_a_kernel_may_be_the_code_of_another() -> None:
    assert not refused("jmp    200 <rigid::kernel::registry::kernels_of::Taylor::avx2::advance>")


def test_a_copy_is_refused_in_every_step_only() -> None:
    copy = "call   *0x8f00(%rip)        # 9000 <_GLOBAL_OFFSET_TABLE_>"
    loop = "jne    104 <rigid::kernel::registry::kernels_of::Taylor::avx2::advance+0x4>"
    assert refused("push   %rbp", copy, loop, loop) == [("memcpy@GLIBC_2.14", "in every step")]
    assert not refused("push   %rbp", copy, loop)
    assert not refused(copy, "push   %rbp", loop, loop)


def test_only_the_plain_path_rounds_with_the_c_library() -> None:
    call = "call   *0x8f08(%rip)        # 9008 <_GLOBAL_OFFSET_TABLE_+0x8>"
    fused = "vfmadd231pd %ymm0,%ymm1,%ymm2"
    assert refused(fused, call) == [("fma@GLIBC_2.2.5", "although it has FMA")]
    assert not refused(
        "mulsd  %xmm0,%xmm1",
        call,
        name="rigid::kernel::registry::kernels_of::Taylor::scalar::advance",
    )
