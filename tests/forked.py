"""waypointctl as a process of its own that starts at once: forked from one that has loaded its modules.

The server has one thread and runs nothing itself. A forked process has its own file descriptors, environment, folder
and signals, and runs `main()` as the installed program does; only the time that its imports take is saved.
"""

from __future__ import annotations

import atexit
import importlib
import json
import os
import select
import signal
import socket
import subprocess
import sys
import traceback
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import cache
from pathlib import Path
from types import FrameType
from typing import IO, Any, Final, Self

_PRELOADED: Final = (
    "onnxruntime",
    "waypointctl.cli.app",
    "waypointctl.cli.replay",
    "waypointctl.cli.run_many",
    "waypointctl.cli.study",
    "waypointctl.cli.tui.playback",
    "waypointctl.cli.tui.summary",
    "waypointctl.cli.validate",
    "waypointctl.flight.checks.check",
    "waypointctl.replay.resume",
    "waypointctl.replay.verify",
    "waypointctl.studies.rehearsal",
)


class ForkedProgram:
    """A process as `subprocess.Popen` has it, with what tests need of that."""

    def __init__(
        self, arguments: tuple[str, ...], folder: Path, environment: Mapping[str, str], streams: tuple[int | None, ...]
    ) -> None:
        """Start it; each of stdin, stdout and stderr is None (the test's own), PIPE, DEVNULL or a file descriptor."""
        ours: list[IO[bytes] | None] = []
        theirs: list[int] = []
        for number, stream in enumerate(streams):
            if stream == subprocess.PIPE:
                reading, writing = os.pipe()
                ours.append(os.fdopen(writing, "wb", 0) if number == 0 else os.fdopen(reading, "rb"))
                theirs.append(reading if number == 0 else writing)
            else:
                is_null = stream == subprocess.DEVNULL or (stream is None and number == 0)
                given = number if stream is None else stream
                ours.append(None)
                theirs.append(os.open(os.devnull, os.O_RDWR) if is_null else os.dup(given))
        self.stdin, self.stdout, self.stderr = ours
        self._ended, ended = os.pipe()
        self.returncode: int | None = None
        request = {"arguments": arguments, "folder": str(folder), "environment": dict(environment)}
        server = _server()
        socket.send_fds(server, [json.dumps(request).encode() + b"\n"], [*theirs, ended])
        for descriptor in (*theirs, ended):
            os.close(descriptor)
        self.pid = int(server.recv(64))

    def poll(self) -> int | None:
        """Return the exit code, None while it runs."""
        return self.wait(0) if self.returncode is None and _is_readable(self._ended, 0) else self.returncode

    def wait(self, timeout: float) -> int:
        """Wait for its end and return the exit code."""
        if self.returncode is None:
            if not _is_readable(self._ended, timeout):
                raise subprocess.TimeoutExpired("waypointctl", timeout)
            self.returncode = int(os.read(self._ended, 64))
            os.close(self._ended)
        return self.returncode

    def communicate(self, data: bytes = b"", timeout: float = 60) -> tuple[bytes, bytes]:
        """Send `data`, read all it writes and wait for its end."""
        with ThreadPoolExecutor(2) as pool:
            reads = [pool.submit(stream.read if stream else bytes) for stream in (self.stdout, self.stderr)]
            if self.stdin is not None:
                with suppress(BrokenPipeError):
                    self.stdin.write(data)
                self.stdin.close()
            try:
                out, err = (read.result(timeout) for read in reads)
            except TimeoutError:
                self.kill()  # else the reads never end
                raise
        self.wait(timeout)
        self.__exit__()
        return out, err

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for stream in (self.stdin, self.stdout, self.stderr):
            if stream is not None:
                stream.close()

    def send_signal(self, number: int) -> None:
        os.kill(self.pid, number)

    def kill(self) -> None:
        self.send_signal(signal.SIGKILL)


def _is_readable(descriptor: int, timeout: float) -> bool:
    return bool(select.select([descriptor], [], [], timeout)[0])


@cache
def _server() -> socket.socket:
    """Start the server of this test process; it ends with it."""
    ours, theirs = socket.socketpair()
    process = subprocess.Popen(
        [sys.executable, "-c", f"from tests.forked import serve; serve({theirs.fileno()})"],
        pass_fds=[theirs.fileno()],
        stdin=subprocess.DEVNULL,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)},
    )
    theirs.close()

    def end() -> None:
        ours.close()
        process.wait()

    atexit.register(end)
    return ours


def serve(descriptor: int) -> None:
    """Fork a process for each request, until the other end is closed."""
    for module in _PRELOADED:
        importlib.import_module(module)
    running: dict[int, int] = {}  # process -> where its exit code goes

    def report(_: int, __: FrameType | None) -> None:
        with suppress(ChildProcessError):
            while (ended := os.waitpid(-1, os.WNOHANG))[0]:
                pid, status = ended
                os.write(running[pid], str(os.waitstatus_to_exitcode(status)).encode())
                os.close(running.pop(pid))

    connection = socket.socket(fileno=descriptor)
    while True:
        text, descriptors, _, _ = socket.recv_fds(connection, 2**16, 4)
        while text and not text.endswith(b"\n"):
            text += connection.recv(2**16)
        if not text:
            return
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        pid = os.fork()
        if pid == 0:
            connection.close()
            _run(json.loads(text), descriptors)
        for each in descriptors[:3]:
            os.close(each)
        running[pid] = descriptors[3]
        signal.signal(signal.SIGCHLD, report)
        report(0, None)
        connection.send(str(pid).encode())


def _run(request: dict[str, Any], descriptors: list[int]) -> None:
    """Become the requested program; does not return."""
    from waypointctl.cli.main import main

    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    for number, descriptor in enumerate(descriptors[:3]):
        os.dup2(descriptor, number)
    for descriptor in descriptors:
        os.close(descriptor)
    os.chdir(request["folder"])
    os.environ.clear()
    os.environ.update(request["environment"])
    sys.argv = ["waypointctl", *request["arguments"]]
    sys.stdin = os.fdopen(0)
    encoding = os.environ.get("PYTHONIOENCODING")
    sys.stdout = os.fdopen(1, "w", encoding=encoding)
    sys.stderr = os.fdopen(2, "w", 1, encoding, "backslashreplace")
    code: Any = 1
    try:
        main()
    except SystemExit as end:
        code = end.code or 0
    except BaseException:
        traceback.print_exc()
    atexit._run_exitfuncs()
    with suppress(OSError, ValueError):
        sys.stdout.flush()
    os._exit(code)
