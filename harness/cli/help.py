"""The commands: help texts and options.

`TEXT` has a block for each command: ``[name = function] summary``, where the function is one of
`harness.cli.commands`; then the description; examples after $; and options ``name VALUE: meaning``.
A value in brackets is optional, one with dots may be repeated. A line with names only stands for
options of `SHARED_TEXT`.
"""

import re
from collections.abc import Iterator
from typing import NamedTuple

SHARED_TEXT = """\
  study STUDY: name of a study, or a TOML file
  subject NAME: name of a scene or a study, or a TOML file
  --out DIR: folder of the results; default: results
  --set KEY=VALUE: set a parameter; a list, 'KEY=[1, 2]', varies it; may be repeated
  --threads N: threads of a case, 1, 2 or 4; results do not depend on it; default: idle cores help
  --device NAME: cpu, the default, or a GPU: cuda:0, ...
  --format FORMAT...: of the pictures: png, the default, pdf or svg; several are allowed
"""
TEXT = """\
[new = studies.new] write a study of your own, to edit and run
Write a study into the current folder: a TOML file that explains all parameters of a scene and runs
as it is. Edit it, then run it.
$ harness new my_study
$ harness new my_footing --scene strip_footing
  name NAME: name of the study; its file is NAME.toml
  --interpret TEST: write a site file for this measured test: CSV, .gef, .xml (BRO), .ags, SGF
  --scene SCENE: scene of the study; default: cone_penetration
[tour = studies.tour] write a notebook that shows how to use it from Python
Write tour.ipynb into the current folder: from a first cone to a material law of your own. After
pip install 'mpm-warp[notebook]' open it in JupyterLab or VS Code, which you install yourself, or
run it by jupyter execute --inplace tour.ipynb.
$ harness tour
[list = studies.list_names] list studies and scenes
List the studies that ship and all scenes, one per line.
$ harness list
[describe = studies.describe] describe a scene, a law of clay, a study, or a site file
Describe a scene by its parameters, with default, unit, meaning and allowed range; a study by its
scene, what it varies and fixes, and its number of cases; a site file by its keys, with values and
meaning.
$ harness describe cone_penetration
$ harness describe modified_cam_clay
$ harness describe adhesion_factor
$ harness describe my_study.toml
$ harness describe site.toml
  subject
[schema = studies.schema] print a JSON schema of studies or sites, for editors
Print a JSON schema of study files or of site files. Editors use it to complete and check them.
$ harness schema
$ harness schema site
  of [KIND]: study, the default, or site: files of `harness interpret`
[plan = studies.show_plan] print what a run costs, before it starts
Print what a run will cost. For a single case: its kernels, arrays, steps and time. For several
cases: material points, memory, steps and time of each.
$ harness plan cone_penetration
$ harness plan cone_penetration --set cells_per_radius=6
$ harness plan mesh_size
  subject, --set
[run = run.run] run a study; run it again to go on where it stopped
Run the cases of a study, write its dataset and pictures, and print a table of the results beside
references or exact solutions. Completed cases are kept, so the same command continues a run that
was stopped.
$ harness run adhesion_factor
$ harness run my_study.toml --workers 2 --out runs
$ harness run adhesion_factor --set rigidity_index=50 --set 'adhesion_factor=[0, 1]' --out soft
$ harness run adhesion_factor --set material=von_mises --uncertainty --out von_mises
  study, --out, --set, --threads, --device, --format
  --workers N: cases that run at a time, each in its own process; default: number of cores divided
    by --threads
  --dask ADDRESS: run on the Dask cluster whose scheduler has this address
  --snapshots LIST: store the soil of each case for `harness view` at these penetrations, in cone
    radii, such as 5,10
  --uncertainty: measure the uncertainty of each cone or resistance factor by further runs; this
    takes some ten times as long; same as --set uncertainty=measured
  --fresh: run all cases again, completed ones too
  --case-timeout SECONDS: stop a case that computes for longer; default: no limit
  --memory-limit SIZE: memory for all running cases together, such as 8e9 or 8GB; a case that needs
    more than its share is refused; default: 90% of this machine's memory
[status = archive.status] list the cases of a study with their status
List the cases of a study: status, time, and why a case did not complete. Without a study list the
stored results; with a scene list those of that scene.
$ harness status
$ harness status mesh_size
$ harness status my_study.toml --traceback
$ harness status results/mesh_size.nc
  --out, --set
  study [STUDY]: name of a study or scene, a TOML file, or a result; default: all results
  --traceback: print where in the program a case failed
[collect = archive.collect] write the dataset of the cases that are done
Write the dataset of a study from the cases that are done so far. `run` does this at its end.
$ harness collect mesh_size
  study, --out, --set
[clean = archive.clean] remove files that do not belong to a study
Remove files that do not belong to the study as it is now: cases with other parameters, damaged and
half-written files. The files are listed, and you are asked first.
$ harness clean mesh_size
  study, --out, --set
  --yes: remove without asking
[verify = run.verify_scenes] compare scenes with their exact solutions
Run scenes that have an exact solution, and print error, bound and observed order. Checks run in
parallel, one per core. The expected time is printed first; with --quick it is a minute.
$ harness verify --quick
$ harness verify --scene thick_cylinder
$ harness verify --extreme --out checks
  --quick: run only the cheapest check of each scene, and only if it is short; takes a minute
  --scene NAME...: scenes to check; default: all
  --extreme: run the extreme cases instead
  --format
  --out DIR: write dataset, table and picture there
[bench = run.bench] measure what a step costs on this machine
Measure the speed of the simulator on this machine and print tables.
$ harness bench
$ harness bench --set physics=cone --set 'size=[3000, 20000]'
  --out, --set, --device
[references = studies.references] list what results are compared with
List the cone factors of the literature and the bands of experience that a study can be compared
with: formula, range, source, and where the formula was taken from. With ID print one in full. Or
print Nkt of measured sites beside the computed one, and draw field_sites.png.
$ harness references
$ harness references lu_2004
$ harness references --field
  id [ID]: name of one reference or band; default: all
  --field: Nkt of measured sites, before and after the model factor of `harness interpret`
  --out, --format
[compare = results.compare] compare a result with references, or with another result
Print a result beside references or exact solutions. With OTHER compare two results and print the
largest difference of each scalar and curve; 0 is the same bits.
$ harness compare results/adhesion_factor.nc
$ harness compare results/adhesion_factor.nc --format latex
$ harness compare runs/a.nc runs/b.nc --tolerance 1e-6
  file FILE: result of a study, netCDF
  other [OTHER]: another result to compare it with
  --tolerance X: largest relative difference allowed between FILE and OTHER; default: 0
  --format FORM: form of the table: text, the default, markdown, latex, or csv, which has no notes
[plot = results.plot] draw the pictures of a result
Draw the pictures of a result again.
$ harness plot results/adhesion_factor.nc --format pdf
  file FILE: result of a study, netCDF
  --out DIR: folder of the pictures; default: the folder of FILE
  --format
[view = results.view] draw the soil of a case around its penetrometer
Draw the soil around the penetrometer of a case that was run with --snapshots: sections, traction
and a film.
$ harness view results/adhesion_factor.nc
$ harness view results/adhesion_factor.nc --vtk --out seen
  file FILE: file of a case, or result of a study
  case [CASE]: key of the case, if FILE has several
  --out DIR: folder of the pictures; default: the folder of FILE
  --format
  --vtk: also write points, grid and surface for ParaView
[report = results.report] write one HTML page of results
Write one HTML page of results, with their tables and pictures.
$ harness report results/adhesion_factor.nc -o report.html
  file FILE...: result of a study
  -o, --out HTML: file of the page; default: report.html
[recommend = results.show_recommendation] find the cheapest settings for an error
Search the results of a scene for the cheapest settings of the method whose error is at most X in
all cases.
$ harness recommend cone_penetration --error 1%
  scene SCENE: name of a scene, such as cone_penetration
  --error X: largest allowed relative error, such as 1% or 0.01
  --results DIR: folder of results to search; default: results
[interpret = interpret.interpret_site] turn a measured cone test into strength
Turn a measured cone test into undrained shear strength over depth, with its error and the sources
of the error. The site file names the test and what is known of the ground; write one by `harness
new SITE --interpret TEST`. Several tests are shown side by side on one page.
$ harness interpret site.toml
$ harness interpret site.toml --laboratory triaxial.csv --out site
$ harness interpret cpt1.toml cpt2.toml cpt3.toml
$ harness interpret site.toml --sharpen --check
  --out, --format
  site SITE...: TOML file of a test and its ground
  --laboratory CSV: laboratory tests of the site; columns depth [m], strength [kPa], test, and error
  --sharpen: remove the effect of layer borders from the resistance first
  --check: simulate a sounding through the interpreted ground and draw it beside the measured one;
    quick, the default, or standard
[benchmark = run.benchmark] run the open benchmark, or score submissions
Run the cases of the open benchmark and write them as a submission. Or score submissions against
exact values and one another, with a table, a picture and a page: those that ship, and those in DIR.
studies/benchmark/README.md defines the cases.
$ harness benchmark score
$ harness benchmark score my_submissions --against mpm_warp_standard
$ harness benchmark run my_submissions/here --accuracy quick
  --out, --format
  action run|score:
  folder [DIR]: a submission, or a folder of them
  --accuracy: accuracy of a run; default: standard
  --against NAME: submission to compare the others with in cases without an exact value; default:
    mpm_warp_standard
[help = completion.show_help] print the commands, or the options of one
Print the commands, or the options of one.
$ harness help
$ harness help run
  about [COMMAND]:
[completion = completion.completion] set up completion by the Tab key
Print the code by which a shell completes commands, options, studies and scenes with the Tab key.
Put the line of your shell into its start file: ~/.bashrc, ~/.zshrc (after compinit), or for fish
config.fish in ~/.config/fish.
  shell SHELL: bash, zsh, fish
"""


class Option(NamedTuple):
    """An option or an argument of a command."""

    key: str  # command and last name, "run --workers"; only the name if commands share the option
    names: list[str]
    value: str  # placeholder of its value, "" for a flag
    meaning: str


class Help(NamedTuple):
    """The help of a command; examples are without the word harness."""

    function: str
    summary: str
    description: str
    examples: list[str]
    options: list[Option]


def _options(text: str, command: str = "") -> Iterator[Option]:
    for line in re.findall(r"^  \S.*(?:\n    .*)*", text, re.MULTILINE):
        words, colon, meaning = " ".join(line.split()).partition(":")
        if not colon:
            yield from (SHARED[name] for name in words.split(", "))
            continue
        *names, value = words.replace(",", "").split() if " " in words else (words, "")
        yield Option(f"{command} {names[-1]}".strip(), names, value, meaning.strip())


SHARED = {option.key: option for option in _options(SHARED_TEXT)}
HELP = {
    name: Help(
        function,
        summary,
        " ".join(re.findall(r"^\w.*", text, re.MULTILINE)),
        re.findall(r"^\$ harness (.*)", text, re.MULTILINE),
        list(_options(text, name)),
    )
    for name, function, summary, text in re.findall(
        r"^\[(\w+) = (\S+)\] (.+)\n((?:[^\[].*\n)+)", TEXT, re.MULTILINE
    )
}

COMPLETION_LINES = """\
the line of each shell:
  bash  eval "$(harness completion bash)"
  zsh   eval "$(harness completion zsh)"
  fish  harness completion fish | source
"""


def epilog(command: str) -> str:
    """The text below the options of a command: examples, or the lines for each shell."""
    if command == "completion":
        return COMPLETION_LINES
    examples = HELP[command].examples
    heading = "example:" if len(examples) == 1 else "examples:"
    return "\n".join([heading, *(f"  harness {example}" for example in examples)])
