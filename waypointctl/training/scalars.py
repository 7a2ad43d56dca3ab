"""Scalars for TensorBoard."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from stable_baselines3.common.logger import Logger, TensorBoardOutputFormat
from torch.utils.tensorboard.writer import SummaryWriter

from waypointctl.errors import OutputError


class _Resumable(TensorBoardOutputFormat):
    """Makes TensorBoard forget what a session that was killed wrote after the checkpoint that training resumes from."""

    def __init__(self, folder: Path, steps: int) -> None:
        self.writer = SummaryWriter(str(folder), purge_step=steps + 1 if steps else None)
        self._is_closed = False


@contextmanager
def scalar_logger(folder: Path, steps: int) -> Iterator[Logger]:
    """Give stable-baselines3's logger, which writes TensorBoard scalars into `folder` from `steps` on.

    Raises:
        OutputError: the folder cannot be written.
    """
    try:
        logger = Logger(str(folder), [_Resumable(folder, steps)])
    except OSError as error:
        raise OutputError(f"the scalars cannot be written: {error.strerror}", where=str(folder)) from error
    try:
        yield logger
    finally:
        logger.close()
