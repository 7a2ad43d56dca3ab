"""The proof of replay: the flight is flown again from the log and nothing else, and compared bit for bit."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from waypointctl.errors import InputError
from waypointctl.flight.fly import fly
from waypointctl.flight.header import platform_facts
from waypointctl.flight.shutter import with_pictures
from waypointctl.log.messages import Message
from waypointctl.log.reader import Log, open_log
from waypointctl.replay.audited_camera import AuditedCamera
from waypointctl.replay.carried import KERNELS, Carried, altered, carried_by, made_elsewhere, unverifiable
from waypointctl.replay.compared import Compared
from waypointctl.replay.logged_lines import LoggedLines
from waypointctl.replay.milestones import milestones_of
from waypointctl.replay.verdict import Divergence, Verdict, Verification
from waypointctl.replay.whole_file import whole_file
from waypointctl.replay.witness import AuditedPolicy, Diverged, LogEnded, Witness


def verify(path: Path) -> Verification:
    """Fly the flight of a log again and compare every message; `verify_log` for a log that is open."""
    return verify_log(open_log(path))


def verify_log(log: Log) -> Verification:
    """Fly the flight of a log again and compare the whole log.

    Everything comes from the log: mission, model, policy, seed. Physics is driven by the logged actions, each of
    which is computed again from the observation. States, observations, actions, reward terms and sums, events,
    commands, acknowledgements and telemetry with their times of delivery, and checkpoints have to be equal. Pictures
    are drawn again where the same renderer is. The log is written anew on the way, and compared with the file byte
    for byte. What it says of the program and processor that wrote it cannot be compared elsewhere: then the verdict
    is a lower one.

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
    other_kernels = made_elsewhere(log, KERNELS)
    witness = Witness(log.sealed_messages(), bitwise=not other_kernels)
    policy = AuditedPolicy(carried.policy, witness, bitwise=not other_kernels)
    try:
        with carried.camera as camera, whole_file(log, carried) as whole:
            pictures = AuditedCamera(camera, witness)

            def take(message: Message) -> None:
                whole(witness(message))

            by_hand = LoggedLines(witness, carried.mission, milestones_of(log))
            fly(
                carried.mission,
                policy,
                with_pictures(take, pictures),
                robot=carried.robot,
                interrupted=by_hand.interrupted,
                console=by_hand,
            )
            if witness.upcoming is not None:
                raise witness.diverged("/event", "end", type(witness.upcoming).__name__, "the flight is over")
            whole.finish()
            compared = Compared.of(carried, witness, policy, pictures, whole)
    except Diverged as error:
        if error.rounding and other_kernels:
            reason = f"rounded otherwise at step {error.where.step} on {error.where.topic}: {', '.join(other_kernels)}"
            return Verification(Verdict.UNVERIFIABLE, witness.compared["/reward"], error.where, reason, ())
        return _diverged(error.where, witness, log)
    except LogEnded:
        ended = witness.diverged("/event", "end", "the log ends", "the flight goes on")
        return _diverged(ended.where, witness, log)
    return compared.verification(witness.compared["/action"])


def _diverged(where: Divergence, witness: Witness, log: Log) -> Verification:
    reason = f"diverged {where.place}"
    wrote, here = _software(log.metadata), _software(platform_facts())
    if wrote != here:
        reason += (
            f" (waypointctl {wrote} wrote the log, this is {here}: another program, not an altered log, may be why)"
        )
    return Verification(Verdict.DIVERGED, witness.compared["/reward"], where, reason, ())


def _software(facts: Mapping[str, str]) -> str:
    return f"{facts.get('version_waypointctl')} ({facts.get('source')})"
