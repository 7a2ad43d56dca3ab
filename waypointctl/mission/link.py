"""The link of a mission: delay, jitter, loss, rate and contacts of each direction. What is left out has no effect."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal, TypeAlias

from pydantic import AfterValidator, Discriminator, Field, Strict, Tag, ValidationInfo, field_validator, model_validator

from waypointctl.mission.fields import DAY_S, FileName, error_at, raise_errors
from waypointctl.mission.file_model import FileModel
from waypointctl.mission.presets import PRESETS, PresetName, how_to_write_link, over_preset
from waypointctl.mission.quantity import Probability, Quantity
from waypointctl.mission.text_file import moment_of
from waypointctl.units import SIZE_UNITS_BYTES

Delay: TypeAlias = Annotated[float, Quantity("s", ge=0, le=10 * DAY_S)]
Moment: TypeAlias = Annotated[float, Quantity("s", ge=0, le=1000 * DAY_S)]
Node: TypeAlias = Annotated[int, Strict(), Field(ge=0, lt=10**18)]


class DelayAt(FileModel):
    """A row of a table of delays; between two rows the delay changes evenly."""

    at_s: Moment = Field(description="from mission start")
    delay_s: Delay = Field(description="one-way delay of what leaves then")


class Window(FileModel):
    """A time during which messages can be sent."""

    from_s: Moment = Field(description="from mission start")
    to_s: Moment = Field(description="until then the last bit can be sent")


class Bursts(FileModel):
    """Loss in bursts, after Gilbert and Elliott, as netem's 'loss gemodel' has it."""

    p: Probability = Field(description="that the good link is bad for the next message")
    r: Probability = Field(description="that the bad link is good for the next message")
    one_minus_h: Probability = Field(1.0, description="that a message is lost while the link is bad (1-h)")
    one_minus_k: Probability = Field(0.0, description="that a message is lost while the link is good (1-k)")

    @property
    def share(self) -> float:
        """The share of messages that are lost in the long run."""
        if not self.p + self.r:
            return self.one_minus_k  # it begins good and stays so
        return (self.p * self.one_minus_h + self.r * self.one_minus_k) / (self.p + self.r)


def _moment(text: str) -> str:
    if moment_of(text) is None:
        raise ValueError(f"{text!r} is not a moment of the form 2027/01/31-12:00:00")
    return text


class ContactPlan(FileModel):
    """A contact plan as ION reads it; it gives windows, rates and light times."""

    former_keys: ClassVar[Mapping[str, str]] = {"back": "reverse"}

    file: FileName = Field(description="the plan (ionrc), beside the mission file")
    from_node: Node = Field(description="the node that sends")
    to_node: Node = Field(description="the node that receives")
    reverse: bool = Field(
        False,
        description="the direction is from to_node to from_node; so for `down` where both directions share a plan",
    )
    reference: Annotated[str, AfterValidator(_moment)] | None = Field(
        None, description="mission start as yyyy/mm/dd-hh:mm:ss, for plans with absolute times"
    )

    @property
    def way(self) -> tuple[int, int]:
        """From which node to which."""
        return (self.to_node, self.from_node) if self.reverse else (self.from_node, self.to_node)


def _alone(name: str, given: object, others: dict[str, object]) -> None:
    """Refuse a field that is given beside one of the others, by their names and values."""
    also = [other for other, value in others.items() if value]
    if given and also:
        raise ValueError(f"'{name}' and '{also[0]}' are both given: keep one")


def _times_rise(rows: tuple[DelayAt, ...]) -> tuple[DelayAt, ...]:
    """Return the rows of a table; raises a ValidationError for those whose times do not rise."""
    errors = [
        error_at(f"{after.at_s:g} s is not after the {before.at_s:g} s of the row before", (index, "at_s"), after.at_s)
        for index, (before, after) in enumerate(pairwise(rows), 1)
        if after.at_s <= before.at_s
    ]
    raise_errors("delay_table", errors)
    return rows


def _in_order(windows: tuple[Window, ...]) -> tuple[Window, ...]:
    """Return windows; raises a ValidationError for those that do not begin before they end, after the one before."""
    errors = [
        error_at(f"{each.to_s:g} s is not after {each.from_s:g} s", (index, "to_s"), each.to_s)
        for index, each in enumerate(windows)
        if each.to_s <= each.from_s
    ]
    errors += [
        error_at(
            f"{after.from_s:g} s is before the {before.to_s:g} s at which the window before ends",
            (index, "from_s"),
            after.from_s,
        )
        for index, (before, after) in enumerate(pairwise(windows), 1)
        if after.from_s < before.to_s
    ]
    raise_errors("windows", errors)
    return windows


def _loss_kind(loss: object) -> str:
    return "bursts" if isinstance(loss, dict | Bursts) else "probability"


Loss: TypeAlias = Annotated[
    Annotated[Probability, Tag("probability")] | Annotated[Bursts, Tag("bursts")], Discriminator(_loss_kind)
]
DelayTable: TypeAlias = Annotated[
    tuple[DelayAt, ...], Field(min_length=1, max_length=10_000), AfterValidator(_times_rise)
]
Windows: TypeAlias = Annotated[tuple[Window, ...], Field(min_length=1, max_length=10_000), AfterValidator(_in_order)]


class LinkDirection(FileModel):
    """One direction of the link."""

    former_keys: ClassVar[Mapping[str, str]] = {
        "windows_every": "windows_period",
        "windows_every_s": "windows_period_s",
        "duplication": "duplicate",
    }

    delay_s: Delay = Field(0.0, description="one-way delay; beside a contact plan, in place of its ranges")
    delay_table: DelayTable | None = Field(
        None, description="one-way delay that changes with time; constant before the first and after the last row"
    )
    jitter_distribution: Literal["uniform", "normal"] = Field("uniform", description="distribution of the jitter")
    jitter_s: Delay = Field(
        0.0, description="uniform: by how much a delay may differ, at most the delay; normal: its standard deviation"
    )
    jitter_file: FileName | None = Field(
        None, description="measured jitter to draw from: one number of seconds a line, beside the mission file"
    )
    keep_order: bool = Field(True, description="whether messages arrive in the order in which they were sent")
    loss: Loss = Field(0.0, description="of messages on the way: a probability, or in bursts")
    duplicate: Probability = Field(0.0, description="probability that a message arrives twice")
    queue_bytes: Annotated[float, Quantity("bytes", ge=0, le=1e8)] = Field(
        SIZE_UNITS_BYTES["MiB"], description="how much can wait to be sent; what does not fit is lost"
    )
    contact_plan: ContactPlan | None = Field(None, description="windows, rates and delays from a plan in ION's terms")
    rate_bps: Annotated[float, Quantity("bps", ge=1, le=1e12)] | None = Field(
        None, description="transmission rate; without it sending takes no time"
    )
    windows: Windows | None = Field(None, description="when messages can be sent; without them always")
    windows_period_s: Annotated[float, Quantity("s", gt=0, le=1000 * DAY_S)] | None = Field(
        None, description="the windows recur with this period"
    )

    @property
    def has_own_delay(self) -> bool:
        """Whether the delay is set here, and not by a contact plan."""
        return bool(self.delay_s) or self.delay_table is not None or self.contact_plan is None

    @field_validator("delay_table")
    @classmethod
    def _one_delay(cls, table: DelayTable | None, info: ValidationInfo) -> DelayTable | None:
        _alone("delay_table", table, {"delay": info.data.get("delay_s")})
        return table

    @field_validator("jitter_s")
    @classmethod
    def _jitter_within_delay(cls, jitter_s: float, info: ValidationInfo) -> float:
        delay_s, table = info.data.get("delay_s"), info.data.get("delay_table")
        least_s = min(row.delay_s for row in table) if table else delay_s  # None is reported already
        # The normal distribution has no bounds: what would be too early comes at once.
        is_bounded = info.data.get("jitter_distribution") == "uniform" and "delay_table" in info.data
        if is_bounded and least_s is not None and jitter_s > least_s:
            raise ValueError(f"{jitter_s:g} s is more than the delay of {least_s:g} s")
        return jitter_s

    @field_validator("jitter_file")
    @classmethod
    def _one_jitter(cls, name: str | None, info: ValidationInfo) -> str | None:
        _alone("jitter_file", name, {"jitter": info.data.get("jitter_s")})
        return name

    @field_validator("rate_bps", "windows")
    @classmethod
    def _one_plan(cls, value: object, info: ValidationInfo) -> object:
        _alone(str(info.field_name).removesuffix("_bps"), value, {"contact_plan": info.data.get("contact_plan")})
        return value

    @field_validator("windows_period_s")
    @classmethod
    def _all_windows_in_time(cls, every_s: float | None, info: ValidationInfo) -> float | None:
        windows = info.data.get("windows")
        if every_s is not None and windows is None and "windows" in info.data:  # else they are wrong already
            raise ValueError("needs 'windows'")
        if every_s is not None and windows and windows[-1].to_s > every_s:
            raise ValueError(f"{every_s:g} s ends before the last window, which ends at {windows[-1].to_s:g} s")
        return every_s


class Link(FileModel):
    """The link between operator and robot. Keys of `up` and `down` may be written here, for both directions."""

    keys_for_each: ClassVar[tuple[str, ...]] = ("up", "down")

    preset: PresetName | None = Field(
        None, description="a link by its name; values beside it replace those of the preset"
    )
    up: LinkDirection = Field(LinkDirection(), description="commands, from the operator to the robot")
    down: LinkDirection = Field(
        LinkDirection(), description="telemetry and acknowledgements, from the robot to the operator"
    )

    @model_validator(mode="before")
    @classmethod
    def _no_bare_word(cls, given: Any) -> Any:
        """Refuse a bare word, with a hint on how a preset is written."""
        if isinstance(given, str):
            raise ValueError(f"expected a mapping (key: value), found {given!r}; {how_to_write_link(given)}")
        return given

    @classmethod
    def _spread(cls, given: dict[Any, Any]) -> dict[Any, Any]:
        """Hand what is for both ways to each, the way back through the contact plan, and fill up from the preset."""
        data = super()._spread(given)
        plan = given.get("contact_plan")
        if isinstance(plan, dict):
            data["down"] = data["down"] | {"contact_plan": {**plan, "reverse": not plan.get("reverse", False)}}
        preset = given.get("preset")
        if isinstance(preset, str) and preset in PRESETS:
            for way in cls.keys_for_each:
                own = data.get(way, {})
                if isinstance(own, LinkDirection):
                    own = own.model_dump()
                if isinstance(own, dict):
                    data[way] = over_preset(preset, own, LinkDirection.bare_names())
        return data
