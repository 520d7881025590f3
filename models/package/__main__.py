"""``python -m linkframe`` is the command ``linkframe``."""

import sys

from linkframe.models.command_line import main

if __name__ == "__main__":
    sys.exit(main())
