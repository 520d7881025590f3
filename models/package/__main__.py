"""The command ``linkframe``, also as ``python -m linkframe``."""

import sys


def main() -> int:
    """Run the command line; an interrupt while it is loaded ends as quietly as one while it runs.

    Returns
    -------
    int
        Exit code, as of `linkframe.models.command_line.main`.
    """
    try:
        from linkframe.models.command_line import main as run
    except KeyboardInterrupt:
        return 130
    return run()


if __name__ == "__main__":
    sys.exit(main())
