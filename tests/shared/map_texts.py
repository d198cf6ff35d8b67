"""Files of maps in TOML, of which a test says the tables that matter to it."""

FREE = 'kind = "free-body"\nmoments = [1.0, 1.3, 1.6]'
TABLES = {
    "scene": 'kind = "heavy-top"\nmoments = [1, 1, 0.5]\nmgl = 1',
    "x": 'name = "spin"\nvalues = [1.0, 2.0]',
    "start": "spin = 2.0",
    "stable": 'criterion = "tilt_below"\nangle = 1.0',
    "run": "t_end = 1.0\nsamples = 2",
}


def map_text(**tables: str) -> str:
    """A map of a top at two spins, with other tables or more."""
    return "".join(f"[{name}]\n{keys}\n" for name, keys in {**TABLES, **tables}.items())


#: A free body at 4 moments and 3 sizes of the noise, for the command.
SMALL = """
title = "A small map"
[scene]
kind = "free-body"
moments = [1.0, 1.5, 2.0]
[x]
name = "I1"
values = [0.4, 0.9, 1.1, 1.3]
[y]
name = "noise"
from = 1e-3
to = 0.1
count = 3
scale = "log"
[start]
spin = 1.0
axis = 2
noise = { kind = "normal" }
[stable]
criterion = "no_flip"
[run]
t_end = 20.0
samples = 10
seed = 5
"""
