"""Scenes run on a Dask cluster that exists already."""

from __future__ import annotations

import asyncio
import logging
import re
import secrets
import threading
from typing import TYPE_CHECKING, Any

from eyehand.errors import DeviceError, InputError

from .jobs import RunTrial, SceneJob, SceneOutcome, attempt

if TYPE_CHECKING:
    from collections.abc import Generator, Mapping, Sequence

CONNECT_S = 10.0
"""How long the scheduler may take to answer."""
ADDRESS = re.compile(r"(?:tcp|tls|wss?)://([^\s:/\[\]]+|\[[0-9a-f:]+\]):(\d{1,5})/?")
"""scheme://host:port; the host may be an IPv6 address in brackets."""
_ONE_AT_A_TIME = threading.Lock()
"""Workers may have threads; a process has one renderer."""


def run_on_cluster(
    jobs: Sequence[SceneJob], run: RunTrial, address: str, *, connect: float = CONNECT_S
) -> Generator[tuple[SceneJob, SceneOutcome]]:
    """Run all scenes on a cluster's workers, and give each with its outcome as it is done.

    The workers need eyehand in the same version. A scene whose worker died is run again by the
    scheduler, up to its `allowed-failures`; leaving the loop early takes the others back.

    Parameters
    ----------
    jobs
        Scenes.
    run
        Runs one; a function of a module that the workers can import.
    address
        Of the scheduler, ``tcp://host:8786``.
    connect
        Longest wait for it, s.

    Raises
    ------
    InputError
        If `distributed` is not installed, the address is none, or no scheduler answers there.
    DeviceError
        If the scheduler goes away.
    """
    check_address(address)
    try:
        from distributed import Client, as_completed
    except ImportError as error:
        raise InputError(
            "--cluster needs the package distributed: install it with "
            "pip install 'eyehand[cluster]'"
        ) from error
    # Its loggers write tracebacks of what is told here in a line.
    for name in ("distributed", "distributed.client", "distributed.utils", "distributed.core"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    # A client that was refused is never closed in peace: ask without one first.
    try:
        asyncio.run(_meet(address, connect))
        client = Client(address, timeout=connect, set_as_default=False)
    except (OSError, ValueError, TypeError, RuntimeError, TimeoutError) as error:
        raise InputError(
            f"--cluster {address}: no scheduler answers there within {connect:g} s "
            f"({' '.join(str(error).split())}), expected something like tcp://host:8786"
        ) from error
    with client:
        # Keys of this run only: a scheduler gives what it already has under a key.
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
                # What the client still holds is computed again when its worker dies.
                future.release()
                yield job, outcome
        finally:
            client.cancel(list(futures), force=True)


async def _meet(address: str, seconds: float) -> None:
    """Connect as a client of the machine's own settings would, and part."""
    from distributed.comm.core import connect
    from distributed.security import Security

    keys = Security().get_connection_args("client")
    comm = await connect(address, timeout=seconds, **keys)
    await comm.close()


def check_address(address: str) -> None:
    """Raise an `InputError` for what is no scheduler's address: a client of it never ends well."""
    found = ADDRESS.fullmatch(address)
    if found is None or not 0 < int(found[2]) < 2**16:
        raise InputError(
            f"--cluster {address}: not an address, expected something like tcp://host:8786"
        )


def _on_worker(run: RunTrial, trial: Mapping[str, Any]) -> SceneOutcome:
    with _ONE_AT_A_TIME:
        return attempt(run, trial)


def _outcome(future: Any, address: str) -> SceneOutcome:
    # Waits, where a worker took its finished result with it, until that has run again.
    error = future.exception()
    if future.cancelled():
        raise DeviceError(
            f"the scheduler at {address} went away; the scenes that are done are kept, the same "
            "command goes on with the others"
        )
    if error is not None:
        # Scenes catch what they raise: this is the scheduler's word on workers that died.
        return SceneOutcome(lost=f"{type(error).__name__}: {' '.join(str(error).split())}")
    return future.result()
