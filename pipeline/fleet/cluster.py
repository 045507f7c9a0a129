"""All sessions of a fleet on Dask, by worker processes of this machine."""

import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import islice
from typing import TYPE_CHECKING

from pipeline.errors import BUG, ConfigError
from pipeline.fleet.record import SessionRecord
from pipeline.fleet.table import rows_of_failure
from pipeline.fleet.worker import FleetTask, work_on
from pipeline.text.names import DISTRIBUTION

if TYPE_CHECKING:
    from distributed import Client, Future

TASKS_PER_WORKER = 4
"""Sessions handed over for each worker at a time, so that Dask holds dozens of a million; derived:
one running, and enough waiting while the next is handed over."""

OnRecord = Callable[[SessionRecord], None]


@contextmanager
def connected(workers: int) -> "Iterator[Client]":
    """A client of ``workers`` processes of this machine.

    Raises
    ------
    ConfigError
        Dask is not installed here.
    """
    try:
        from distributed import Client, LocalCluster
    except ImportError as error:
        raise ConfigError(
            f"`pipeline fleet` runs on Dask, which is not installed. Type: pip install "
            f"'{DISTRIBUTION}[fleet]'"
        ) from error
    with (
        LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=":0",
                     silence_logs=logging.CRITICAL) as cluster,
        Client(cluster) as client,
    ):
        yield client


def run_fleet(client: "Client", tasks: Sequence[FleetTask], on_record: OnRecord) -> None:
    """Work on every task; ``on_record`` receives each record as soon as it is there.

    A worker that is lost leaves its session to another one. A session at which several workers were
    lost, or one that shows a bug, has a record of its own with the exit code 1; it is not kept, so
    that the next run tries it again.
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
