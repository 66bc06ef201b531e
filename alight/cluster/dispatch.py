"""The client's side: tasks go out, answers come in, each task counts once.

::

    while tasks are left:
        look at the cluster: threads, and whether it is still there
        submit until every thread has two tasks
        take the answers that came, checked; release them
        submit those again that failed or are late

Dask decides which worker a task runs on, except that a worker that was refused gets none, and that
a task that is late is issued again to another worker than the one that has it. Its first answer
counts, others are dropped.
"""

from __future__ import annotations

import itertools
import logging
import queue
import threading
import time
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from alight.cluster.issues import Arrived, Issue, Patience
from alight.cluster.worker import (
    Answer,
    Asked,
    Lack,
    Refusal,
    Shared,
    machine_here,
    perform,
    receive,
)
from alight.core.errors import AlightError
from lanewise.machine import describe_machine, differing, fingerprint, target

if TYPE_CHECKING:
    from distributed import Client, Future

_LOG = logging.getLogger("alight")

#: Tasks for each thread: one that runs, and one that waits in its worker.
AHEAD = 2

#: A task that has failed so often is not sent again.
MOST_FAILURES = 3

#: Copies of one task that may be on their way.
_COPIES = 3

#: Seconds between two looks at the cluster, and for which one answer is waited for.
_LOOK, _TICK = 1.0, 0.1

#: Threads that fetch and check answers.
_FETCHERS = 4


class Dispatcher:
    """Hands tasks to the workers of a cluster, and their answers to the caller's thread.

    Parameters
    ----------
    client : distributed.Client
    function : callable
        Of the shared object and a task; pure, and of a module.
    thing : object
        What all tasks share.
    check : callable
        Of a task and what `function` gave for it: gives the value, or raises an error.
    patience : Patience, optional

    Attributes
    ----------
    counts : Counter of str
        Tasks, those issued again, failed answers, tasks done here.
    workers : dict of str to Counter
        By address: tasks and seconds.
    refused : dict of str to str
        By address: why.
    """

    def __init__(
        self,
        client: Client,
        function: Callable[[Any, Any], Any],
        thing: Any,
        check: Callable[[Any, Any], Any],
        patience: Patience | None = None,
    ) -> None:
        self._client: Any = client
        self._function, self._thing, self._check = function, thing, check
        self._patience = patience or Patience()
        self._shared, self._asked = Shared(thing), Asked(target(), fingerprint())
        self.counts: Counter[str] = Counter(shared_bytes=len(self._shared.data))
        self.workers: dict[str, Counter[str]] = {}
        self.refused: dict[str, str] = {}
        self._lacking: set[str] = set()
        self._threads: dict[str, int] = {}
        self._numbers, self._latency, self._shares = itertools.count(), 0.0, False
        self._answers: queue.SimpleQueue = queue.SimpleQueue()
        self._looked, self._seen = -_LOOK, time.perf_counter()
        self._issues: dict[int, Issue] = {}
        self._fetchers = ThreadPoolExecutor(_FETCHERS)
        # A scene that takes its time keeps no answer waiting.
        self._carriers = ThreadPoolExecutor(_FETCHERS)

    def open(self) -> None:
        """Wait for a worker, and give all of them what tasks share.

        Raises
        ------
        AlightError
            If there is none.
        """
        with suppress(TimeoutError, OSError):
            self._client.wait_for_workers(1, timeout=self._patience.cluster)
        self._look()
        if not self._threads:
            raise AlightError("the cluster has no workers")
        self._probe()
        self._shares = True
        # One that is out of reach is brought it when it is given a task.
        try:
            self._client.sync(
                self._client._register_worker_plugin, plugin=self._shared,
                name=self._shared.name, idempotent=True, callback_timeout=self._patience.cluster,
            )  # fmt: skip
        except OSError:
            pass
        except Exception as error:
            # That of a worker which is refused; the others have it.
            if not self.refused:
                raise AlightError(f"the workers do not take the scene: {error}") from error

    def _probe(self) -> None:
        """Refuse workers that cannot run a function of alight: it is not installed, or another."""
        found: dict[str, Any] = {}
        # One that is stopped does not answer; its tasks are issued again.
        with suppress(TimeoutError):
            found = self._client.sync(
                self._client._run, machine_here, self._asked.target, on_error="return",
                callback_timeout=self._patience.fetch,
            )  # fmt: skip
        for worker, answer in found.items():
            if isinstance(answer, Exception):
                self._refused(worker, f"{type(answer).__name__}: {answer}")

    def close(self) -> None:
        """Let the workers forget what tasks shared, if they were given it."""
        for threads in (self._fetchers, self._carriers):
            threads.shutdown(wait=False, cancel_futures=True)
        if not self._shares:
            return
        with suppress(Exception):
            self._client.sync(
                self._client._unregister_worker_plugin, name=self._shared.name,
                callback_timeout=self._patience.task,
            )  # fmt: skip

    @property
    def threads(self) -> int:
        """Threads of all workers that are not refused."""
        return sum(n for worker, n in self._threads.items() if worker not in self.refused)

    def run(
        self,
        draw: Callable[[], Any],
        take: Callable[[Any, Any, float], None],
        cancel: threading.Event,
        report: Callable[[], None],
    ) -> list[Any]:
        """Hand out tasks until there are no more.

        Parameters
        ----------
        draw : callable
            Gives the next task, None at the end.
        take : callable
            Takes a task, its checked value, and the seconds that a worker's thread needed.
        cancel : Event
            Ends this early; what is on its way is dropped.
        report : callable
            Called often.

        Returns
        -------
        list
            Tasks drawn and not answered because the cluster is lost, mostly none; more may remain.

        Raises
        ------
        AlightError
            If every worker is refused.
        """
        issues = self._issues
        try:
            while not cancel.is_set():
                if self._is_lost():
                    return [issue.task for issue in issues.values()]
                while len(issues) < AHEAD * self.threads and (task := draw()) is not None:
                    number = next(self._numbers)
                    issues[number] = Issue(number, task)
                    self._submit(issues[number])
                if not issues and self.threads:
                    return []
                self._collect(take)
                self._reissue()
                report()
            return []
        finally:
            for number in list(issues):
                self._forget(number)

    # ------------------------------------------------------------------------ the cluster

    def _look(self) -> None:
        now = time.perf_counter()
        if now - self._looked < _LOOK:
            return
        with suppress(Exception):
            self._threads = self._client.sync(
                self._client.scheduler.ncores, callback_timeout=self._patience.fetch
            )
            if self.threads:
                self._seen = time.perf_counter()
        self._looked = time.perf_counter()

    def _is_lost(self) -> bool:
        """Whether nothing can be expected from the cluster any more."""
        self._look()
        if self._threads and not self.threads and not self.workers:
            raise AlightError("every worker is refused\n" + "\n".join(
                f"  {worker}: {why}" for worker, why in self.refused.items()
            ))  # fmt: skip
        lost = time.perf_counter() - self._seen > self._patience.cluster
        if lost or self._client.status in ("closed", "closing"):
            _LOG.warning("the cluster is lost; rendering goes on without it")
            return True
        return False

    def _refuse(self, refusal: Refusal) -> None:
        found = differing(refusal.machine, describe_machine())
        self._refused(refusal.worker, "; ".join(found) or "its fingerprint is another one")

    def _refused(self, worker: str, why: str) -> None:
        if worker not in self.refused:
            # Others may be looking at it.
            self.refused = {**self.refused, worker: why}
            _LOG.warning("the worker %s is refused: %s", worker, why)

    def _lacks(self, worker: str) -> None:
        if worker not in self._lacking:
            self._lacking.add(worker)
            self._carriers.submit(self._bring, worker)

    def _bring(self, worker: str) -> None:
        """Give one worker what tasks share; it gets no tasks meanwhile."""
        try:
            self._client.sync(
                self._client._run, receive, self._shared, workers=[worker],
                callback_timeout=self._patience.cluster,
            )  # fmt: skip
        except Exception as error:
            self._refused(worker, f"it does not take the scene: {error!r}")
        finally:
            self._lacking.discard(worker)

    # ------------------------------------------------------------------------ tasks

    def _submit(self, issue: Issue, without: frozenset[str] = frozenset()) -> None:
        unwanted = without | self.refused.keys() | self._lacking
        allowed = [worker for worker in self._threads if worker not in unwanted]
        if (unwanted and not allowed) or self._client.status != "running":
            return  # It is late from now on, or the cluster is lost.
        future = self._client.submit(
            perform, self._function, self._shared.called, self._asked, issue.task,
            key=f"{self._shared.name}-{issue.number}-{next(self._numbers)}",
            pure=False, workers=allowed if unwanted else None,
        )  # fmt: skip
        issue.futures.append(future)
        issue.since = time.perf_counter()

        def done(future: Future) -> None:
            # After the end nobody fetches.
            with suppress(RuntimeError):
                self._fetchers.submit(self._fetch, issue.number, issue.task, future)

        future.add_done_callback(done)

    def _fetch(self, number: int, task: Any, future: Future) -> None:
        if number not in self._issues:
            return
        answer = value = error = None
        try:
            answer = future.result(timeout=self._patience.fetch)
            if isinstance(answer, Answer):
                value = self._check(task, answer.value)
            elif not isinstance(answer, Refusal | Lack):
                raise TypeError(f"a worker answered with {type(answer).__name__}")
        except BaseException as raised:
            error = raised
        self._answers.put(Arrived(number, future, answer, value, error))

    def _collect(self, take: Callable[[Any, Any, float], None]) -> None:
        """Wait a moment for an answer, and take all that are there."""
        with suppress(queue.Empty):
            arrived = self._answers.get(timeout=_TICK)
            while True:
                self._arrived(arrived, take)
                arrived = self._answers.get_nowait()

    def _arrived(self, arrived: Arrived, take: Callable[[Any, Any, float], None]) -> None:
        number, future, answer, value, error = arrived
        issue = self._issues.get(number)
        if issue is None or future not in issue.futures:
            # A copy's; the first answer has been taken.
            return
        issue.futures.remove(future)
        future.release()
        if error is not None:
            self._failed(number, issue, error, take)
        elif isinstance(answer, Refusal):
            self._refuse(answer)
            self._submit(issue)
        elif isinstance(answer, Lack):
            self._lacks(answer.worker)
            self._submit(issue)
        else:
            latency = time.perf_counter() - issue.since
            self._latency = max(latency, 0.9 * self._latency)
            of_worker = self.workers.setdefault(answer.worker, Counter())
            of_worker.update(tasks=1, seconds=answer.seconds)
            self._finish(number, issue, value, answer.seconds, take)

    def _failed(self, number: int, issue: Issue, error: BaseException, take: Any) -> None:
        from distributed import KilledWorker

        if self._client.status != "running":
            # No fault of the task: it is left for later, as the look at the cluster decides.
            return
        issue.failures += MOST_FAILURES if isinstance(error, KilledWorker) else 1
        self.counts["failed"] += 1
        _LOG.warning("a task failed on the cluster: %s: %s", type(error).__name__, error)
        if issue.failures < MOST_FAILURES:
            if not issue.futures:
                self._submit(issue)
            return
        _LOG.warning("it failed %d times and is rendered here", MOST_FAILURES)
        self.counts["done here"] += 1
        begin = time.perf_counter()
        value = self._check(issue.task, self._function(self._thing, issue.task))
        self._finish(number, issue, value, time.perf_counter() - begin, take)

    def _finish(self, number: int, issue: Issue, value: Any, seconds: float, take: Any) -> None:
        self.counts["tasks"] += 1
        self._forget(number)
        take(issue.task, value, seconds)

    def _forget(self, number: int) -> None:
        """Release everything of a task; copies that still run are cancelled."""
        for future in self._issues.pop(number).futures:
            with suppress(Exception):
                future.cancel()

    def _reissue(self) -> None:
        """Send what is late to another worker."""
        now = time.perf_counter()
        limit = max(self._patience.task, self._patience.times * self._latency)
        late = [
            one for one in self._issues.values()
            if now - one.since > (limit if one.futures else _LOOK)
        ]  # fmt: skip
        if not late:
            return
        places: dict[str, Any] = {}
        with suppress(Exception):
            places = self._client.sync(
                self._client.scheduler.processing, callback_timeout=self._patience.fetch
            )
        for issue in late:
            issue.since = now
            if len(issue.futures) >= _COPIES:
                continue
            keys = {future.key for future in issue.futures}
            self.counts["issued again"] += 1
            self._submit(issue, frozenset(w for w, held in places.items() if keys & set(held)))
