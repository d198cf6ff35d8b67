"""What is judged of motions, by name: one random case of its number and a seed."""

from collections.abc import Callable, Mapping
from functools import partial

from judged import Judged
from judged_bodies import judge_frame, judge_mesh, judge_other_times, judge_steps, judge_tensor
from judged_growth import judge_drift, judge_growth, judge_lines, judge_verdict
from judged_textbook import (
    judge_cones,
    judge_long_run,
    judge_map_of_functions,
    judge_poinsot,
    judge_springs,
    judge_statics,
    judge_table,
    judge_throw,
)

__all__ = ["SUBJECTS"]

SUBJECTS: Mapping[str, Callable[[int, int], Judged]] = {
    "growth": judge_growth,
    "growth under torques in space": partial(judge_growth, kinds=("space",)),
    "verdicts": judge_verdict,
    "lines": judge_lines,
    "drift of lines": judge_drift,
    "tensors": judge_tensor,
    "meshes": judge_mesh,
    "frames": judge_frame,
    "other times": judge_other_times,
    "steps": judge_steps,
    "statics": judge_statics,
    "cones": judge_cones,
    "poinsot": judge_poinsot,
    "throws": judge_throw,
    "springs": judge_springs,
    "long runs": judge_long_run,
    "tables": judge_table,
    "maps of functions": judge_map_of_functions,
}
