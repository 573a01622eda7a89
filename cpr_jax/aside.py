"""Calls in a process of its own, for what would hold up the threads of this one.

matplotlib is Python through and through: beside threads that prepare programs it takes twice as
long, and so do they.
"""

import importlib
import os
import pickle
import pkgutil
import signal
import struct
import subprocess
import sys
from concurrent.futures import Future, ThreadPoolExecutor
from types import TracebackType
from typing import NoReturn

from .collection import uncollected

_HEAD = struct.Struct("<Q")
"""Before each message: how many bytes it has."""


class Aside:
    """A Python process that calls functions, one after the other, while this one goes on.

    To be used in a `with` block, whose end waits for all calls. What they print is seen here, what
    they return is not.

    **Arguments:**

    - `module`: what it imports at once, rather than with the first call.

    **Raises:** `RuntimeError` at the end of the block, where a call has failed.
    """

    def __init__(self, module: str):
        self._module = module

    def __enter__(self) -> "Aside":
        settings = {
            "PYTHONPATH": os.pathsep.join(path for path in sys.path if path),
            "JAX_ENABLE_X64": "1",
            # An accelerator stays with this process.
            "JAX_PLATFORMS": "cpu",
            "MPLBACKEND": "agg",
        }
        command = [sys.executable, "-m", "cpr_jax.aside", self._module]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, env=os.environ | settings)
        # A pipe holds little: nobody is to wait until the calls before are through.
        self._sender = ThreadPoolExecutor(1, thread_name_prefix="cpr_jax-aside")
        self._sent: list[Future] = []
        return self

    def call(self, function: str, *arguments: object) -> None:
        """Calls a function, such as `"package.module:function"`, with copies of the arguments."""
        message = pickle.dumps((function, arguments))
        self._sent.append(self._sender.submit(self._send, _HEAD.pack(len(message)) + message))

    def _send(self, message: bytes) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(message)
        self._process.stdin.flush()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if kind is not None:
            self._process.kill()
        broken = [part.exception() for part in self._sent]
        self._sender.shutdown()
        assert self._process.stdin is not None
        try:
            self._process.stdin.close()
        except BrokenPipeError as gone:
            broken.append(gone)
        code = self._process.wait()
        if kind is None and (code != 0 or any(broken)):
            raise RuntimeError(
                f"A process that calls functions of {self._module} has failed, see above "
                f"(exit code {code})."
            )


def _main() -> NoReturn:
    """What the other process does: it calls what it reads until there is no more."""
    # Who interrupts both from a terminal wants an end, not two tracebacks.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with uncollected():
        importlib.import_module(sys.argv[1])
    source = sys.stdin.buffer
    while len(head := source.read(_HEAD.size)) == _HEAD.size:
        (size,) = _HEAD.unpack(head)
        message = source.read(size)
        if len(message) < size:
            break
        function, arguments = pickle.loads(message)
        pkgutil.resolve_name(function)(*arguments)
    # What an interpreter tidies up at its end takes it half a second.
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(0)


if __name__ == "__main__":
    _main()
