"""Mutants of Python that compute the same, so that no test can kill them, each with its reason."""

from python_mutants import Mutant

#: Module in `python/rigid`, line, and change; and why nobody can tell.
EQUIVALENT: dict[tuple[str, str, str], str] = {
    (
        "literature/free_bodies.py",
        "size = float(np.linalg.norm(momentum[0]))",
        "0 -> 1",
    ): "the momentum of a free body has one length at all times",
    (
        "model/body.py",
        "kept.setflags(write=False)",
        "False -> True",
    ): "the flag guards against a fault of ours: nothing writes into the rates of bodies",
    (
        "model/bodies.py",
        "if not fastest**2 < HEAVIEST:",
        "2 -> 3",
    ): "it decides how soon the weight is looked at, whose own limit then counts",
    (
        "_checks/arguments.py",
        "if type(value) is int and minimum <= value < 2**63:",
        "2 ** 63 -> 2 * 63",
    ): "the shorter way for most whole numbers: the longer way gives the same ones",
    (
        "_checks/arguments.py",
        "if array.shape[-1] > 1 and (array[..., 1:] < array[..., :-1]).any():",
        "array.shape[-1] > 1 -> array.shape[-1] >= 1",
    ): "one number has no pair in a wrong order",
    (
        "model/forces.py",
        'return f"{self.name} {numbers[0]:g}"',
        "0 -> 1",
    ): "the numbers are all equal",
    (
        "rotations/so3.py",
        "return np.where(zero, limit, numerator / np.where(zero, 1.0, denominator))",
        "1.0 -> 2.0",
    ): "the quotient where the denominator is zero is not returned",
    (
        "_checks/progress.py",
        "bar.set_postfix_str(failed(progress.failures), refresh=False)",
        "False -> True",
    ): "how often a bar is drawn, which nothing that is computed depends on",
    (
        "reports/ensemble.py",
        "STEPS = 4",
        "4 -> 5",
    ): "the same methods differ in four steps and in five",
    (
        "reports/ensemble.py",
        "scale = np.where(scale > 0.0, scale, np.where(self.rates > 0.0, self.rates, 1.0))",
        "1.0 -> 2.0",
    ): "a body that never turns errs by nothing, on any scale",
    (
        "reports/stress.py",
        "return _Truth(run.omega[-1], run.attitude[-1], condition=0.0)",
        "0.0 -> 1.0",
    ): "what four roundings change is far below the accuracy",
    (
        "reports/stress.py",
        "return _Truth(*case.truth, condition=0.0)",
        "0.0 -> 1.0",
    ): "what four roundings change is far below the accuracy",
    (
        "reports/table.py",
        "small = nanoseconds < 10.0**digits - 0.5",
        "0.5 -> 1.5",
    ): "a number next to a power of ten has the same digits in both forms",
    (
        "store/drive.py",
        "for future in wait(waiting, timeout=0.1, return_when=FIRST_COMPLETED).done:",
        "0.1 -> 1.1",
    ): "how soon a stop is seen, which nothing that is computed depends on",
    (
        "store/log.py",
        "MOST_MEMBER = 2**30",
        "2 -> 3",
    ): "no log has so large members: a block is a minute of work",
    (
        "store/log.py",
        "MOST_MEMBER = 2**30",
        "30 -> 60",
    ): "no log has so large members: a block is a minute of work",
    (
        "maps/satellites.py",
        "time: Floats = (0.5 * whole * measure / power).sum(axis=-1)",
        "-1 -> +1",
    ): "the array has two axes",
    (
        "store/call.py",
        'given.setdefault("t_end", 1.0)  # the longest one is taken from the values',
        "1.0 -> 2.0",
    ): "the horizon of the map is the longest one of its axis",
    (
        "maps/axes.py",
        "return bool(np.ptp(steps) <= 1e-6 * abs(steps[0]))",
        "np.ptp(steps) <= 1e-06 * abs(steps[0]) -> np.ptp(steps) < 1e-06 * abs(steps[0])",
    ): "no steps scatter by the tolerance to the last bit",
    (
        "maps/axes.py",
        "return bool(np.ptp(steps) <= 1e-6 * abs(steps[0]))",
        "0 -> 1",
    ): "steps that agree to a millionth have one size to a millionth",
    (
        "maps/sequential.py",
        "bound = (1.3 / half_width) ** 2 + 4 * LOOK",
        "1.3 -> 2.3",
    ): "the table ends at the look at which every pixel stops, wherever the search for it ends",
    (
        "maps/sequential.py",
        "bound = (1.3 / half_width) ** 2 + 4 * LOOK",
        "4 -> 5",
    ): "the table ends at the look at which every pixel stops, wherever the search for it ends",
    (
        "maps/page.py",
        "done = max(int(data.samples.sum()), 1)",
        "1 -> 2",
    ): "it counts the bytes of a map of one body, which fits into any page",
    (
        "model/measures.py",
        "tilt_below(1.0, reference=self.reference).check_forced(scene, forces)",
        "1.0 -> 2.0",
    ): "the check of the forces does not look at the angle",
    (
        "model/measures.py",
        "return ON_ORBIT.get(name, name), self.axis or 0, ()",
        "0 -> 1",
    ): "the core does not look at the axis of a measure that has none",
    (
        "model/sampled.py",
        "width = np.where(end > begin, end - begin, 1.0)",
        "1.0 -> 2.0",
    ): "a piece without width is met at its begin: the share of it is zero over any number",
    (
        "meshes.py",
        "within = (left <= point[0]) & (point[0] <= right) & (down <= point[1]) & (point[1] <= up)",
        "(left <= point[0]) & (point[0] <= right) -> (left <= point[0]) | (point[0] <= right)",
    ): "it looks at further triangles, and the signs of their areas tell that the line misses them",
    (
        "literature/spin_orbit.py",
        "check=0.0,",
        "0.0 -> 1.0",
    ): "a check changes no number of a map",
    (
        "inertia/symmetry.py",
        "chunk = max(1, _AT_ONCE // len(r))",
        "1 -> 2",
    ): "it decides how many matrices are tried at once, each by itself",
    (
        "fits/least_squares.py",
        "free = ~(((x <= low) & (pull > 0.0)) | ((x >= high) & (pull < 0.0)))",
        "pull < 0.0 -> pull <= 0.0",
    ): "a number at its bound that nothing pulls waits for a step of the others",
    (
        "fits/least_squares.py",
        "free = ~(((x <= low) & (pull > 0.0)) | ((x >= high) & (pull < 0.0)))",
        "pull > 0.0 -> pull >= 0.0",
    ): "a number at its bound that nothing pulls waits for a step of the others",
    (
        "solve/frequencies.py",
        "least = 1e-15 * np.abs(frequency).max(initial=0.0)",
        "0.0 -> 1.0",
    ): "a line below one radian in all stands alone, and needs no second round",
    (
        "solve/frequencies.py",
        "phase = float(np.abs(frequency * self.t[-1]).max(initial=0.0))",
        "-1 -> +1",
    ): "the times are around zero: the second is as far from it as the last, but for a step",
    (
        "solve/run.py",
        "known = int(np.isfinite(states[0]).all(axis=-1).sum())",
        "np.isfinite(states[0]).all -> np.isfinite(states[0]).any",
    ): "after the event that ended a body no component is known, before it each is",
    (
        "solve/tangent.py",
        "max_steps=10**9,",
        "10 -> 11",
    ): "no body takes so many steps before its call is given up",
    (
        "_timing.py",
        "PACK = 8",
        "8 -> 9",
    ): "it decides how fast a cost is measured, not what it is",
}


def key_of(mutant: Mutant) -> tuple[str, str, str]:
    """Module in `python/rigid`, line, and change."""
    return mutant.path.removeprefix("python/rigid/"), mutant.source, mutant.change


def why_equivalent(mutant: Mutant) -> str | None:
    """Why a mutant computes the same; None if it does not."""
    if "reshape(-1" in mutant.source and mutant.change == "1 -> 2":
        return "NumPy takes each negative length for the one that follows from the others"
    if "strict=True" in mutant.source and mutant.change == "True -> False":
        return "zip takes lists of one length, by construction: the flag guards against our faults"
    return EQUIVALENT.get(key_of(mutant))
