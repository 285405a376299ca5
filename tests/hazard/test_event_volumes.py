import numpy as np
import pytest

from avahazard.hazard.avalanches import event_volumes, one_volume, with_volumes


def test_nodes_hold_the_rate_between_their_middles() -> None:
    rate = np.array([0.5, 2.0])
    found = event_volumes(
        rate, lambda v: rate[:, None] * np.exp(-np.maximum(v - 8.0, 0.0))[None, :], 8.0, 14.0
    )
    assert found.share.sum(axis=1) == pytest.approx([1.0, 1.0])
    over = (found.share * (found.log_volume > 10.0)).sum(axis=1)
    middle = found.log_volume[found.log_volume > 10.0][0]
    step = np.diff(found.log_volume)[0]
    assert over == pytest.approx([np.exp(-(middle - step / 2 - 8.0))] * 2)


def test_one_place_has_one_node() -> None:
    found = event_volumes(np.array([0.5]), lambda v: np.empty((1, len(v))), 9.0, 9.0)
    assert (found.log_volume.tolist(), found.share.tolist()) == ([9.0], [[1.0]])


def test_more_nodes_have_no_share() -> None:
    found = with_volumes(one_volume(1e4, 2, 0.3), np.log([1e3, 1e4, 1e5]))
    np.testing.assert_allclose(np.exp(found.log_volume), [1e3, 1e4, 1e5])
    assert found.share.tolist() == [[0.0, 1.0, 0.0]] * 2


def test_where_nothing_comes_all_volumes_share_alike() -> None:
    rate = np.array([0.0, 0.4])
    found = event_volumes(rate, lambda v: np.zeros((2, len(v))), 8.0, 9.0)
    n = len(found.log_volume)
    assert found.share[0] == pytest.approx(np.full(n, 1.0 / n))
    assert found.share[1] == pytest.approx(np.eye(n)[0])
