"""The command ``linkframe``, also as ``python -m linkframe``."""

import sys

from linkframe.models import command_line


def main() -> int:
    """Run the command line; an interrupt during the imports ends as quietly as one later.

    Returns
    -------
    int
        Exit code, as returned by `linkframe.models.command_line.main`.
    """
    try:
        run = command_line.main
    except KeyboardInterrupt:
        return 130
    return run()


if __name__ == "__main__":
    sys.exit(main())
