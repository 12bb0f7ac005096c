"""``harness``, and ``python -m harness``."""

import signal
import sys


def main() -> int:
    """Run the command line and return the exit code; see `harness.cli.main.main`."""
    try:
        # Imported inside `try` because Ctrl-C may come during the import.
        from harness.cli.main import main as run

        return run()
    except KeyboardInterrupt:
        sys.stderr.write("harness: interrupted\n")
        return 128 + signal.SIGINT


if __name__ == "__main__":
    sys.exit(main())
