"""The `chatter` command."""

import sys

from chatter import _chatter


def main() -> int:
    """Does what the arguments of this process ask for; gives the exit code."""
    return _chatter.main(["chatter", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
