"""What the ground knows of the times of its link, and of the robot's time under way on a leg.

A leg that is led from the ground consists of goals. Its time is the time under way: from when a goal of it is STARTED
on board to when that goal has ended, and the same for the next. The time that the robot is stopped between two goals,
or in a hold, is not in it: it waits for the link or the operator. All times are read from the robot's time stamps, in
acknowledgements and in frames of telemetry. Without reports the ground's own clock is used: a leg times out when the
answer to a command sent at its timeout would have arrived.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final

from waypointctl.flight.command_life import NEVER_STARTED
from waypointctl.flight.link.direction import Direction
from waypointctl.flight.operator.requests import CommandRequest
from waypointctl.log.messages import FINAL_STAGES, Ack, Mode, Stage, Telemetry

_STANDING: Final = frozenset({Mode.PAUSED, Mode.SAFE, Mode.WAITING})


ACK_BYTES: Final = 64  # an acknowledgement with a reason of some words


@dataclass(frozen=True, slots=True)
class RetryPolicy:
    """When a command is sent again, and how often."""

    acknowledged: bool  # whether it waits for acknowledgements at all
    retries: int  # how often a command is sent again at most, whatever for
    # Maps when a command's last bit leaves [ns] to when it has to be acknowledged [ns]; None for never, where no
    # contact is left
    answer_by: Callable[[int], int | None]
    patience_ns: int  # how long after a frame that reports a command's end its acknowledgement may still arrive


def answer_time(up: Direction[Any], down: Direction[Any], robot_ns: int, margin_ns: int) -> Callable[[int], int | None]:
    """Return by when a command that leaves at a time [ns] has to be acknowledged: what the ground knows of its link.

    Round trip, jitter, what sending takes both ways and the next contact back are in it; queues on board are not.

    Args:
        up: the direction of commands.
        down: the direction of acknowledgements.
        robot_ns: how long the robot takes to answer at most [ns].
        margin_ns: how much later is still no loss [ns].
    """

    def at(left_ns: int) -> int | None:
        arrives_ns = left_ns + up.delay(left_ns) + _most_jitter_ns(up) + robot_ns
        placed = down.contacts.place(arrives_ns, ACK_BYTES)
        if placed is None:
            return None
        _, back_ns = placed
        return back_ns + down.delay(back_ns) + _most_jitter_ns(down) + margin_ns

    return at


def patience_ns(down: Direction[Any], margin_ns: int) -> int:
    """Return how much later than a frame an acknowledgement that was issued with it may come [ns]."""
    return margin_ns + 2 * _most_jitter_ns(down)


def _most_jitter_ns(way: Direction[Any]) -> int:
    return 0 if way.jitter is None else max(way.jitter.most_ns, 0)


def leaving_time(up: Direction[Any]) -> Callable[[int], int | None]:
    """Return when a command that is sent at a time [ns] leaves: when a contact is open; queues are not known."""

    def at(sent_ns: int) -> int | None:
        placed = up.contacts.place(sent_ns, ACK_BYTES)
        return None if placed is None else placed[1]

    return at


@dataclass(slots=True)
class LegClock:
    """The clock of the leg under way."""

    answer_by: Callable[[int], int | None]  # by when a command that leaves at a time [ns] is answered; None for never
    # When a command that is sent at a time [ns] leaves; None for never
    leaves_ns: Callable[[int], int | None] = lambda sent_ns: sent_ns
    began_ns: int | None = None  # when the leg began, on the robot's clock; None while that is unknown
    _sent_ns: int = 0  # when the leg's first goal is sent
    _reported_ns: int = -1  # the robot's clock, by the newest message of it
    _moved_ns: int = 0  # up to the last stop
    _moving_since_ns: int | None = None  # while a goal is under way
    _changed_ns: int = 0  # when a goal of the leg last began or ended, as far as known
    _newest: int = 0  # the newest goal that has begun
    _ended: int = 0  # the newest goal that has ended
    _unsent: list[CommandRequest] = field(default_factory=list)  # goals of this leg, not sent yet
    _goals: set[int] = field(default_factory=set)  # those sent

    def restart(self, sent_ns: int) -> None:
        """Wait for another leg to begin, or for the same one anew; its first goal is sent at a time [ns]."""
        self.began_ns, self._sent_ns = None, sent_ns
        self._moved_ns, self._moving_since_ns = 0, None
        self._unsent.clear()
        self._goals.clear()

    def include(self, goal: CommandRequest) -> CommandRequest:
        """Record that a request which is to be sent belongs to this leg, and return it."""
        self._unsent.append(goal)
        return goal

    def on_issued(self, command_id: int, request: CommandRequest) -> None:
        """Learn the id of a request that has been sent, of this leg or not."""
        places = [place for place, goal in enumerate(self._unsent) if goal is request]
        if places:
            del self._unsent[: places[0] + 1]  # what was to be sent before it has been dropped
            self._goals.add(command_id)

    def on_message(self, message: Ack | Telemetry) -> None:
        """Take what has arrived."""
        at_ns, is_news = message.issued_ns, message.issued_ns >= self._reported_ns
        self._reported_ns = max(self._reported_ns, at_ns)
        if isinstance(message, Ack):
            self._update(at_ns, message.command_id, message.stage)
            return
        for each in message.commands:
            self._update(at_ns, each.command_id, each.stage)
        if is_news and message.mode in _STANDING:
            self._stop(at_ns)
        elif is_news and message.mode is Mode.NAVIGATING and self._newest in self._goals and self._ended < self._newest:
            self._start(at_ns)

    def is_over(self, timeout_ns: int) -> bool:
        """Return whether the robot is known to have been under way for more than this on the leg [ns]."""
        since_ns = self._moving_since_ns
        return self._moved_ns + (0 if since_ns is None else self._reported_ns - since_ns) > timeout_ns

    def is_silent(self, now_ns: int, timeout_ns: int) -> bool:
        """Return whether a report of the leg is overdue, given its time-out [ns]."""
        since_ns = self.leaves_ns(self._sent_ns) if self.began_ns is None else self._changed_ns
        over_ns = (self._sent_ns if since_ns is None else since_ns) + timeout_ns
        left_ns = self.leaves_ns(over_ns)
        answer_ns = None if left_ns is None else self.answer_by(left_ns)
        return now_ns > (over_ns if answer_ns is None else answer_ns)

    def _update(self, at_ns: int, command_id: int, stage: Stage) -> None:
        """Process a report of a command: a goal of the leg has begun, or has ended."""
        if command_id not in self._goals or stage in NEVER_STARTED or command_id <= self._ended:
            return
        if self.began_ns is None:
            self.began_ns = self._changed_ns = at_ns
        if stage in FINAL_STAGES:
            self._ended = command_id
            if command_id >= self._newest:
                self._newest, self._changed_ns = command_id, at_ns
                self._stop(at_ns)
        elif command_id > self._newest:
            self._newest, self._changed_ns = command_id, at_ns
            self._start(at_ns)

    def _start(self, at_ns: int) -> None:
        if self._moving_since_ns is None:
            self._moving_since_ns = at_ns

    def _stop(self, at_ns: int) -> None:
        if self._moving_since_ns is not None:
            self._moved_ns += max(at_ns - self._moving_since_ns, 0)
            self._moving_since_ns = None
