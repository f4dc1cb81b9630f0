"""A block of photos on a cluster of two workers: the same bytes, whoever dies."""

import contextlib
import json
import os
import pickle
import random
import subprocess
import sys

import pytest

from pgm_lab import stereo
from pgm_lab.stereo import block
from tests.stereo import blocks
from tests.stereo.blocks import NUMBERS, PAIRS, content, replaced

distributed = pytest.importorskip("distributed")
dask = pytest.importorskip("dask")


@pytest.fixture(scope="module")
def photos(tmp_path_factory):
    return blocks.saved(blocks.strip()[0], tmp_path_factory.mktemp("photos"))


@pytest.fixture(scope="module")
def serial(photos, tmp_path_factory):
    folder = tmp_path_factory.mktemp("serial")
    stereo.plot_block(photos, PAIRS, folder, workers=1, **NUMBERS)
    return content(folder)


# Its workers start and end others: all that belongs to a process of its own.
CLUSTER = """
import json, logging, sys, dask, distributed
# Dask itself gives a task that killed a worker to no other
dask.config.set({"distributed.scheduler.allowed-failures": 0})
given = json.loads(sys.argv[1])
with distributed.LocalCluster(silence_logs=logging.CRITICAL, **given) as one:
    print(one.scheduler_address, flush=True)
    sys.stdin.read()
"""


@contextlib.contextmanager
def started(folder, **options):
    """Address of a cluster in another process, which ends with this block."""
    given = {"dashboard_address": ":0", "threads_per_worker": 1} | options
    call = [sys.executable, "-c", CLUSTER, json.dumps(given)]
    there = dict.fromkeys(("TMPDIR", "TEMP", "TMP"), str(folder))
    there = os.environ | there | {"PYTHONPATH": os.pathsep.join(sys.path)}
    pipes = dict(stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    with subprocess.Popen(call, env=there, stderr=subprocess.DEVNULL, **pipes) as one:
        yield one.stdout.readline().strip()


THREADS = {"processes": False, "protocol": "tcp"}  # that all end when one is killed


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    with started(tmp_path_factory.mktemp("cluster"), n_workers=2, **THREADS) as address:
        yield address


@pytest.fixture(scope="module")
def processes(tmp_path_factory):
    with started(tmp_path_factory.mktemp("processes"), n_workers=2) as address:
        yield address


@pytest.fixture(autouse=True)
def _what_a_client_keeps_for_itself_is_put_back(monkeypatch):
    """A thread for answers, and the dice for when to ask again."""
    dice = random.getstate()
    monkeypatch.setattr(distributed.Future, "_cb_executor", None)
    yield
    random.setstate(dice)
    if answers := distributed.Future._cb_executor:
        answers.shutdown()


def plot(photos, folder, client):
    return stereo.plot_block(photos, PAIRS, folder, client=client, **NUMBERS)


@pytest.mark.slow
def test_a_cluster_writes_the_same_bytes_as_the_serial_run(
    cluster, photos, serial, tmp_path
):
    with distributed.Client(cluster, set_as_default=False) as client:
        found = plot(photos, tmp_path, client)
        assert client.status == "running"  # it is not ours to close
    assert [p.status for p in found.pairs] == ["plotted"] * 3
    assert all(p.seconds > 0 for p in found.pairs)
    assert content(tmp_path) == serial


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "block").mkdir()
    return tmp_path / "block"


@pytest.mark.slow
@pytest.mark.parametrize("k, times, failed", [(2, 1, []), (3, 99, [(2, 3)])])
def test_killed_workers_cost_at_most_the_pair_that_kills_them(
    processes, photos, serial, folder, tmp_path, k, times, failed
):
    deadly = replaced(photos, k, blocks.Deadly, tmp_path, times=times)
    found = plot(deadly, folder, processes)
    assert [(p.left, p.right) for p in found.failed] == failed
    assert all(p.reason.startswith("KilledWorker: ") for p in found.failed)
    done = content(folder)
    for name in ("pair_00000_00001.npz", "pair_00001_00002.npz"):
        assert done[name] == serial[name]
    assert failed or done == serial


def test_a_task_is_small(photos, tmp_path):
    """Names and numbers go over the wire, no grey values."""
    task = block.Task(
        *((0, 1), photos[0], photos[1], (0, 1), 1.0, {}, None),
        *("0" * 32, tmp_path / "pair.npz"),
    )
    assert len(pickle.dumps(task)) < 2048 < photos[0].read().grey.nbytes


@pytest.mark.slow
def test_a_cluster_that_is_lost_is_said_and_its_pairs_stay(photos, folder, tmp_path):
    ending = replaced(photos, 2, blocks.Deadly, tmp_path)
    with dask.config.set({"distributed.comm.timeouts.connect": "200ms"}):
        with started(tmp_path, n_workers=1, **THREADS) as lost:
            with pytest.raises(ConnectionError, match="the cluster was lost"):
                plot(ending, folder, lost)
    assert (folder / "pair_00000_00001.npz").exists()


def test_no_dask_and_no_scheduler_are_said(photos, tmp_path, monkeypatch):
    for address in ("tcp://127.0.0.1:9", "nonsense"):
        with pytest.raises(ConnectionError, match=f"no dask scheduler.*{address!r}"):
            plot(photos, tmp_path, address)
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ImportError, match="pip install dask distributed"):
        plot(photos, tmp_path, "tcp://127.0.0.1:8786")


@pytest.mark.slow
def test_a_cluster_without_workers_is_said(photos, folder, tmp_path, monkeypatch):
    monkeypatch.setattr(block, "PATIENCE", 0.2)
    with started(tmp_path, n_workers=0) as idle:
        with distributed.Client(idle, set_as_default=False) as client:
            with pytest.raises(ConnectionError, match="has no worker"):
                plot(photos, folder, client)
    with pytest.raises(ConnectionError, match="client of the cluster is closed"):
        plot(photos, folder, client)


def test_a_worker_that_does_not_see_the_folder_is_named(
    cluster, photos, tmp_path, monkeypatch
):
    monkeypatch.setattr(block, "_belongs", lambda *_: None)  # the list is not written
    with pytest.raises(FileNotFoundError, match="worker tcp.* does not see"):
        plot(photos, tmp_path, cluster)
