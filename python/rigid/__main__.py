"""``python -m rigid`` is the command ``rigid``."""

import sys

from .cli import main

if __name__ == "__main__":
    sys.exit(main())
