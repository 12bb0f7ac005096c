"""The commands: what the help of each says, and the options that it takes.

Of each command the text has name, function in `harness.cli.commands`, summary, description,
examples after $, and options: ``name VALUE: meaning``. A value in brackets may be left out, one
with dots may be given several times. A line of names alone has options that commands share.
"""

import re
from collections.abc import Iterator
from typing import NamedTuple

SHARED_TEXT = """\
  study STUDY: name of a study, or a TOML file
  subject NAME: of a scene or a study, or a TOML file
  --out DIR: folder of the results; default: results
  --set KEY=VALUE: set a parameter; a list, as in 'KEY=[1, 2]', varies it; repeatable
  --threads N: threads of a case, 1, 2 or 4; the result does not change; default: idle cores help
  --device NAME: cpu, the default, or a GPU: cuda:0, ...
"""
TEXT = """\
[new = studies.new] write a study of your own, to be edited and run
Write the definition of a study into the current folder: a TOML file with all parameters of a scene,
explained, that runs as it stands. Edit it, then run it.
$ harness new my_study
$ harness new my_footing --scene strip_footing
  name NAME: of the study; its file is NAME.toml
  --interpret TEST: write a site file for this measured test: CSV, .gef, .xml (BRO), .ags, SGF
  --scene SCENE: default: cone_penetration
[list = studies.list_names] list studies and scenes
List the studies that ship and all scenes, a line each.
$ harness list
[describe = studies.describe] describe a scene, a study, or a site file
Describe a scene: its parameters with default, unit, meaning and allowed range. Or a study: its
scene, what it varies and fixes, and its cases. Or a site file: its keys, with values and meaning.
$ harness describe cone_penetration
$ harness describe adhesion_factor
$ harness describe my_study.toml
$ harness describe site.toml
  subject
[schema = studies.schema] print a JSON schema of studies or sites, for editors
Print a JSON schema of study files, or of site files, by which editors complete and check them.
$ harness schema
$ harness schema site
  of [KIND]: study, the default, or site: files of `harness interpret`
[plan = studies.show_plan] print what a scene or a study costs, before it runs
Print what a run will cost. For one case: its kernels, arrays, steps and time. For a study of
several: material points, memory, steps and time of each.
$ harness plan cone_penetration
$ harness plan cone_penetration --set cells_per_radius=6
$ harness plan mesh_size
  subject, --set
[run = run.run] run a study; run it again to go on where it stopped
Run the cases of a study, write the dataset, the table and the pictures, and compare them with
references or exact solutions. Cases that are done stay: the same command goes on where it was
stopped.
$ harness run adhesion_factor
$ harness run my_study.toml --workers 2 --out runs
$ harness run adhesion_factor --set rigidity_index=50 --set 'adhesion_factor=[0, 1]' --out soft
$ harness run adhesion_factor --set material=von_mises --uncertainty --out von_mises
  study, --out, --set, --threads, --device
  --workers N: processes, each with a case at a time; default: as many as there are cores, over
    --threads
  --dask ADDRESS: run on the Dask cluster whose scheduler has this address
  --snapshots LIST: keep the soil of each case, for `harness view`, at these penetrations over the
    cone radius, as 5,10
  --uncertainty: measure the uncertainty of each cone or resistance factor by further runs, which
    take some ten times as long; the same as --set uncertainty=measured
  --fresh: run all cases, those that are done too
  --case-timeout SECONDS: end a case that computes for longer; default: no limit
  --memory-limit SIZE: memory that all running cases may take together, as 8e9 or 8GB; a case that
    needs more than its share is refused; default: 90% of this machine's
[status = archive.status] list the cases of a study with their status
List the cases of a study with their status, their time, and why a case did not complete. Without a
study, or with a scene: list the stored results.
$ harness status
$ harness status mesh_size
$ harness status my_study.toml --traceback
$ harness status results/mesh_size.nc
  --out, --set
  study [STUDY]: name of a study, a TOML file, or a result; without it, or with a scene: all results
  --traceback: print the place in the program where a case failed
[collect = archive.collect] write the dataset of the cases that are done
Write the dataset of a study from the cases that are done by now. A run does so itself at its end.
$ harness collect mesh_size
  study, --out, --set
[clean = archive.clean] remove files that are no results of a study
Remove files that are no results of the study as it is now: cases with other parameters, damaged and
half-written files. It lists them and asks first.
$ harness clean mesh_size
  study, --out, --set
  --yes: remove without asking
[rerun = run.rerun_case] run a case again and compare every bit
Run one case again from its file alone, and tell whether every bit is the same.
$ harness rerun results/mesh_size.nc 0123456789abcdef
  file FILE: of a case, or result of a study
  case [CASE]: its key, where FILE has many
  --threads, --device
[verify = run.verify_scenes] compare scenes with their exact solutions
Run scenes that have an exact solution, and print error, bound and observed order. Checks run side
by side, one on a core. The time that is expected is told first; --quick takes a minute.
$ harness verify --quick
$ harness verify --scene thick_cylinder
$ harness verify --extreme --out checks
  --quick: run the cheapest check of each scene alone, where it is short: a minute
  --scene NAME...: default: all
  --extreme: run the extreme cases instead
  --out DIR: write dataset, table and picture there
[bench = run.bench] measure what a step costs on this machine
Measure the speed of the simulator on this machine and print it as tables.
$ harness bench
$ harness bench --set physics=cone --set 'size=[3000, 20000]'
  --out, --set, --device
[references = studies.references] list what results are compared with
List the cone factors of the literature and the bands of experience that a study can be compared
with: formula, range, source, how it is known. With ID: one in full.
$ harness references
$ harness references lu_2004
  id [ID]: name of one reference or band; default: all
[compare = results.compare] compare a result with references, or with another result
Print a result beside references or exact solutions. Or set two results side by side and print the
largest difference of each variable.
$ harness compare results/adhesion_factor.nc
$ harness compare runs/a.nc runs/b.nc --tolerance 1e-6
  file FILE: result of a study, netCDF
  other [OTHER]: a result to set beside it
  --tolerance X: largest relative difference allowed between FILE and OTHER; default: 0
  --standards: cone factors on four meshes or more: their error by the least squares of Eca and
    Hoekstra, beside the uncertainty stated
[plot = results.plot] draw the pictures of a result
Draw the pictures of a result again.
$ harness plot results/adhesion_factor.nc
  file FILE: result of a study, netCDF
  --out DIR: default: the folder of FILE
  --format FORMAT...: png, the default, pdf or svg; several are allowed
[view = results.view] draw the soil of a case around its penetrometer
Draw the soil around the penetrometer of a case that was run with --snapshots: sections, traction
and a film. With --vtk: files for ParaView too.
$ harness view results/adhesion_factor.nc
$ harness view results/adhesion_factor.nc --vtk --out seen
  file FILE: of a case, or result of a study
  case [CASE]: its key, where FILE has many
  --out DIR: default: the folder of FILE
  --vtk: write points, grid and surface for ParaView too
[report = results.report] write one page of HTML on results
Write one page of HTML on results, pictures included.
$ harness report results/adhesion_factor.nc -o report.html
  file FILE...: result of a study
  -o, --out HTML: default: report.html
[recommend = results.show_recommendation] name the cheapest settings for an error
Look through the results of a scene for the cheapest settings of the method whose error is at most X
in all cases.
$ harness recommend cone_penetration --error 1%
  scene SCENE: name of a scene, as cone_penetration
  --error X: largest relative error, as 1% or 0.01
  --results DIR: default: results
[interpret = interpret.interpret_site] turn a measured cone test into strength
Turn a measured cone test into undrained shear strength by depth, with an error and where it comes
from. The site file names the test and what is known of the ground; `harness new SITE --interpret
TEST` writes one. Several tests are set side by side on one page.
$ harness interpret site.toml
$ harness interpret site.toml --laboratory triaxial.csv --out site
$ harness interpret cpt1.toml cpt2.toml cpt3.toml
$ harness interpret site.toml --sharpen --check
  --out
  site SITE...: TOML file of a test and its ground
  --laboratory CSV: strengths to draw beside: columns depth [m] and strength [kPa]
  --sharpen: strength by the resistance without what borders of layers do to it
  --check: simulate the sounding through the ground that was found, beside the measured one; quick,
    the default, or standard
[benchmark = run.benchmark] run the open benchmark, or score submissions
Run the cases of the open benchmark and write them as a submission, or score the submissions of a
folder against exact values and one another: a table, a picture and a page. Without a folder: those
that ship. studies/benchmark/README.md defines the cases.
$ harness benchmark score
$ harness benchmark score my_submissions --against mpm_warp_standard
$ harness benchmark run my_submissions/here --accuracy quick
  --out
  action run|score:
  folder [DIR]: a submission, or a folder of them
  --accuracy: of a run; default: standard
  --against NAME: submission that others are compared with where no exact value is known; default:
    mpm_warp_standard
[help = completion.show_help] print the commands, or the options of one
Print the commands, or the options of one.
$ harness help
$ harness help run
  about [COMMAND]:
[completion = completion.completion] let a shell complete by the Tab key
Print what makes a shell complete commands, options, studies and scenes by the Tab key. Put the line
of your shell into its start file: ~/.bashrc, ~/.zshrc (after compinit), ~/.config/fish/config.fish.
  shell SHELL: bash, zsh, fish
"""


class Option(NamedTuple):
    """An option or an argument: its names, how its value is written, and what it means.

    Its key is its last name; before it stands the command that has it, unless several share it.
    """

    key: str
    names: list[str]
    value: str
    meaning: str


class Help(NamedTuple):
    """What the help of a command says; its examples leave out the program's name."""

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
    """What stands below the options of a command."""
    if command == "completion":
        return COMPLETION_LINES
    examples = HELP[command].examples
    heading = "example:" if len(examples) == 1 else "examples:"
    return "\n".join([heading, *(f"  harness {example}" for example in examples)])
