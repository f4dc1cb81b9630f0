"""A block of photos on a cluster of two workers: the same bytes, whoever dies."""

import dataclasses
import logging
import pickle
import sys
import threading

import pytest

from pgm_lab import stereo
from pgm_lab.stereo import _cluster, _tasks
from tests.stereo.blocks import NUMBERS, Deadly, Failing, content, on_disk, strip

distributed = pytest.importorskip("distributed")
dask = pytest.importorskip("dask")

PAIRS = [(0, 1), (1, 2), (2, 3)]


@pytest.fixture(scope="module")
def photos(tmp_path_factory):
    folder = tmp_path_factory.mktemp("photos")
    return [on_disk(p, folder / f"{k}.npy") for k, p in enumerate(strip()[0])]


@pytest.fixture(scope="module")
def serial(photos, tmp_path_factory):
    folder = tmp_path_factory.mktemp("serial")
    stereo.plot_block(photos, PAIRS, folder, workers=1, **NUMBERS)
    return content(folder)


@pytest.fixture(scope="module")
def cluster():
    """Two processes; dask itself gives a task that killed one to no other."""
    with dask.config.set({"distributed.scheduler.allowed-failures": 0}):
        with distributed.LocalCluster(
            n_workers=2,
            threads_per_worker=1,
            dashboard_address=":0",
            silence_logs=logging.CRITICAL,
        ) as one:
            yield one


def test_a_cluster_writes_the_same_bytes_as_the_serial_run(
    cluster, photos, serial, tmp_path
):
    with distributed.Client(cluster, set_as_default=False) as client:
        found = stereo.plot_block(photos, PAIRS, tmp_path, client=client, **NUMBERS)
        assert client.status == "running"  # it is not ours to close
    assert [p.status for p in found.pairs] == ["plotted"] * 3
    assert all(p.seconds > 0 for p in found.pairs)
    assert content(tmp_path) == serial


@pytest.fixture
def folders(tmp_path):
    (tmp_path / "block").mkdir()
    return tmp_path / "block", str(tmp_path / "log.txt")


def trouble(photos, k, kind, log, **more):
    given = {f.name: getattr(photos[k], f.name) for f in dataclasses.fields(photos[k])}
    return [
        kind(**given, log=log, **more) if i == k else p for i, p in enumerate(photos)
    ]


def test_a_worker_killed_in_the_middle_changes_nothing(
    cluster, photos, serial, folders
):
    folder, log = folders
    deadly = trouble(photos, 2, Deadly, log)
    address = cluster.scheduler_address
    found = stereo.plot_block(deadly, PAIRS, folder, client=address, **NUMBERS)
    assert not found.failed
    assert content(folder) == serial


def test_a_pair_that_failed_on_a_worker_is_tried_again(
    cluster, photos, serial, folders
):
    folder, log = folders
    failing = trouble(photos, 0, Failing, log)
    address = cluster.scheduler_address
    found = stereo.plot_block(failing, PAIRS, folder, client=address, **NUMBERS)
    assert [p.attempts for p in found.pairs] == [2, 1, 1]
    assert content(folder) == serial


def test_a_task_is_small(photos, tmp_path):
    """Names and numbers go over the wire, no grey values."""
    task = _tasks.Task(
        (0, 1), photos[0], photos[1], (0, 1), 1.0, {}, "0" * 32, tmp_path / "pair.npz"
    )
    assert len(pickle.dumps(task)) < 2048 < photos[0].read().grey.nbytes


def plot(photos, folder, client):
    return stereo.plot_block(photos, PAIRS, folder, client=client, **NUMBERS)


def test_an_answer_that_was_lost_with_its_worker_is_in_the_file(
    cluster, photos, serial, tmp_path, monkeypatch
):
    """Dask may wait for ever for it."""

    def never(self, timeout=None):
        raise TimeoutError

    monkeypatch.setattr(distributed.Future, "result", never)
    found = plot(photos, tmp_path, cluster.scheduler_address)
    assert [p.status for p in found.pairs] == ["plotted"] * 3
    assert content(tmp_path) == serial


def test_a_cluster_that_is_lost_is_said_and_its_pairs_stay(photos, folders):
    folder, log = folders
    one = distributed.LocalCluster(
        n_workers=1,
        processes=False,
        protocol="tcp",
        dashboard_address=":0",
        silence_logs=logging.CRITICAL,
    )
    ending = trouble(photos, 2, Ending, log)
    Ending.cluster = one
    with dask.config.set({"distributed.comm.timeouts.connect": "200ms"}):
        with pytest.raises(ConnectionError, match="the cluster was lost"):
            plot(ending, folder, one.scheduler_address)
    assert (folder / "pair_00000_00001.npz").exists()


class Ending(Failing):
    """Ends the cluster while it is read."""

    def fail(self):
        threading.Thread(target=type(self).cluster.close).start()


def test_without_dask_the_error_says_what_to_install(photos, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ImportError, match="pip install dask distributed"):
        plot(photos, tmp_path, "tcp://127.0.0.1:8786")


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "nonsense", ""])
def test_a_scheduler_that_does_not_answer_is_said(photos, tmp_path, address):
    with pytest.raises(ConnectionError, match=f"no scheduler.*{address!r}"):
        plot(photos, tmp_path, address)


def test_a_client_is_a_client(photos, tmp_path):
    with pytest.raises(ValueError, match="client must be a Client; got 3"):
        plot(photos, tmp_path, 3)


def test_a_cluster_without_workers_is_said(photos, tmp_path, monkeypatch):
    monkeypatch.setattr(_cluster, "PATIENCE", 0.2)
    with distributed.LocalCluster(
        n_workers=0, processes=False, dashboard_address=":0"
    ) as idle:
        with distributed.Client(idle, set_as_default=False) as client:
            with pytest.raises(ConnectionError, match="has no worker"):
                plot(photos, tmp_path, client)
        with pytest.raises(ConnectionError, match="client of the cluster is closed"):
            plot(photos, tmp_path, client)


def test_a_worker_that_does_not_see_the_folder_is_named(
    cluster, photos, tmp_path, monkeypatch
):
    monkeypatch.setattr(_cluster, "LIST", "on another disk")
    with pytest.raises(FileNotFoundError, match="worker tcp.* does not see"):
        plot(photos, tmp_path, cluster.scheduler_address)


def test_a_pair_that_kills_every_worker_is_named_and_the_rest_goes_on(
    cluster, photos, serial, folders
):
    folder, log = folders
    deadly = trouble(photos, 3, Deadly, log, times=99)
    address = cluster.scheduler_address
    found = stereo.plot_block(deadly, PAIRS, folder, client=address, **NUMBERS)
    assert [(p.left, p.right) for p in found.failed] == [(2, 3)]
    assert found.failed[0].reason.startswith("KilledWorker: ")
    done = content(folder)
    for name in ("pair_00000_00001.npz", "pair_00001_00002.npz"):
        assert done[name] == serial[name]
