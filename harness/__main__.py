"""``harness``, and ``python -m harness``."""

import signal
import sys


def main() -> int:
    """Run the command line; the exit code. See `harness.cli.main.main`."""
    try:
        # Ctrl-C may come while this is imported.
        from harness.cli.main import main as run

        return run()
    except KeyboardInterrupt:
        return 128 + signal.SIGINT


if __name__ == "__main__":
    sys.exit(main())
