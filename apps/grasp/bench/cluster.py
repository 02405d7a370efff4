"""Run scenes on an existing Dask cluster."""

from __future__ import annotations

import asyncio
import logging
import re
import secrets
import threading
from collections.abc import Generator, Mapping, Sequence
from typing import Any

from eyehand.errors import DeviceError, InputError

from .jobs import RunTrial, SceneJob, SceneOutcome, attempt

CONNECT_S = 10.0
"""Time limit for the answer of the scheduler, s."""
ADDRESS = re.compile(r"(?:tcp|tls|wss?)://([^\s:/\[\]]+|\[[0-9a-f:]+\]):(\d{1,5})/?")
"""scheme://host:port. The host may be an IPv6 address in brackets."""
_ONE_AT_A_TIME = threading.Lock()
"""Workers may have several threads, but a process has one renderer."""


def run_on_cluster(
    jobs: Sequence[SceneJob], run: RunTrial, address: str, *, connect: float = CONNECT_S
) -> Generator[tuple[SceneJob, SceneOutcome]]:
    """Run all scenes on the workers of a cluster and yield each with its outcome as it finishes.

    The workers need the same version of eyehand. If a worker dies, the scheduler repeats its
    scene up to `allowed-failures` times. Closing the generator cancels the remaining scenes.

    Parameters
    ----------
    jobs
        Scenes to run.
    run
        Function that runs a scene, from a module that the workers can import.
    address
        Address of the scheduler, ``tcp://host:8786``.
    connect
        Time limit for its answer, s.

    Raises
    ------
    InputError
        If `distributed` is not installed, the address is invalid, or no scheduler answers.
    DeviceError
        If the connection to the scheduler is lost.
    """
    check_address(address)
    try:
        from distributed import Client, as_completed
    except ImportError as error:
        raise InputError(
            "--cluster needs the package distributed: install it with "
            "pip install 'eyehand[cluster]'"
        ) from error
    # Its loggers write tracebacks of errors that are reported here in one line.
    for name in ("distributed", "distributed.client", "distributed.utils", "distributed.core"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    # A refused client does not close cleanly. Test the connection first.
    try:
        asyncio.run(_test_connection(address, connect))
        client = Client(address, timeout=connect, set_as_default=False)
    except (OSError, ValueError, TypeError, RuntimeError, TimeoutError) as error:
        raise InputError(
            f"--cluster {address}: no scheduler answers there within {connect:g} s "
            f"({' '.join(str(error).split())}), expected something like tcp://host:8786"
        ) from error
    with client:
        # Unique keys per run: a scheduler returns old results under a known key.
        run_name = secrets.token_hex(4)
        futures: dict[Any, SceneJob] = {
            client.submit(
                _on_worker, run, dict(job.trial), key=f"eyehand-{run_name}-{job.key}", pure=False
            ): job
            for job in jobs
        }
        try:
            for future in as_completed(list(futures), loop=client.loop):
                job, outcome = futures.pop(future), _outcome(future, address)
                # Release the result: the scheduler computes held results again when a worker dies.
                future.release()
                yield job, outcome
        finally:
            client.cancel(list(futures), force=True)


async def _test_connection(address: str, seconds: float) -> None:
    """Connect with the security settings of this machine, and disconnect."""
    from distributed.comm.core import connect
    from distributed.security import Security

    keys = Security().get_connection_args("client")
    comm = await connect(address, timeout=seconds, **keys)
    await comm.close()


def check_address(address: str) -> None:
    """Raise an `InputError` if the address is invalid. A client with such an address would hang."""
    found = ADDRESS.fullmatch(address)
    if found is None or not 0 < int(found[2]) < 2**16:
        raise InputError(
            f"--cluster {address}: not an address, expected something like tcp://host:8786"
        )


def _on_worker(run: RunTrial, trial: Mapping[str, Any]) -> SceneOutcome:
    with _ONE_AT_A_TIME:
        return attempt(run, trial)


def _outcome(future: Any, address: str) -> SceneOutcome:
    # If a worker died with its result, this waits until the scene has run again.
    error = future.exception()
    if future.cancelled():
        raise DeviceError(
            f"the scheduler at {address} is gone; finished scenes are stored, the same "
            "command continues"
        )
    if error is not None:
        # Scenes catch their own exceptions. This one is about workers that died.
        return SceneOutcome(lost=f"{type(error).__name__}: {' '.join(str(error).split())}")
    return future.result()
