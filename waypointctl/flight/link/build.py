"""Build a direction of the link from a mission."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

from waypointctl.errors import MissionError
from waypointctl.flight.link.contacts import Contacts, Window, always
from waypointctl.flight.link.direction import Direction, Duplication
from waypointctl.flight.link.impairments import (
    Delay,
    GilbertElliott,
    Jitter,
    Loss,
    RandomLoss,
    drawn_jitter,
    fixed_delay,
    normal_jitter,
    stepped_delay,
    table_delay,
    uniform_jitter,
)
from waypointctl.mission.contact_plan import Passage, read_contact_plan
from waypointctl.mission.link import Bursts, LinkDirection
from waypointctl.mission.text_file import read_jitter
from waypointctl.mission.yaml_source import as_error
from waypointctl.seeding import stream
from waypointctl.units import ns

T = TypeVar("T")


def direction(way: LinkDirection, files: Mapping[str, bytes], seed: int, name: str) -> Direction[T]:
    """Return a direction of the link, with nothing in it.

    Args:
        way: its keys in the mission.
        files: the contents of the files that the mission refers to, by their names in it.
        seed: the mission's.
        name: of its random streams: "link.up" or "link.down".

    Raises:
        MissionError: a file is not among them, or something is wrong with it.
    """
    passage = _passage(way, files)
    return Direction(
        delay=_delay(way, passage),
        jitter=_jitter(way, files, seed, name, ".jitter"),
        keeps_order=way.keep_order,
        loss=_loss(way, seed, name),
        duplication=_duplication(way, files, seed, name),
        contacts=_contacts(way, passage),
        queue_bytes=int(way.queue_bytes),
    )


def contacts_and_delay(way: LinkDirection, files: Mapping[str, bytes]) -> tuple[Contacts, Delay]:
    """Return when, and how fast, something can be sent one way, and its delay; raises MissionError as `direction`."""
    passage = _passage(way, files)
    return _contacts(way, passage), _delay(way, passage)


def contacts_of(way: LinkDirection, files: Mapping[str, bytes]) -> Contacts:
    """Return when, and how fast, something can be sent one way; raises MissionError as `direction` does."""
    return _contacts(way, _passage(way, files))


def _passage(way: LinkDirection, files: Mapping[str, bytes]) -> Passage | None:
    plan = way.contact_plan
    if plan is None:
        return None
    passage, problems = read_contact_plan(
        _content(files, plan.file),
        plan.file,
        plan.way,
        reference=plan.reference,
        needs_ranges=not way.has_own_delay,
    )
    if problems:
        raise as_error(problems, MissionError)
    return passage


def _content(files: Mapping[str, bytes], name: str) -> bytes:
    if name not in files:
        raise MissionError("the mission refers to it, and it was not read with it", where=name)
    return files[name]


def _delay(way: LinkDirection, passage: Passage | None) -> Delay:
    if way.delay_table is not None:
        return table_delay([(ns(row.at_s), ns(row.delay_s)) for row in way.delay_table])
    if passage is not None and not way.has_own_delay:
        return stepped_delay([(ns(each.begin_s), ns(each.value)) for each in passage.ranges])
    return fixed_delay(ns(way.delay_s))


def _jitter(way: LinkDirection, files: Mapping[str, bytes], seed: int, name: str, which: str) -> Jitter | None:
    if way.jitter_file is not None:
        samples, problems = read_jitter(_content(files, way.jitter_file), way.jitter_file)
        if problems:
            raise as_error(problems, MissionError)
        return drawn_jitter([ns(sample) for sample in samples], stream(seed, name + which))
    if not way.jitter_s:
        return None
    if way.jitter_distribution == "normal":
        return normal_jitter(ns(way.jitter_s), stream(seed, name + which))
    # The oldest of the streams goes by the way's own name.
    return uniform_jitter(ns(way.jitter_s), stream(seed, name if which == ".jitter" else name + which))


def _loss(way: LinkDirection, seed: int, name: str) -> Loss | None:
    if isinstance(way.loss, Bursts):
        loss = way.loss
        return GilbertElliott(loss.p, loss.r, loss.one_minus_h, loss.one_minus_k, stream(seed, f"{name}.loss"))
    return RandomLoss(way.loss, stream(seed, f"{name}.loss")) if way.loss else None


def _duplication(way: LinkDirection, files: Mapping[str, bytes], seed: int, name: str) -> Duplication | None:
    if not way.duplicate:
        return None
    choose = RandomLoss(way.duplicate, stream(seed, f"{name}.duplicate"))
    return Duplication(choose, _jitter(way, files, seed, name, ".second"))


def _contacts(way: LinkDirection, passage: Passage | None) -> Contacts:
    if passage is not None:
        return Contacts([Window(ns(each.begin_s), ns(each.end_s), each.value) for each in passage.contacts])
    if way.windows is None:
        return always(way.rate_bps)
    windows = [Window(ns(each.from_s), ns(each.to_s), way.rate_bps) for each in way.windows]
    return Contacts(windows, ns(way.windows_period_s or 0.0))
