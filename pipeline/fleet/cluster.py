"""All sessions of a fleet on Dask: workers of this machine, or those of a scheduler elsewhere."""

import logging
import socket
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import islice
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from pipeline.errors import BUG, ConfigError, DeviceError
from pipeline.fleet.sessions import SessionRecord
from pipeline.fleet.table import rows_of_failure
from pipeline.fleet.worker import FleetTask, work_on
from pipeline.text.names import DISTRIBUTION, program_version

if TYPE_CHECKING:
    from distributed import Client, Future

ANSWER_S = 10.0
"""Longest wait for a scheduler and its first worker, s; on a slow network they take less than one.
Derived: a person waits as long without doubting the command."""

TASKS_PER_WORKER = 4
"""Sessions handed to the cluster for each worker at a time, so that a scheduler holds hundreds of
a million; derived: one running, and enough waiting while the next is handed over."""

OnRecord = Callable[[SessionRecord], None]


@contextmanager
def connected(scheduler: str | None, workers: int) -> "Iterator[Client]":
    """A client of the scheduler at an address, or of ``workers`` processes of this machine.

    Raises
    ------
    ConfigError
        The address is none, or another version runs there.
    DeviceError
        The scheduler does not answer, or has no workers.
    """
    from distributed import Client, LocalCluster

    if scheduler is None:
        with (
            LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=":0",
                         silence_logs=logging.CRITICAL) as cluster,
            Client(cluster) as client,
        ):
            yield client
        return
    client = _answering(scheduler)
    with client:
        _require_workers(client, scheduler)
        yield client


def _answering(scheduler: str) -> "Client":
    """A client of the scheduler at an address; a silent one counts as no answer."""
    from distributed import Client

    try:
        _require_greeting(scheduler)
        return Client(scheduler, timeout=ANSWER_S)
    except OSError as error:
        raise DeviceError(
            f"{scheduler}: no Dask scheduler answers there within {ANSWER_S:.0f} s. Start one with "
            f"`dask scheduler`, check address and port, and that no firewall is between; without "
            f"--scheduler the sessions run on this machine."
        ) from error
    except (ValueError, TypeError, RuntimeError, ImportError) as error:
        raise ConfigError(f"'{scheduler}' is no address of a scheduler ({error}). Expected "
                          f"tcp://HOST:PORT, as `dask scheduler` prints it.") from error


def _require_greeting(scheduler: str) -> None:
    """Wait for the first byte that a scheduler sends to its clients; Dask waits for longer.

    Raises
    ------
    OSError
        Nothing is there, or what is there says nothing.
    """
    address = urlsplit(scheduler if "://" in scheduler else f"tcp://{scheduler}")
    if address.scheme != "tcp" or address.hostname is None or address.port is None:
        return
    with socket.create_connection((address.hostname, address.port), ANSWER_S) as line:
        line.settimeout(ANSWER_S)
        if not line.recv(1):
            raise ConnectionResetError("it hangs up")


def _require_workers(client: "Client", scheduler: str) -> None:
    from distributed import TimeoutError as NoWorker

    try:
        client.wait_for_workers(1, timeout=ANSWER_S)
    except NoWorker as error:
        raise DeviceError(
            f"{scheduler}: the scheduler has no workers. Start some with `dask worker {scheduler} "
            f"--nthreads 1`, on machines that see the same files."
        ) from error
    here = program_version()
    for worker, version in client.run(program_version, on_error="return").items():
        if version != here:
            raise ConfigError(
                f"{worker}: this worker of {scheduler} has version {version} of this program, "
                f"expected {here}. Install the same there: pip install "
                f"'{DISTRIBUTION}[fleet]'"
            )


def run_fleet(client: "Client", tasks: Sequence[FleetTask], on_record: OnRecord) -> None:
    """Work on every task; ``on_record`` receives each record at once.

    The session of a lost worker goes to another one. A session that lost several workers, or that
    shows a bug, has a record of its own with the exit code 1; it is not kept, so that the next run
    tries it again.
    """
    from distributed import as_completed

    ahead = TASKS_PER_WORKER * max(len(client.scheduler_info(n_workers=-1)["workers"]), 1)
    waiting = iter(tasks)
    under_way: dict[str, FleetTask] = {}

    def submit(count: int) -> "list[Future]":
        futures = []
        for task in islice(waiting, count):
            future = client.submit(work_on, task, pure=False)
            under_way[future.key] = task
            futures.append(future)
        return futures

    queue = as_completed(submit(ahead))
    for future in queue:
        on_record(_record_of(future, under_way.pop(future.key)))
        for following in submit(1):
            queue.add(following)


def _record_of(future: "Future", task: FleetTask) -> SessionRecord:
    error = future.exception()
    if error is None:
        record: SessionRecord = future.result()
        return record
    from distributed import KilledWorker

    session = task.session
    reason = (
        "every worker that took this session was lost: killed, or out of memory. Run it alone with "
        "`pipeline run`, or give the workers more memory."
        if isinstance(error, KilledWorker)
        else f"this is our bug, not a fault in the data: {type(error).__name__}: {error}"
    )
    rows = rows_of_failure(session, None, BUG, reason)
    return SessionRecord(session.name, session.sensor, "", BUG, reason, rows)
