"""Managers against all pairs of their objects."""

import numpy as np
import pytest
from test_face import at, cuboid, sphere, turned

import obbtree


def strewn(seed, count):
    random = np.random.default_rng(seed)
    shapes = [obbtree.Collider(shape) for shape in (cuboid(1, 2, 3), sphere(1, 10), cuboid(0.5, 0.5, 4))]
    manager = obbtree.Manager()
    for i in range(count):
        manager.insert(f"object {i}", shapes[i % 3], turned(random, 4))
    return manager


def relative(ours, name, theirs, other):
    return np.linalg.inv(ours.pose(name)) @ theirs.pose(other)


def test_a_manager_answers_as_all_pairs_do():
    for seed in range(10):
        manager = strewn(seed, 8)
        manager.ignore("object 3", "object 1")
        touching, distances = [], []
        for i, first in enumerate(manager.names):
            for second in manager.names[i + 1 :]:
                if manager.is_ignored(first, second):
                    continue
                a, b, pose = manager.collider(first), manager.collider(second), relative(manager, first, manager, second)
                distances.append(a.distance(b, pose).distance)
                touching += [(first, second)] if a.collides(b, pose) else []
        assert manager.colliding_pairs() == touching and manager.collides() == bool(touching)
        assert [names for names, _ in manager.contacts(limit=1)] == touching
        assert set(touching) <= set(manager.near_pairs()) <= set(manager.near_pairs(2.0))
        names, nearest = manager.nearest()
        assert nearest.distance == pytest.approx(min(distances), abs=1e-9)
        assert np.linalg.norm(nearest.points[0] - nearest.points[1]) == pytest.approx(nearest.distance, abs=1e-9)
        assert manager.nearest_to("object 2")[0][0] == "object 2"


def test_two_managers_answer_as_all_pairs_do():
    for seed in range(10):
        ours, theirs = strewn(seed, 4), strewn(50 + seed, 3)
        pairs = [(first, second) for first in ours.names for second in theirs.names]
        ask = [(ours.collider(i), theirs.collider(j), relative(ours, i, theirs, j)) for i, j in pairs]
        touching = [pair for pair, (a, b, pose) in zip(pairs, ask) if a.collides(b, pose)]
        assert ours.colliding_pairs_with(theirs) == touching and ours.collides_with(theirs) == bool(touching)
        assert [names for names, _ in ours.contacts_with(theirs)] == touching
        assert set(touching) <= set(ours.near_pairs_with(theirs))
        least = min(a.distance(b, pose).distance for a, b, pose in ask)
        assert ours.nearest_with(theirs)[1].distance == pytest.approx(least, abs=1e-9)
        assert ours.colliding_pairs_with(ours)[0] == ("object 0", "object 0")


def test_rows_of_poses_answer_as_moved_managers_do():
    manager, random = strewn(4, 5), np.random.default_rng(8)
    poses = np.array([[turned(random, 6), turned(random, 6)] for _ in range(60)])
    names = ["object 4", "object 0"]
    verdicts = manager.collides_each(names, poses)
    for row, verdict in zip(poses, verdicts):
        for name, pose in zip(names, row):
            manager.set_pose(name, pose)
        assert manager.collides() == verdict
    assert verdicts.dtype == bool
    with pytest.raises(ValueError, match=r"\(n, 1, 4, 4\)"):
        manager.collides_each(names[:1], poses)
    for number, message in [(np.nan, "not finite"), (2.0, "not a rotation"), (1e305, "too far")]:
        bad = poses.copy()
        bad[7, 1, 0, 0 if number == 2.0 else 3] = number
        with pytest.raises(ValueError, match=rf"row 7, object `object 0`: .*{message}"):
            manager.collides_each(names, bad)
    with pytest.raises(ValueError, match="`object 4` is named twice"):
        manager.collides_each(["object 4", "object 4"], poses)


def test_objects_come_and_go():
    manager, cube = obbtree.Manager(), obbtree.Collider(cuboid())
    assert not manager.collides() and manager.nearest() is None
    manager.insert("a", cube)
    manager.insert("b", cube, at(3))
    assert "a" in manager and "c" not in manager and len(manager) == 2 and manager.names == ["a", "b"]
    np.testing.assert_array_equal(manager.pose("b"), at(3))
    assert manager.nearest()[1].distance == 2.0
    manager.set_pose("b", at(0.5))
    assert manager.colliding_pairs() == [("a", "b")]
    manager.ignore("b", "a")
    assert not manager.collides()
    manager.consider("a", "b")
    assert manager.collides()
    # Pairs are ignored by their names, before there are such objects and after.
    manager.ignore("c", "a")
    assert manager.is_ignored("a", "c") and "c" not in manager
    for _ in range(2):
        manager.insert("c", cube)
        assert manager.colliding_pairs() == [("a", "b"), ("b", "c")]
        manager.remove("c")
    manager.consider("a", "c")
    manager.consider("nobody", "c")
    assert not manager.is_ignored("a", "c")
    manager.remove("b")
    for call in (manager.remove, manager.pose, manager.collider, manager.nearest_to):
        with pytest.raises(KeyError, match="b"):
            call("b")
    with pytest.raises(KeyError):
        manager.set_pose("b", at())
    with pytest.raises(KeyError):
        manager.collides_each(["b"], np.zeros((0, 1, 4, 4)))
    with pytest.raises(ValueError, match="not finite"):
        manager.set_pose("a", at(np.nan))
    assert "pairs" in obbtree.Manager.__doc__ and "lock" not in obbtree.Manager.__doc__
