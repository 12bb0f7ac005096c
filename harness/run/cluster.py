"""Run cases on a Dask cluster. Their results are sent here and written to the archive."""

import importlib.util
import logging
import math
import threading
import time
from collections.abc import Sequence
from pathlib import Path

import xarray as xr
from distributed import Client, KilledWorker, as_completed
from distributed.comm.addressing import get_address_host_port
from distributed.security import Security

from harness.archive.case_files import Outcome, is_complete, write_case
from harness.archive.conventions import COMPLETED, CRASHED, FAILED
from harness.errors import HarnessError, in_one_line, tell
from harness.run.pool import Watcher
from harness.run.resources import costliest_first, spoken_time
from harness.run.worker import Result, compute
from harness.study.cases import Case
from mpm_warp.provenance import provenance

PATIENCE = 10.0
"""Seconds to wait for the scheduler's answer."""
WORKER_PATIENCE = 600.0
"""Seconds to wait for another worker if all have died."""
NO_CERTIFICATE = (
    "there is no certificate: set DASK_DISTRIBUTED__COMM__TLS__CA_FILE, "
    "DASK_DISTRIBUTED__COMM__TLS__CLIENT__CERT and DASK_DISTRIBUTED__COMM__TLS__CLIENT__KEY"
)
ONE_AUTHORITY = "; valid certificates of one authority are needed on both sides"

_TURN = threading.Lock()


def compute_in_turn(case: Case) -> Result:
    """Run a case in a worker of the cluster.

    Only one thread of a worker computes at a time; otherwise the memory of a case would include
    that of others.
    """
    with _TURN:
        return compute(case)


def connect(address: str) -> Client:
    """A client of the scheduler at `address`, such as ``tcp://host:8786``; to be closed.

    A worker without this package is refused.
    """
    # Log messages would disturb the progress display; what matters is in the error.
    for name in logging.root.manager.loggerDict:
        if name.startswith(("asyncio", "distributed", "tornado")):
            logging.getLogger(name).setLevel(logging.CRITICAL)
    security = Security()
    try:
        if (
            address.startswith("tls:")
            and security.get_tls_config_for_role("client")["cert"] is None
        ):
            raise HarnessError(f"--dask {address}: {NO_CERTIFICATE}")
        get_address_host_port(address)  # a client would try a malformed address for 20 s
        client = Client(address, security=security, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        reason = " ".join(str(error).split())
        remedy = ONE_AUTHORITY if address.startswith("tls:") else ""
        raise HarnessError(f"--dask {address}: cannot be reached: {reason}{remedy}") from None
    # Such a worker would die of its first case, and the case would wait for another worker.
    packages = client.run(importlib.util.find_spec, "harness")
    if lacking := [worker for worker, package in packages.items() if package is None]:
        client.close()
        raise HarnessError(
            f"--dask {address}: worker {lacking[0]} has no mpm-warp; install it there"
        )
    if not packages:
        tell(f"--dask {address}: there is no worker yet; the cases wait for one")
    return client


def run_on_cluster(cases: Sequence[Case], folder: Path, client: Client, watcher: Watcher) -> None:
    """Run cases on a Dask cluster; each result is written to `folder`, then `watcher` is told.

    If a worker dies, another runs its case again. After several deaths the scheduler gives the case
    up, and it is `crashed`. An exception, such as KeyboardInterrupt, cancels the cases; finished
    results are kept.
    """
    # The scheduler keeps this order. With `pure` a case that failed would not be run again.
    case_of = {
        client.submit(compute_in_turn, case, pure=False): case for case in costliest_first(cases)
    }
    ended = as_completed(list(case_of), loop=client.loop, with_results=True, raise_errors=False)
    while case_of:
        _wait(ended, client, had_worker=len(case_of) < len(cases))
        for future, answer in ended.next_batch():
            case = case_of.pop(future)  # without the future the cluster drops the result
            if isinstance(answer, Result):
                watcher.finished(case, _write(folder, case, answer))
            elif future.status == "error":
                watcher.finished(case, _write(folder, case, _failed(answer[1])))
            else:
                raise HarnessError("the scheduler of the Dask cluster is lost")


def _wait(ended: as_completed, client: Client, *, had_worker: bool) -> None:
    """Wait until a case has ended. There is no limit for the first worker, which may be queued."""
    deadline = math.inf
    while not ended.has_ready():
        time.sleep(0.1)
        count, now = client.scheduler_info(n_workers=0)["n_workers"], time.monotonic()
        had_worker |= count > 0
        if count > 0:
            deadline = math.inf
        elif had_worker and deadline == math.inf:
            deadline = now + WORKER_PATIENCE
            in_words = spoken_time(WORKER_PATIENCE)
            tell(f"all workers of the Dask cluster are gone; the cases wait {in_words} for another")
        elif now > deadline:
            raise HarnessError("the workers of the Dask cluster are lost, and no other has come")


def _write(folder: Path, case: Case, result: Result) -> Outcome:
    """Write a result, unless another run has completed the case meanwhile."""
    if is_complete(folder, case):
        return Outcome(COMPLETED, "by another run")
    # All other provenance is that of the worker.
    here = provenance()
    command = {name: here[name] for name in ("command_line", "history")}
    outcome, dataset = result.outcome, result.dataset.assign_attrs(command)
    write_case(folder, case, dataset, outcome.status, outcome.message, result.fields)
    return outcome


def _failed(error: BaseException) -> Result:
    """The result of a case for which the cluster gave only an error."""
    if isinstance(error, KilledWorker):
        times = error.allowed_failures + 1
        outcome = Outcome(CRASHED, f"each of {times} workers that ran the case died")
    else:
        outcome = Outcome(FAILED, f"on the cluster: {in_one_line(error)}")
    return Result(outcome, xr.Dataset())
