"""The manifest of a policy bundle: manifest.json."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Final, Literal, Self, TypeAlias

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

SCHEMA_VERSION: Final[Literal[2]] = 2
MANIFEST: Final = "manifest.json"
NETWORK: Final = "policy.onnx"
WEIGHTS: Final = "weights.safetensors"

Name: TypeAlias = Annotated[str, Field(min_length=1, max_length=1000)]
Count: TypeAlias = Annotated[int, Field(gt=0, le=10**15)]
Whole: TypeAlias = Annotated[int, Field(ge=0, le=10**15)]
Seed: TypeAlias = Annotated[int, Field(ge=0, lt=2**63)]
Number: TypeAlias = Annotated[float, Field(allow_inf_nan=False)]
Weight: TypeAlias = Annotated[float, BeforeValidator(lambda v: math.inf if v == "Infinity" else v)]
Sha256: TypeAlias = Annotated[str, Field(pattern="^[0-9a-f]{64}$")]


class _Record(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, ser_json_inf_nan="strings", defer_build=True)


class ObservationSpec(_Record):
    """The observation of the policy: `size` numbers, each with its name, its unit and the scale that multiplies it."""

    layout: Name  # "custom" for a list of groups that has no name
    groups: tuple[Name, ...]  # that the numbers belong to, in order
    size: Count
    names: tuple[Name, ...]
    units: tuple[str, ...]
    scales: tuple[Number, ...]

    @classmethod
    def of(cls, layout: str, groups: tuple[str, ...], components: Sequence[tuple[str, str, float]]) -> Self:
        """Return the record of a layout, by (name, unit, scale) of each number."""
        names, units, scales = zip(*components, strict=True)
        return cls(layout=layout, groups=groups, size=len(names), names=names, units=units, scales=scales)

    @model_validator(mode="after")
    def _all_of_one_size(self) -> ObservationSpec:
        for field, values in (("names", self.names), ("units", self.units), ("scales", self.scales)):
            if len(values) != self.size:
                raise ValueError(f"{field} has {len(values)} entries, but size is {self.size}")
        return self


class ActionSpec(_Record):
    """The action of the policy: `size` numbers, clipped to `limits` before they are applied."""

    size: Count
    meaning: Name
    limits: tuple[Number, Number]

    @model_validator(mode="after")
    def _low_below_high(self) -> ActionSpec:
        if not self.limits[0] < self.limits[1]:
            raise ValueError(f"limits {list(self.limits)} must be [low, high] with low < high")
        return self


class NetworkSpec(_Record):
    """The multilayer perceptron between them."""

    hidden_sizes: tuple[Count, ...]
    activation: Literal["elu", "tanh", "relu"]


class SelectionRecord(_Record):
    """How the weights were selected among a training's checkpoints: by the most successes, the later of equals."""

    suite: Name
    seed: Seed
    trials: Count  # of all cases together
    successes: Whole
    candidates: Count  # how many were evaluated
    last_step: Whole  # where training ended, in control steps
    stop_at: Annotated[Number, Field(gt=0, le=1)] | None  # the success rate at which training was to end


class StartRecord(_Record):
    """The policy of a training's warm start."""

    policy: Name
    observation: Name  # its layout
    steps: Whole  # of its own training
    policy_sha256: Sha256  # of its manifest.json
    weights_sha256: Sha256
    selection: SelectionRecord | None = None  # how its own weights were selected; None: the last checkpoint


class TrainingRecord(_Record):
    """Where the weights come from."""

    algorithm: Name
    recipe: Name
    recipe_sha256: Sha256
    seed: Seed
    steps: Whole  # control steps of all robots together
    wall_time_s: Annotated[Number, Field(ge=0)]
    versions: dict[Name, Name]  # of the packages that decide the result: mujoco, torch, ...
    selection: SelectionRecord | None = None  # none: the last checkpoint
    start: StartRecord | None = None  # none: random weights


class FileRecord(_Record):
    """A file of the bundle."""

    sha256: Sha256
    size: Whole  # [bytes]


class PolicyDescription(_Record):
    """The part of a manifest that the training provides."""

    schema_version: Literal[2] = SCHEMA_VERSION
    name: Name
    robot: Name
    control_period_ns: Count
    observation: ObservationSpec
    action: ActionSpec
    network: NetworkSpec
    reward: dict[Name, Weight]  # the weight of each term; "Infinity" without a cap
    training: TrainingRecord
    # The SHA-256 of each file with observation groups and reward terms of the user's, by its name. Nothing executes
    # them from here: whoever flies the policy gives the files, and another content is refused.
    plugins: dict[Name, Sha256] = Field(default_factory=dict, exclude_if=lambda plugins: not plugins)


class Manifest(PolicyDescription):
    """manifest.json: the description, and the files that belong to it."""

    files: dict[Name, FileRecord]

    @property
    def observation_layout(self) -> str | tuple[str, ...]:
        """The observation layout that the policy was trained on: its name, or the names of its groups."""
        return self.observation.groups if self.observation.layout == "custom" else self.observation.layout

    @model_validator(mode="after")
    def _lists_its_files(self) -> Manifest:
        if set(self.files) != {NETWORK, WEIGHTS}:
            raise ValueError(f"files must be {NETWORK} and {WEIGHTS}, not {', '.join(sorted(self.files)) or 'none'}")
        return self
