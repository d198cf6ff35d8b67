"""What commands print, read back: facts of wrapped lines, methods that do not apply."""

import re


def unwrapped(text: str, indent: int = 12) -> str:
    """The text with each broken line in one piece again."""
    return re.sub(rf"\n {{{indent}}}(?=\S)", " ", text)


def facts_of(text: str) -> dict[str, str]:
    """The first words of the lines, with the rest of them."""
    lines = unwrapped(text).splitlines()
    return dict(line.split(maxsplit=1) for line in lines if " " in line)


def refused_in(text: str) -> set[str]:
    """The methods that a report names as not for its scene."""
    names = re.findall(r"^not for +([\w, ]+):", unwrapped(text), re.MULTILINE)
    return {name for some in names for name in some.split(", ")}
