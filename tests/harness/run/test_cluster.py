"""Studies on a Dask cluster: a real scheduler and real workers, some of which are killed."""

import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import dask.config
import pytest

from harness.archive import case_files, netcdf_files, study_files
from harness.cli.main import main
from harness.compare.differences import differing
from harness.study.study import Study, load_study
from tests.harness.conftest import Refusal, Written

pytestmark = pytest.mark.slow

LIMIT = 120
"""Seconds after which what is waited for does not come."""
CASE_COUNT = 20
DEFINITION = f"""
title = "Twenty cases that take a moment"
scene = "gravity_column"

[fixed]
cell_count = 120

[vary]
poissons_ratio = {[0.4 * i / CASE_COUNT for i in range(CASE_COUNT)]}
"""


class Cluster:
    """A scheduler and workers of one thread each, in processes of their own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.scheduler_file = folder / "scheduler.json"
        self.processes: list[subprocess.Popen[bytes]] = []

    def start(self) -> None:
        self.scheduler = self._start("scheduler", "--port", "0")
        wait_until(self.scheduler_file.exists)
        self.workers = [self.add_worker(), self.add_worker()]

    @property
    def address(self) -> str:
        address: str = json.loads(self.scheduler_file.read_text())["address"]
        return address

    def add_worker(self, *options: str) -> subprocess.Popen[bytes]:
        return self._start("worker", "--nthreads", "1", "--no-nanny", *options)

    def _start(self, role: str, *options: str) -> subprocess.Popen[bytes]:
        process = subprocess.Popen(
            [
                *(sys.executable, "-m", "dask", role, *options),
                *("--scheduler-file", str(self.scheduler_file), "--no-dashboard"),
            ],
            cwd=self.folder,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        self.processes.append(process)
        return process

    def stop(self) -> None:
        for process in self.processes:
            process.kill()
            process.wait()


def wait_until(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + LIMIT
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[Cluster]:
    folder = tmp_path / "cluster"
    folder.mkdir()
    cluster = Cluster(folder)
    try:
        cluster.start()
        yield cluster
    finally:
        cluster.stop()


@pytest.fixture
def twenty(tmp_path: Path) -> Study:
    path = tmp_path / "twenty.toml"
    path.write_text(DEFINITION)
    return load_study(str(path))


@pytest.fixture
def start(cluster: Cluster) -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """Starts the run of a study on the cluster."""
    runs = []

    def started(study: Study, out: Path, *more: str) -> subprocess.Popen[str]:
        options = ["--out", str(out), "--dask", cluster.address, *more]
        run = subprocess.Popen(
            [sys.executable, "-m", "harness", "run", str(study.source), *options],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        runs.append(run)
        return run

    yield started
    for run in runs:
        run.kill()
        run.communicate()


def test_a_worker_that_dies_has_its_case_run_again_elsewhere(
    cluster: Cluster,
    start: Callable[..., subprocess.Popen[str]],
    twenty: Study,
    tmp_path: Path,
    written: Written,
) -> None:
    out, local = tmp_path / "out", tmp_path / "local"
    run = start(twenty, out)
    wait_until(lambda: len(written(twenty, out)) >= 5)
    cluster.workers[0].kill()
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
    cluster: Cluster,
    start: Callable[..., subprocess.Popen[str]],
    twenty: Study,
    tmp_path: Path,
    written: Written,
) -> None:
    out = tmp_path / "out"
    run = start(twenty, out)
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


DEADLY = """
import os, signal
from mpm_warp.scenes.elastic.columns import GravityColumn
GravityColumn.run = lambda *_: os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_case_that_kills_its_workers_is_recorded_as_crashed(
    cluster: Cluster, start: Callable[..., subprocess.Popen[str]], twenty: Study, tmp_path: Path
) -> None:
    """After four deaths the scheduler no longer takes the workers for the reason."""
    deadly = tmp_path / "deadly.py"
    deadly.write_text(DEADLY)
    for worker in cluster.workers:
        worker.kill()
        worker.wait()
    cluster.workers = [cluster.add_worker("--preload", str(deadly)) for _ in range(4)]
    out = tmp_path / "out"
    run = start(twenty, out, "--set", "poissons_ratio=0.3")
    told = run.communicate(timeout=LIMIT)[1]
    assert run.returncode == 1, told
    assert "crashed: each of 4 workers that ran the case died" in told


@pytest.mark.parametrize(
    ("address", "reason"),
    [
        ("tcp://127.0.0.1:9", "Timed out trying to connect to tcp://127.0.0.1:9"),
        ("nonsense://x", "unknown address scheme 'nonsense'"),
        ("127.0.0.1:none", "invalid literal for int() with base 10: 'none'"),
    ],
)
def test_a_scheduler_that_is_not_there_is_one_line(
    address: str, reason: str, twenty: Study, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    script = (
        "import sys, harness.run.cluster as cluster, harness.cli.main as cli\n"
        "cluster.PATIENCE = 0.5\n"
        "sys.exit(cli.main(sys.argv[1:]))"
    )
    run = ["run", str(twenty.source), "--out", str(out), "--dask", address]
    result = subprocess.run(
        [sys.executable, "-c", script, *run],
        capture_output=True,
        text=True,
        check=False,
        timeout=LIMIT,
    )
    assert result.returncode == 2
    (line,) = result.stderr.splitlines()
    assert line.startswith(f"harness: --dask {address}: cannot be reached: {reason}")
    assert not out.exists()


def test_local_workers_and_their_time_limit_do_not_go_with_a_cluster(
    twenty: Study, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    run = ["run", str(twenty.source), "--out", str(out), "--dask", "tcp://127.0.0.1:9"]
    assert main([*run, "--case-timeout", "5"]) == 2
    assert "--case-timeout ends workers of this machine" in capsys.readouterr().err
    with pytest.raises(SystemExit, match="2"):
        main([*run, "--workers", "2"])
    assert "not allowed with argument" in capsys.readouterr().err
    assert not out.exists()


def test_without_dask_the_missing_package_is_named(
    twenty: Study,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delitem(sys.modules, "harness.cluster", raising=False)
    monkeypatch.setitem(sys.modules, "distributed", None)
    run = ["run", str(twenty.source), "--out", str(tmp_path / "out"), "--dask", "tcp://h:1"]
    assert main(run) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.endswith(": pip install 'mpm-warp[cluster]'")
    assert "distributed" in line


def test_timed_runs_do_not_go_with_a_cluster(
    twenty: Study, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    twenty.source.write_text(DEFINITION + "[timing]\nrepeats = 2\n")
    run = ["run", str(twenty.source), "--out", str(tmp_path / "out"), "--dask", "tcp://h:1"]
    assert main(run) == 2
    assert "cases are timed on this machine, without --dask" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_worker_with_another_version_of_the_scene_computes_nothing(twenty: Study) -> None:
    from harness.run.worker import compute

    case = twenty.cases[0]
    older = replace(case, scene_version=case.scene_version - 1)
    outcome = compute(older).outcome
    assert outcome.status == "failed"
    asked, here = older.scene_version, case.scene_version
    assert f"version {asked} of gravity_column is asked for; here is {here}" in outcome.message


def test_tls_without_certificates_is_one_line(small_file: Path, refusal: Refusal) -> None:
    line = refusal(["run", str(small_file), "--dask", "tls://127.0.0.1:9"])
    assert "--dask tls://127.0.0.1:9: there is no certificate: set DASK_DISTRIBUTED__COMM" in line


def test_a_certificate_that_is_not_there_is_one_line(small_file: Path, refusal: Refusal) -> None:
    names = ("ca-file", "client.cert", "client.key")
    settings = {f"distributed.comm.tls.{name}": "/nowhere/cert.pem" for name in names}
    with dask.config.set(settings):
        line = refusal(["run", str(small_file), "--dask", "tls://127.0.0.1:9"])
    assert "cannot be reached: " in line
