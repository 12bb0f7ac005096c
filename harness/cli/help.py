"""What the help of each command says: a sentence or two on what it does, and examples."""

import re
from typing import NamedTuple

TEXT = """\
[new] write a study of your own, to be edited and run
Write the definition of a study into the current folder: a TOML file with all parameters of a scene,
explained, that runs as it stands. Edit it, then run it.
    new my_study
    new my_footing --scene strip_footing
[run] run a study; run it again to go on where it stopped
Run the cases of a study, write the dataset, the table and the pictures, and compare them with
references or exact solutions. Cases that are done stay: the same command goes on where it was
stopped.
    run adhesion_factor
    run my_study.toml --workers 2 --out runs
    run adhesion_factor --set rigidity_index=50 --set 'adhesion_factor=[0, 1]' --out soft
    run adhesion_factor --set material=von_mises --uncertainty --out von_mises
[status] list the cases of a study with their status
List the cases of a study with their status, their time, and why a case did not complete. Without a
study, or with a scene: list the stored results.
    status
    status mesh_size
    status my_study.toml --traceback
    status results/mesh_size.nc
[collect] write the dataset of the cases that are done
Write the dataset of a study from the cases that are done by now. A run does so itself at its end.
    collect mesh_size
[clean] remove files that are no results of a study
Remove files that are no results of the study as it is now: cases with other parameters, damaged and
half-written files. It lists them and asks first.
    clean mesh_size
[rerun] run a case again and compare every bit
Run one case again from its file alone, and tell whether every bit is the same.
    rerun results/mesh_size.nc 0123456789abcdef
[list] list studies and scenes
List the studies that ship and all scenes, a line each.
    list
[describe] describe a scene, a study, or a site file
Describe a scene: its parameters with default, unit, meaning and allowed range. Or a study: its
scene, what it varies and fixes, and its cases. Or a site file: its keys, with values and meaning.
    describe cone_penetration
    describe adhesion_factor
    describe my_study.toml
    describe site.toml
[schema] print a JSON schema of studies or sites, for editors
Print a JSON schema of study files, or of site files, by which editors complete and check them.
    schema
    schema site
[plan] print what a scene or a study costs, before it runs
Print what a run will cost. For one case: its kernels, arrays, steps and time. For a study of
several: material points, memory, steps and time of each.
    plan cone_penetration
    plan cone_penetration --set cells_per_radius=6
    plan mesh_size
[verify] compare scenes with their exact solutions
Run scenes that have an exact solution, and print error, bound and observed order. Checks run side
by side, one on a core. The time that is expected is told first; --quick takes a minute.
    verify --quick
    verify --scene thick_cylinder
    verify --extreme --out checks
[bench] measure what a step costs on this machine
Measure the speed of the simulator on this machine and print it as tables.
    bench
    bench --set physics=cone --set 'size=[3000, 20000]'
[interpret] turn a measured cone test into strength
Turn a measured cone test into undrained shear strength by depth, with an error and where it comes
from. The site file names the test and what is known of the ground; `harness new SITE --interpret
TEST` writes one. Several tests are set side by side on one page.
    interpret site.toml
    interpret site.toml --laboratory triaxial.csv --out site
    interpret cpt1.toml cpt2.toml cpt3.toml
    interpret site.toml --sharpen --check
[benchmark] run the open benchmark, or score submissions
Run the cases of the open benchmark and write them as a submission, or score the submissions of a
folder against exact values and one another: a table, a picture and a page. Without a folder: those
that ship. studies/benchmark/README.md defines the cases.
    benchmark score
    benchmark score my_submissions --against mpm_warp_standard
    benchmark run my_submissions/here --accuracy quick
[references] list what results are compared with
List the cone factors of the literature and the bands of experience that a study can be compared
with: formula, range, source, how it is known. With ID: one in full.
    references
    references lu_2004
[compare] compare a result with references, or with another result
Print a result beside references or exact solutions. Or set two results side by side and print the
largest difference of each variable.
    compare results/adhesion_factor.nc
    compare runs/a.nc runs/b.nc --tolerance 1e-6
[plot] draw the pictures of a result
Draw the pictures of a result again.
    plot results/adhesion_factor.nc
[view] draw the soil of a case around its penetrometer
Draw the soil around the penetrometer of a case that was run with --snapshots: sections, traction
and a film. With --vtk: files for ParaView too.
    view results/adhesion_factor.nc
    view results/adhesion_factor.nc --vtk --out seen
[report] write one page of HTML on results
Write one page of HTML on results, pictures included.
    report results/adhesion_factor.nc -o report.html
[recommend] name the cheapest settings for an error
Look through the results of a scene for the cheapest settings of the method whose error is at most X
in all cases.
    recommend cone_penetration --error 1%
[help] print the commands, or the options of one
Print the commands, or the options of one.
    help
    help run
[completion] let a shell complete by the Tab key
Print what makes a shell complete commands, options, studies and scenes by the Tab key. Put the line
of your shell into its start file: ~/.bashrc, ~/.zshrc (after compinit), ~/.config/fish/config.fish.
"""


class Help(NamedTuple):
    """What the help of a command says; its examples leave out the program's name."""

    summary: str
    description: str
    examples: tuple[str, ...]


HELP = {
    name: Help(
        summary,
        " ".join(line for line in text.splitlines() if not line.startswith(" ")),
        tuple(line.strip() for line in text.splitlines() if line.startswith(" ")),
    )
    for name, summary, text in re.findall(r"^\[(\w+)\] (.+)\n((?:[^\[].*\n)+)", TEXT, re.MULTILINE)
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
