"""The sensed image on the reference's pixels: known shifts undone, no data kept out."""

from functools import cache

import numpy as np
import pytest

from pgm_lab import image, simulate
from pgm_lab.registration import Model, fit, pick, register, resample
from pgm_lab.registration import model as module

TEXTURE = simulate.texture(seed=3)
SHAPE = (150, 180)


@cache
def scene(shift=(0.0, 0.0), matrix=((1, 0), (0, 1)), shape=SHAPE):
    """An image whose pixel p shows what is at matrix (p - shift); grey values exact."""
    row, column = np.mgrid[: shape[0], : shape[1]]
    places = np.stack([column, row], axis=-1) - shift
    return simulate.grey_values(TEXTURE, places @ np.linalg.inv(matrix).T)


def model(parameters, kind="shift", offset=(0.0, 0.0), centre=(0.0, 0.0)):
    u = len(parameters)
    none = np.zeros((0, 2))
    return Model(
        kind, np.array(parameters, float), np.eye(u), 1.0, 10, none,
        np.zeros(0, bool), np.array(centre, float), np.array(offset, float),
    )  # fmt: skip


def test_an_affine_transformation_is_undone():
    matrix = ((1.02, 0.03), (-0.02, 0.99))
    sensed = scene((3.0, 2.0), matrix)
    parameters = (3.0, 0.02, 0.03, 2.0, -0.02, -0.01)
    again = resample(sensed, model(parameters, "affine"), SHAPE)
    off = (again - scene())[25:-25, 25:-25]  # clear of the sensed image's edges
    assert np.sqrt(np.mean(off**2)) < 0.003 * scene().std()


def test_whole_pixels_come_back_as_they_are_and_the_rest_is_masked():
    """By the parameters or by the offset; the reference may have another size."""
    sensed = np.round(scene() * 100).astype(np.uint16)
    by_offset = resample(sensed, model((0, 0), offset=(5, -3)), SHAPE)
    again = resample(sensed, model((5, -3)), SHAPE)
    assert np.ma.allequal(by_offset, again) and again.dtype == np.uint16
    assert np.array_equal(again[3:, :-5], sensed[:-3, 5:])
    assert again.mask[:3].all() and again.mask[:, -5:].all()
    assert not again.mask[3:, :-5].any() and not again.data[again.mask].any()
    assert resample(sensed, model((5, -3)), (20, 400)).shape == (20, 400)
    assert resample(scene(), model((1000, 0)), SHAPE).mask.all()
    assert resample(np.full(SHAPE, np.nan), model((0.5, 0)), SHAPE).mask.all()


def test_strips_and_pieces_change_nothing(monkeypatch):
    """Against the spline through the whole image, in strips of five rows."""
    monkeypatch.setattr(module, "STRIP", 5 * SHAPE[1])
    parameters = (3.3, 0.01, 0.02, 1.2, -0.015, 0.01)
    turned = model(parameters, "affine")
    again = resample(scene(), turned, SHAPE)
    row, column = np.mgrid[: SHAPE[0], : SHAPE[1]]
    places = turned.apply(np.stack([column, row], axis=-1))
    whole = image.resample(scene(), places, outside=np.nan)
    assert np.array_equal(again.mask, np.isnan(whole))
    assert np.abs(again - whole).max() < 1e-8 * scene().std()


@pytest.mark.parametrize("kind", ["masked", "nan"])
def test_no_data_stays_no_data_and_spoils_nothing(kind):
    sensed, hole = scene(), np.s_[60:80, 70:100]
    holed = sensed.copy()
    holed[hole] = np.nan if kind == "nan" else 1e6
    if kind == "masked":
        holed = np.ma.masked_equal(holed, 1e6)
    moved = model((0.25, 0.25))
    again = resample(holed, moved, SHAPE)
    full = resample(sensed, moved, SHAPE)
    wrong = again.mask & ~full.mask
    rows, columns = np.nonzero(wrong)
    assert (rows.min(), rows.max(), columns.min(), columns.max()) == (58, 80, 68, 100)
    assert wrong.sum() == 23 * 33
    assert np.abs(again - full).max() < 0.05 * sensed.std()


@pytest.mark.parametrize("dtype", ["uint8", "int16", "uint16", "float32", "float64"])
def test_the_type_is_kept_rounded_and_clipped(dtype):
    """A spline swings beyond 0 and the highest value at a sharp edge."""
    sharp = np.zeros((40, 40), dtype)
    sharp[:, 20:] = 1 if dtype.startswith("f") else np.iinfo(dtype).max
    again = resample(sharp, model((0.5, 0)), (40, 39))
    assert again.dtype == dtype and not again.mask.any()
    swings = resample(sharp.astype(float), model((0.5, 0)), (40, 39)).data
    assert swings.min() < 0 and swings.max() > sharp.max()
    if dtype.startswith("f"):
        assert again.data == pytest.approx(swings, abs=1e-6)
    else:
        limits = np.iinfo(dtype)
        expected = np.clip(np.round(swings), limits.min, limits.max)
        assert np.array_equal(again.data, expected)


def test_after_warping_the_shift_is_gone():
    """Where both images are exact, what is left is a thousandth of it."""
    reference, sensed = scene(shape=(300, 320)), scene((1.3, 1.6), shape=(300, 320))
    points = pick(reference, 60, sensed=sensed)
    before = register(reference, sensed, points, refine="lsm")
    again = resample(sensed, fit(before), reference.shape)
    after = register(reference, again, points, refine="lsm")
    assert min(before.accepted.mean(), after.accepted.mean()) > 0.8
    assert before.rmse_t == pytest.approx(np.hypot(1.3, 1.6), rel=1e-3)
    assert after.rmse_t < 1e-3 * before.rmse_t
