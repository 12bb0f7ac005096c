"""The pages: their Python and their commands run as they stand there, and their links lead on."""

import argparse
import os
import re
import shlex
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from harness.cli.main import main
from harness.cli.options import make_parser, mistake_in, options_of
from harness.interpret.description import is_site_file
from harness.study.study import is_scene, load_study
from mpm_warp.materials.clay_law import laws
from mpm_warp.scenes import scene_class
from tests.conftest import blocks, finished

ROOT = Path(__file__).parents[1]
README, OF_HARNESS = ROOT / "README.md", ROOT / "harness" / "README.md"
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("[!.]*/**/*.md")])
EXECUTED = ROOT / "studies" / "guide.md", ROOT / "mpm_warp" / "scenes" / "own_scene.md"
"""All that they show is run, see `test_guide.py` and `test_own_scene.py`."""
OF_NO_COST = ("list", "describe", "schema")
SHORT = ("cells_per_radius=1.5", "penetration=1", "steady_tolerance=0")
"""Settings of a cone test by which its result has the same names and dims at next to no cost."""
SET_SHORT = [f"--set={setting}" for setting in SHORT]


def run(script: str, folder: Path) -> str:
    """What a script prints in a Python process of its own, in a folder and without a screen."""
    file = folder / "script.py"
    file.write_text(script)
    without_screen = os.environ | {"MPLBACKEND": "Agg", "PYTHONPATH": str(ROOT)}
    done = finished([sys.executable, file.name], cwd=folder, env=without_screen)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the results of the main job, coarse and short."""
    made = tmp_path_factory.mktemp("reader")
    assert main(["run", "adhesion_factor", *SET_SHORT, f"--out={made / 'results'}"]) == 0
    return made


def test_the_front_door_has_the_test_command_that_the_gate_runs() -> None:
    gate = (ROOT / ".ci" / "run").read_text()
    command = re.search(r'^tests="(.+)"$', gate, re.MULTILINE)
    assert command
    assert command[1] in README.read_text().splitlines()


@pytest.mark.slow
def test_the_front_doors_python_runs(tmp_path: Path) -> None:
    (block,) = blocks(README.read_text())
    assert f"`{run(block, tmp_path).strip()}`" in README.read_text()
    assert (tmp_path / "resistance.png").stat().st_size > 0


@pytest.mark.slow
def test_a_study_of_ones_own_is_made_and_read(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(folder)
    page = OF_HARNESS.read_text().partition("## A study of your own")[2].partition("\n## ")[0]
    (block,) = blocks(page, "sh")
    for line in block.splitlines():
        words = shlex.split(line, comments=True)[1:]
        assert main(words) == 0, line
        if words[0] == "new":  # the edit that the page speaks of, and a mesh that costs nothing
            definition = Path("my_study.toml")
            before, after = re.findall(r"`(rigidity_index = \[.*?\])`", page)
            assert before in definition.read_text(encoding="utf-8")
            short = "".join(f"{it.replace('=', ' = ')}\n" for it in SHORT)
            edited = definition.read_text(encoding="utf-8").replace(before, after)
            definition.write_text(
                edited.replace("[fixed]\n", f"[fixed]\n{short}"), encoding="utf-8"
            )
    assert "<html" in Path("my_study.html").read_text(encoding="utf-8")
    assert run(blocks(OF_HARNESS.read_text())[0], folder).count("completed") == 3
    assert "penetration" in Path("resistance.csv").read_text(encoding="utf-8")
    capsys.readouterr()


@pytest.mark.slow
def test_results_are_read_and_held_against_a_new_reference(folder: Path) -> None:
    for block in blocks(OF_HARNESS.read_text())[1:]:
        if ".fields.nc" not in block:  # which needs snapshots: see test_view.py
            run(block, folder)


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_python_of_other_pages_runs(page: Path, tmp_path: Path) -> None:
    if page not in (README, OF_HARNESS, *EXECUTED):
        text, printed = page.read_text(encoding="utf-8"), ""
        for block in blocks(text):
            for name in re.findall(r'"results/(\w+)\.nc"', block):
                assert main(["run", name, *SET_SHORT, f"--out={tmp_path / 'results'}"]) == 0
            printed += run(block, tmp_path)
        assert all(told in printed for told in re.findall(r"It prints `([^`]+)`", text))


def commands(page: Path) -> Iterator[str]:
    """The commands of `harness` on a page: those in blocks, and those within the text."""
    for block in blocks(page.read_text(encoding="utf-8"), "sh"):
        yield from re.findall(r"(?:^|bin/)harness (.*)$", block, re.MULTILINE)
    yield from re.findall(r"`harness ([^`]+)`", " ".join(page.read_text(encoding="utf-8").split()))


@pytest.mark.parametrize(
    "page", [it for it in PAGES if it not in EXECUTED], ids=lambda page: str(page.relative_to(ROOT))
)
def test_every_command_can_be_given(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A command is known with its options, and every study and scene that it names is there."""
    monkeypatch.chdir(tmp_path)
    main(["new", "my_study"])
    Path("cpt.csv").write_text("depth [m],qc [MPa],fs [kPa]\n1,1,1\n", encoding="utf-8")
    main(["new", "site", "--interpret", "cpt.csv"])
    parser = make_parser()
    for line in dict.fromkeys(commands(page)):
        words = shlex.split(line.partition(" | ")[0].partition(" > ")[0], comments=True)
        if is_placeholder(words[0]) or words[0].startswith("-"):
            continue
        assert mistake_in(words) is None, line
        if is_mention(words):
            known = options_of(words[0])
            assert {word for word in words if word.startswith("--")} <= {*known}, line
            continue
        options, unknown = parser.parse_known_args(words)
        assert unknown == [], line
        assert all(load_study(*study).cases for study in studies_of(options)), line
        given = vars(options).get("scene") or []
        for scene in [given] if isinstance(given, str) else given:
            assert is_placeholder(scene) or scene_class(scene), line
        if words[0] in OF_NO_COST and not any(map(is_placeholder, words)):
            assert main(words) == 0, line
    capsys.readouterr()


def is_mention(words: list[str]) -> bool:
    """Whether a text speaks of a command, or of an option of it, without what it is to be given."""
    is_complete = words[0] in ("bench", "list", "schema", "status", "verify")
    return "--help" in words or not (is_complete or (words[1:2] and not words[1].startswith("-")))


def studies_of(options: argparse.Namespace) -> Iterator[tuple[str, list[str]]]:
    """The studies that a command names, with their settings."""
    study, subject = (vars(options).get(it) for it in ("study", "subject"))
    if study and not is_placeholder(study) and not study.endswith(".nc"):
        yield study, options.set
    if subject and not (
        is_placeholder(subject) or subject in laws() or is_scene(subject) or is_site_file(subject)
    ):
        yield subject, vars(options).get("set", [])


def is_placeholder(word: str) -> bool:
    """Whether a word stands for one that the reader chooses, as STUDY does."""
    return word.partition(".")[0].isupper()


@pytest.mark.parametrize(
    "page",
    [it for it in PAGES if it.name == "README.md"],
    ids=lambda page: str(page.relative_to(ROOT)),
)
def test_a_page_is_read_in_a_quarter_of_an_hour_and_the_first_in_five_minutes(page: Path) -> None:
    assert len(page.read_text(encoding="utf-8").split()) < 2500
    assert page != README or len(page.read_text(encoding="utf-8").splitlines()) <= 150


def anchors(page: Path) -> set[str]:
    """What the headings of a page are called in links, as GitHub makes it of them."""
    headings = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_to_what_is_there(page: Path) -> None:
    broken = []
    for link in re.findall(r"\]\(([^)]+)\)", page.read_text(encoding="utf-8")):
        file, _, anchor = link.partition("#")
        target = page.parent / file if file else page
        if "://" not in link and not (
            target.exists() and (not anchor or anchor in anchors(target))
        ):
            broken.append(link)
    assert broken == []


@pytest.mark.parametrize(
    "page", [it for it in PAGES if it not in EXECUTED], ids=lambda page: str(page.relative_to(ROOT))
)
def test_files_and_folders_that_a_page_names_are_there(page: Path) -> None:
    """In its own folder or one above it, or in a folder that it names."""
    named = re.findall(
        r"(?<!\[)`((?!results/)[\w./-]+(?:\.py|/))`", page.read_text(encoding="utf-8")
    )
    above = [it for it in page.parents if it.is_relative_to(ROOT)]
    folders = [*above, *(at / it for at in above for it in named if it.endswith("/"))]
    assert [it for it in named if not any((at / it).exists() for at in folders)] == []


def test_functions_and_classes_that_a_page_calls_are_there() -> None:
    sources = [
        file.read_text() for it in ("mpm_warp", "harness") for file in ROOT.glob(f"{it}/**/*.py")
    ]
    defined = set(re.findall(r"^ *(?:def|class) (\w+)", "\n".join(sources), re.MULTILINE))
    called = {page: re.findall(r"`(\w+)\(", page.read_text()) for page in PAGES}
    assert {page: lost for page, it in called.items() if (lost := {*it} - defined)} == {}
