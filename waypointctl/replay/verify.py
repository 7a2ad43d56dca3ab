"""The proof of replay: the flight is flown again from the log and nothing else, and compared bit for bit."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from waypointctl.errors import InputError
from waypointctl.log.reader import Log, open_log
from waypointctl.log.writer import LogWriter
from waypointctl.ops.fly import fly
from waypointctl.ops.header import platform_facts
from waypointctl.ops.shutter import with_pictures
from waypointctl.ops.sink import tee
from waypointctl.replay.audited_camera import AuditedCamera
from waypointctl.replay.carried import KERNELS, PROGRAM, Carried, altered, carried_by, differing, unverifiable
from waypointctl.replay.logged_lines import LoggedLines
from waypointctl.replay.milestones import milestones_of
from waypointctl.replay.records import compare_records
from waypointctl.replay.verdict import Divergence, Verdict, Verification
from waypointctl.replay.witness import AuditedPolicy, Diverged, LogEnded, Witness


def verify(path: Path) -> Verification:
    """Fly the flight of a log again and compare every message; `verify_log` for a log that is open."""
    return verify_log(open_log(path))


def verify_log(log: Log) -> Verification:
    """Fly the flight of a log again and compare every message.

    Everything comes from the log: mission, model, policy, seed. Physics is driven by the logged actions, each of
    which is computed again from the observation. States, observations, actions, reward terms and sums, events,
    commands, acknowledgements and telemetry with their times of delivery, and checkpoints have to be equal. Pictures
    are drawn again where the same renderer is. Where the same program runs on the same processor, a second log is
    written on the way, and every record of the first has to be in it: viewers' topics, metadata and attachments too.

    Raises:
        LogError: the log cannot be read.
    """
    if reason := unverifiable(log):
        return Verification(Verdict.UNVERIFIABLE, 0, None, reason, ())
    try:
        if wrong := altered(log):
            reason = f"diverged before the flight: {wrong.component} is not what was recorded"
            return Verification(Verdict.DIVERGED, 0, wrong, reason, ())
        carried = carried_by(log)
    except InputError as error:
        return Verification(Verdict.UNVERIFIABLE, 0, None, f"what the log carries cannot be used: {error}", ())
    return _fly_again(log, carried)


def _fly_again(log: Log, carried: Carried) -> Verification:
    elsewhere, another_program = differing(log, KERNELS), differing(log, PROGRAM)
    witness = Witness(log.sealed_messages(), bitwise=not elsewhere)
    audited = AuditedPolicy(carried.policy, witness, bitwise=not elsewhere)
    mission = carried.mission
    try:
        by_hand = LoggedLines(witness, mission, milestones_of(log))
        with carried.camera as camera, _second_log(carried) as second:
            pictures = AuditedCamera(camera, witness, same_program=not another_program)
            fly(
                mission,
                audited,
                with_pictures(tee(witness, second), pictures),
                robot=carried.robot,
                interrupted=by_hand.interrupted,
                console=by_hand,
            )
            if witness.upcoming is not None:
                raise witness.diverged("/event", "end", type(witness.upcoming).__name__, "the flight is over")
            second.close()
            records = compare_records(log, open_log(second.path)) if not another_program else None
            if records is not None:
                records -= pictures.handed_on  # compared with themselves
            checks = _checks(witness, audited, pictures, elsewhere, records)
    except Diverged as error:
        if error.rounding and elsewhere:
            reason = f"rounded otherwise at step {error.where.step} on {error.where.topic}: {' and '.join(elsewhere)}"
            return Verification(Verdict.UNVERIFIABLE, witness.compared["/reward"], error.where, reason, ())
        return _diverged(error.where, witness, log)
    except LogEnded:
        ended = witness.diverged("/event", "end", "the log ends", "the flight goes on")
        return _diverged(ended.where, witness, log)
    steps = witness.compared["/action"]
    same = "every bit the same" if not elsewhere else "every bit of the physics the same"
    return Verification(Verdict.EXACT, steps, None, f"{steps} control steps replayed, {same}", checks)


@contextmanager
def _second_log(carried: Carried) -> Iterator[LogWriter]:
    """Yield the writer of a log that the replay writes for comparison; it is gone afterwards."""
    header = carried.header()
    with TemporaryDirectory(prefix="waypointctl-") as folder, LogWriter(Path(folder) / "replay.mcap", header) as writer:
        yield writer


def _diverged(where: Divergence, witness: Witness, log: Log) -> Verification:
    reason = f"diverged at step {where.step} on {where.topic}, {where.component}"
    wrote, here = _software(log.metadata), _software(platform_facts())
    if wrote != here:
        reason += (
            f" (waypointctl {wrote} wrote the log, this is {here}: another program, not an altered log, may be why)"
        )
    return Verification(Verdict.DIVERGED, witness.compared["/reward"], where, reason, ())


def _software(facts: Mapping[str, str]) -> str:
    return f"{facts.get('version_waypointctl')} ({facts.get('source')})"


def _checks(
    witness: Witness, audited: AuditedPolicy, pictures: AuditedCamera, elsewhere: list[str], records: int | None
) -> tuple[str, ...]:
    counts = witness.compared
    actions = (
        f"within rounding ({', '.join(elsewhere)}), actions at most {audited.largest_difference:.1e} apart"
        if elsewhere
        else "computed again by the network, bit for bit"
    )
    whole = (
        "viewers' topics and metadata not compared: another program or processor wrote them"
        if records is None
        else f"{records} records of the file, viewers' topics, metadata and attachments among them, byte for byte"
    )
    typed = (f"{_several(counts['/console'], 'line')} typed at the console, each at its time",)
    return (
        f"{_several(counts['/state'], 'state')}, simulated from the first one and the logged actions alone",
        f"{_several(counts['/observation'], 'observation')} and {_several(counts['/action'], 'action')}, {actions}",
        f"{_several(counts['/reward'], 'reward')}, every term and sum",
        f"{_several(counts['/event'], 'event')}, {_several(counts['/link'], 'message')} that the link lost, doubled or "
        "let wait",
        f"{_several(counts['/command'], 'command')}, {_several(counts['/command_stage'], 'command stage')}, "
        f"{_several(counts['/ack'], 'acknowledgement')} and {_several(counts['/telemetry'], 'telemetry frame')}, with "
        "each time of delivery",
        f"{_several(counts['/checkpoint'], 'checkpoint')}, with the link's random streams",
        *(typed if counts["/console"] else ()),
        *pictures.checks,
        whole,
    )


def _several(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
