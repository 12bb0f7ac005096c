"""The command on what results are compared with: references and experience."""

from __future__ import annotations

import argparse

from harness.cli.exit_codes import DONE
from harness.references.registry import all_entries, one_entry


def references(options: argparse.Namespace) -> int:
    """Print all references and all experience, or one of them in full."""
    print(all_entries() if options.id is None else one_entry(options.id))
    return DONE
