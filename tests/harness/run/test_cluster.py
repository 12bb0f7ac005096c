"""Studies on a Dask cluster: a real scheduler and real workers, some of which are killed."""

import json
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path

import dask.config
import pytest
from distributed import Client

from harness.archive import case_files, netcdf_files, study_files
from harness.cli.main import main
from harness.compare.differences import differing
from harness.run import cluster as cluster_module
from harness.run.worker import compute
from harness.study.study import Study
from tests.conftest import LIMIT, wait_until
from tests.harness.conftest import Refusal, study_in, written

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("in_this_process")]

CASE_COUNT = 20
DEFINITION = f"""
title = "Twenty cases that take a moment"
scene = "stub"

[fixed]
seconds = 0.1

[vary]
number = {list(range(CASE_COUNT))}
"""


class Cluster:
    """A scheduler and workers of one thread each, in processes of their own."""

    def __init__(self, folder: Path, processes: ExitStack, *options: str) -> None:
        self.folder, self.processes = folder, processes
        self.scheduler = self.start("scheduler", "--port", "0", *options)
        told = folder / "scheduler.json"
        wait_until(lambda: told.exists() and told.stat().st_size > 0)
        self.address = json.loads(told.read_text())["address"]

    def add_workers(self, count: int, *options: str) -> list[subprocess.Popen[str]]:
        more = ("--nthreads", "1", "--no-nanny", *options)
        return [self.start("worker", *more) for _ in range(count)]

    def start(self, role: str, *options: str) -> subprocess.Popen[str]:
        where = ("--scheduler-file", str(self.folder / "scheduler.json"), "--no-dashboard")
        command = [sys.executable, "-m", "dask", role, *options, *where]
        return self.processes.enter_context(process(command, stderr=subprocess.DEVNULL))

    def run(self, study: Study, out: Path, *more: str) -> subprocess.Popen[str]:
        """The run of a study on the cluster."""
        options = ["--out", str(out), "--dask", self.address, *more]
        command = [sys.executable, "-m", "harness", "run", str(study.source), *options]
        return self.processes.enter_context(process(command, stderr=subprocess.PIPE))


@contextmanager
def process(command: list[str], stderr: int) -> Iterator[subprocess.Popen[str]]:
    """A process that does not outlive the test."""
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=stderr, text=True) as started:
        try:
            yield started
        finally:
            started.kill()


@pytest.fixture
def cluster(stub_offered: None, tmp_path: Path) -> Iterator[Cluster]:
    (tmp_path / "cluster").mkdir()
    with ExitStack() as processes:
        yield Cluster(tmp_path / "cluster", processes)


@pytest.fixture
def twenty(stub_offered: None, tmp_path: Path) -> Study:
    return study_in(tmp_path, DEFINITION, name="twenty")


def test_given_a_worker_that_comes_late_and_one_that_dies_all_cases_are_run(
    cluster: Cluster, twenty: Study, tmp_path: Path
) -> None:
    out, local = tmp_path / "out", tmp_path / "local"
    run = cluster.run(twenty, out)
    assert run.stderr is not None
    assert run.stderr.readline().endswith(": there is no worker yet; the cases wait for one\n")
    worker, _ = cluster.add_workers(2)
    wait_until(lambda: len(written(twenty, out)) >= 5)
    worker.kill()
    told = run.communicate(timeout=LIMIT)[1]
    assert run.returncode == 0, told
    assert "distributed" not in told
    assert len(written(twenty, out)) == CASE_COUNT

    assert main(["run", str(twenty.source), "--out", str(local)]) == 0
    results = [study_files.read_study(folder / "twenty.nc") for folder in (out, local)]
    assert differing(*results) == []
    case_file = case_files.case_file(case_files.case_folder(out, twenty), twenty.cases[0])
    result = netcdf_files.read_netcdf(case_file)
    assert "--dask" in result.attrs["command_line"]
    assert result.peak_memory > 0


def test_a_scheduler_that_dies_leaves_an_archive_from_which_the_study_goes_on(
    cluster: Cluster, twenty: Study, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    cluster.add_workers(1)
    run = cluster.run(twenty, out)
    wait_until(lambda: len(written(twenty, out)) >= 5)
    cluster.scheduler.kill()
    told = run.communicate(timeout=LIMIT)[1].splitlines()
    assert run.returncode == 2
    assert told[-1] == "harness: the scheduler of the Dask cluster is lost"
    assert [line for line in told if not line.startswith(("harness: ", "["))] == []
    kept = written(twenty, out)
    assert 5 <= len(kept) < CASE_COUNT
    statuses = study_files.read_study(out / "twenty.nc").status.values.tolist()
    assert statuses.count("completed") == len(kept)

    assert main(["run", str(twenty.source), "--out", str(out)]) == 0
    everything = written(twenty, out)
    assert len(everything) == CASE_COUNT
    assert kept.items() <= everything.items()


def test_when_all_workers_are_gone_a_line_says_so_and_the_run_ends_and_goes_on_later(
    cluster: Cluster,
    twenty: Study,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(cluster_module, "WORKER_PATIENCE", 1.0)
    out, (worker,), ended = tmp_path / "out", cluster.add_workers(1), threading.Event()

    def kill() -> None:
        wait_until(lambda: len(list(out.glob("*/cases/*.nc"))) >= 5)
        worker.kill()
        if not ended.wait(20.0):
            cluster.add_workers(1)  # or this test had no end

    threading.Thread(target=kill).start()
    run = ["run", str(twenty.source), "--out", str(out), "--dask", cluster.address]
    code = main(run)
    ended.set()
    assert code == 2
    told = [line for line in capsys.readouterr().err.splitlines() if "workers" in line]
    *gone, lost = told  # a scheduler may take a moment to know that a worker is gone
    wait = "all workers of the Dask cluster are gone; the cases wait 1 s for another"
    assert {line.removeprefix("harness: ") for line in gone} == {wait}
    assert lost == "harness: the workers of the Dask cluster are lost, and no other has come"
    kept = written(twenty, out)
    assert 5 <= len(kept) < CASE_COUNT
    cluster.add_workers(1)
    assert main(run) == 0
    assert kept.items() <= written(twenty, out).items()


def test_a_case_that_kills_workers_crashed(cluster: Cluster, twenty: Study, tmp_path: Path) -> None:
    """After four deaths the scheduler no longer takes the workers for the reason."""
    cluster.add_workers(4)
    run = cluster.run(twenty, tmp_path / "out", "--set", "number=1", "--set", "end=killed")
    told = run.communicate(timeout=LIMIT)[1]
    assert run.returncode == 1, told
    assert "crashed: each of 4 workers that ran the case died" in told


def test_a_worker_without_the_package_is_told_before_a_case_is_given_to_it(
    cluster: Cluster, twenty: Study, tmp_path: Path
) -> None:
    """It would die of the first case, and the case wait for another worker without a word."""
    without = tmp_path / "without.py"
    without.write_text("import sys\nsys.modules['harness'] = None\n")
    cluster.add_workers(1, "--preload", str(without))
    with Client(cluster.address) as client:
        client.wait_for_workers(1, timeout=LIMIT)
    run = cluster.run(twenty, tmp_path / "out")
    (line,) = run.communicate(timeout=LIMIT)[1].splitlines()
    assert run.returncode == 2
    assert line.startswith(f"harness: --dask {cluster.address}: worker tcp://")
    assert line.endswith(" has no mpm-warp; install it there")
    assert not (tmp_path / "out").exists()


REFUSED = {
    "--dask=tcp://127.0.0.1:9": "cannot be reached: Timed out trying to connect to tcp://127.0.0.1:9",
    "--dask=nonsense://x": "cannot be reached: unknown address scheme 'nonsense'",
    "--dask=127.0.0.1:none": "cannot be reached: invalid literal for int() with base 10: 'none'",
    "--dask=tcp://h:1 --case-timeout=5": "--case-timeout is not possible with --dask",
    "--dask=tcp://h:1 --memory-limit=8e9": "--memory-limit apply only to this machine",
    "--dask=tcp://h:1 --workers=2": "argument --workers: not allowed with argument --dask",
}


@pytest.mark.parametrize("options", REFUSED)
def test_what_no_cluster_can_do_is_one_line(
    options: str, twenty: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, refusal: Refusal
) -> None:
    monkeypatch.setattr(cluster_module, "PATIENCE", 0.5)
    run = ["run", str(twenty.source), f"--out={tmp_path / 'out'}", *options.split()]
    assert REFUSED[options] in refusal(run)
    assert not (tmp_path / "out").exists()


def test_without_dask_the_missing_package_is_named(
    small_file: Path, refusal: Refusal, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delitem(sys.modules, "harness.run.cluster")
    monkeypatch.setitem(sys.modules, "distributed", None)
    line = refusal(["run", str(small_file), "--dask", "tcp://h:1"])
    assert line.endswith(": pip install 'mpm-warp[cluster]'")
    assert "distributed" in line


def test_timed_runs_do_not_go_with_a_cluster(small_file: Path, refusal: Refusal) -> None:
    small_file.write_text(
        small_file.read_text(encoding="utf-8") + "[timing]\nrepeats = 2\n", encoding="utf-8"
    )
    line = refusal(["run", str(small_file), "--dask", "tcp://h:1"])
    assert "cases are timed on this machine, without --dask" in line


def test_a_worker_with_another_version_of_the_scene_computes_nothing(twenty: Study) -> None:
    case = twenty.cases[0]
    outcome = compute(replace(case, scene_version=case.scene_version - 1)).outcome
    assert outcome.status == "failed"
    asked, here = case.scene_version - 1, case.scene_version
    assert f"version {asked} of stub is asked for; here is {here}" in outcome.message


def test_tls_without_certificates_is_one_line(small_file: Path, refusal: Refusal) -> None:
    run = ["run", str(small_file), "--dask", "tls://127.0.0.1:9"]
    line = refusal(run)
    assert "--dask tls://127.0.0.1:9: there is no certificate: set DASK_DISTRIBUTED__COMM" in line
    names = ("ca-file", "client.cert", "client.key")
    settings = {f"distributed.comm.tls.{name}": "/nowhere/cert.pem" for name in names}
    with dask.config.set(settings):
        line = refusal(run)
    assert "--dask tls://127.0.0.1:9: cannot be reached: " in line
    assert line.endswith("valid certificates of one authority are needed on both sides")
