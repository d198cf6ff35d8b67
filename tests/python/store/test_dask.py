"""A Dask cluster computes the map; killed workers cost time only."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import rigid
from rigid.store import drive as driving
from small_maps import assert_same_map
from stores import request

distributed = pytest.importorskip("distributed")
# The sockets and loops of a cluster are closed after the last test of it.
pytestmark = pytest.mark.filterwarnings("ignore")


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    """Two workers, each a process that a nanny starts again when it dies."""
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as connected,
    ):
        yield connected


def test_a_worker_is_killed_and_the_map_is_whole(
    client: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(driving, "GROWTH", 1)  # a unit a block
    quiet = rigid.stability_map(**request(method="rk4", samples=200))
    killed: list[int] = []

    def kill(_: rigid.Progress) -> None:
        if not killed:
            killed.append(max(nanny.pid for nanny in client.cluster.workers.values()))
            os.kill(killed[0], signal.SIGKILL)

    result = rigid.stability_map(
        **request(method="rk4", samples=200, store=tmp_path / "run", executor=client, progress=kill)
    )
    assert killed
    assert_same_map(result, quiet)
    assert rigid.open_store(tmp_path / "run").status().twice == 0


def test_the_store_of_a_cluster_is_resumed_anywhere(client: Any, tmp_path: Path) -> None:
    rigid.stability_map(**request(store=tmp_path / "run", executor=client, part="1/2"))
    result = rigid.open_store(tmp_path / "run").resume(progress=False)
    assert_same_map(result, rigid.stability_map(**request()))
