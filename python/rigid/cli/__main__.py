"""``python -m rigid.cli`` is the command ``rigid``."""

import sys

from . import main

if __name__ == "__main__":
    sys.exit(main())
