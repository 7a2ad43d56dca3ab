"""Messages of fixed layout say what protobuf's own say."""

from __future__ import annotations

import pytest
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.JointState_pb2 import JointState
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3
from google.protobuf.timestamp_pb2 import Timestamp
from hypothesis import given
from hypothesis import strategies as st

from waypointctl.log.steps import MOMENT, NUMBER, Template, moment
from waypointctl.units import NS_PER_S

numbers = st.floats(allow_nan=False)  # a message that holds NaN is not equal to itself
names = st.text(max_size=300)
times = st.integers(0, 2**63 - 1)


def stamp(time_ns: int) -> Timestamp:
    return Timestamp(seconds=time_ns // NS_PER_S, nanos=time_ns % NS_PER_S)


@given(times)
def test_moment_is_the_timestamp_and_always_as_long(time_ns: int) -> None:
    assert Timestamp.FromString(moment(time_ns)) == stamp(time_ns)
    assert len(moment(time_ns)) == 12


@given(times, st.lists(st.tuples(names, names, numbers, numbers, numbers), max_size=5))
def test_packed_message_is_the_message(time_ns: int, rows: list[tuple[str, str, float, float, float]]) -> None:
    def message(at: Timestamp, values: list[tuple[float, float, float]]) -> FrameTransforms:
        transforms = [
            FrameTransform(
                timestamp=at, parent_frame_id=parent, child_frame_id=child, translation=Vector3(x=x, y=y, z=z)
            )
            for (parent, child, *_), (x, y, z) in zip(rows, values, strict=True)
        ]
        return FrameTransforms(transforms=transforms)

    template = Template(message(MOMENT, [(NUMBER,) * 3] * len(rows)))
    values = [value for row in rows for value in (moment(time_ns), *row[2:])]
    assert FrameTransforms.FromString(template.pack(values)) == message(stamp(time_ns), [row[2:] for row in rows])


def test_template_can_be_packed_again() -> None:
    template = Template(JointState(name="hip", position=NUMBER, velocity=NUMBER))
    template.pack([1.0, 2.0])
    assert JointState.FromString(template.pack([0.0, -0.0])) == JointState(name="hip", position=0.0, velocity=-0.0)


@pytest.mark.parametrize("values", [[], [1.0], [1.0, 2.0, 3.0]])
def test_number_of_values_must_fit(values: list[float]) -> None:
    with pytest.raises(ValueError, match="extended slice"):
        Template(JointState(name="hip", position=NUMBER, velocity=NUMBER)).pack(values)
