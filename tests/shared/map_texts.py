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
