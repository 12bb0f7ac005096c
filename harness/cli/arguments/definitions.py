"""Commands on definitions of studies: their options."""

from __future__ import annotations

from typing import TYPE_CHECKING

from harness.cli.arguments.shared import add_set, add_subject

if TYPE_CHECKING:
    from harness.cli.arguments.parser import Commands


def add_definitions(commands: Commands) -> None:
    """The commands that take or write definitions of studies."""
    new = commands.add_parser("new", help="write a study of your own, to be edited and run")
    new.add_argument("name", metavar="NAME", help="of the study; its file is NAME.toml")
    new.add_argument(
        "--scene", default="cone_penetration", metavar="SCENE", help="default: cone_penetration"
    )

    commands.add_parser("list", help="list studies and scenes")

    describe = commands.add_parser("describe", help="describe a scene, or a study")
    add_subject(describe)

    commands.add_parser("schema", help="print a JSON schema of studies, for editors")

    plan = commands.add_parser("plan", help="print what a scene or a study costs, before it runs")
    add_subject(plan)
    add_set(plan)
