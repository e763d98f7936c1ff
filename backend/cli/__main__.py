"""`python -m backend.cli`, the same as the command `filterroom`."""

import sys

from backend.cli import main

if __name__ == "__main__":
    sys.exit(main())
