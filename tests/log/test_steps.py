"""What is put together from pieces is what protobuf would have written."""

from __future__ import annotations

import numpy as np
import pytest
from google.protobuf.descriptor_pb2 import DescriptorProto, FieldDescriptorProto, FileDescriptorProto
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message_factory import GetMessageClass
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from waypointctl.log import steps
from waypointctl.log.messages import Action, FloatArray, Observation, Reward, State
from waypointctl.log.proto import messages_pb2 as pb

whole = st.integers(-(2**63), 2**63 - 1)
vectors = arrays(np.float64, st.integers(0, 300), elements=st.floats(width=64))


@given(whole, whole, vectors, vectors, vectors)
def test_state_has_protobufs_bytes(time_ns: int, step: int, a: FloatArray, b: FloatArray, c: FloatArray) -> None:
    expected = pb.State(time_ns=time_ns, step=step, qpos=a.tolist(), qvel=b.tolist(), qacc_warmstart=c.tolist())
    assert steps.state(State(time_ns, step, a, b, c)) == expected.SerializeToString()


@given(whole, whole, vectors)
def test_observation_has_protobufs_bytes(time_ns: int, step: int, values: FloatArray) -> None:
    expected = pb.Observation(time_ns=time_ns, step=step, values=values.tolist())
    assert steps.observation(Observation(time_ns, step, values)) == expected.SerializeToString()


@given(whole, whole, st.text(), vectors, vectors)
def test_action_has_protobufs_bytes(time_ns: int, step: int, source: str, a: FloatArray, b: FloatArray) -> None:
    expected = pb.Action(time_ns=time_ns, step=step, source=source, commanded=a.tolist(), applied=b.tolist())
    assert steps.action(Action(time_ns, step, source, a, b)) == expected.SerializeToString()


@given(st.lists(st.tuples(st.text(), st.floats(allow_nan=False))), st.floats(allow_nan=False))
def test_reward_is_protobufs_message(terms: list[tuple[str, float]], total: float) -> None:
    data = steps.reward(Reward(5, 1, tuple(terms), total))
    named = [pb.Reward.Term(name=name, value=value) for name, value in terms]
    assert pb.Reward.FromString(data) == pb.Reward(time_ns=5, step=1, terms=named, total=total)


@given(st.integers(1, 2**29 - 1).filter(lambda number: not 19000 <= number < 20000), vectors)
def test_any_field_can_hold_an_array(number: int, values: FloatArray) -> None:
    kind, label = FieldDescriptorProto.TYPE_DOUBLE, FieldDescriptorProto.LABEL_REPEATED
    field = FieldDescriptorProto(name="values", number=number, type=kind, label=label)
    pool = DescriptorPool()
    pool.Add(FileDescriptorProto(name="a", syntax="proto3", message_type=[DescriptorProto(name="A", field=[field])]))
    expected = GetMessageClass(pool.FindMessageTypeByName("A"))(values=values.tolist())
    assert steps.doubles(number, values) == expected.SerializeToString()


@pytest.mark.parametrize(
    "array",
    [np.arange(12.0)[::3], np.arange(4, dtype=np.float32), np.arange(4, dtype=">f8"), np.arange(4)],
    ids=["strided", "float32", "big-endian", "int64"],
)
def test_memory_layout_makes_no_difference(array: FloatArray) -> None:
    assert pb.Observation.FromString(steps.doubles(3, array)).values[:] == array.tolist()
