"""Chains of transforms to the frame of a camera that do not begin at the world."""

from types import SimpleNamespace

import pytest

from eyehand.perception.cameras.ros_transforms import TransformTree


def transform(parent: str, child: str):
    shift = SimpleNamespace(x=0.1, y=0.0, z=0.0)
    still = SimpleNamespace(x=0.0, y=0.0, z=0.0, w=1.0)
    return SimpleNamespace(
        header=SimpleNamespace(frame_id=parent),
        child_frame_id=child,
        transform=SimpleNamespace(translation=shift, rotation=still),
    )


@pytest.mark.parametrize("top", ["map", "lens"])
def test_chain_to_another_frame_is_named_once(top, caplog):
    """The second chain is a circle."""
    tree = TransformTree()
    tree.add(SimpleNamespace(transforms=[transform("link", "lens"), transform(top, "link")]))
    assert tree.world_pose("lens") is None
    assert tree.world_pose("lens") is None
    assert caplog.text.count(f"lead to {top}, not to world") == 1


def test_frame_without_a_transform_has_no_pose_and_no_warning(caplog):
    assert TransformTree().world_pose("lens") is None
    assert TransformTree().world_pose("world") is None
    assert not caplog.text
