"""What two photos have in common: the ground, and a scale to show it in."""

from dataclasses import replace

import numpy as np

from pgm_lab import _validate
from pgm_lab.camera.imaging import attitude
from pgm_lab.camera.photo import Photo
from pgm_lab.epipolar import epipole
from pgm_lab.stereo._frame import rays

# Places along each side of a photo where it is asked whether the other one shows them
EDGE = 400

# Pixels of the photo over pixels of the normal image that change nothing worth having
ALIKE = 1.05


def between(
    heights: tuple[float, float] | None, depths: tuple[float, float] | None
) -> tuple[str, np.ndarray]:
    """What says where the object lies, and between what."""
    if heights is not None and depths is None:
        name, between = "heights", _validate.of_shape(heights, (2,), "heights")
    elif depths is not None and heights is None:
        name, between = "depths", _validate.of_shape(depths, (2,), "depths")
    else:
        raise ValueError(
            "either heights or depths (least, greatest) say what both photos show; give"
            " one"
        )
    if between[0] > between[1] or (name == "depths" and between[0] <= 0):
        raise ValueError(
            f"{name} must be (least, greatest)"
            f"{', positive' if name == 'depths' else ''}; got {between.tolist()}"
        )
    return name, between


def refuse_epipoles(left: Photo, right: Photo) -> None:
    for name, one in zip(("left", "right"), epipole(left, right)):
        if one.status == "inside the photo":
            raise ValueError(
                f"the epipole lies inside the {name} photo: it shows the other station,"
                " and all epipolar lines pass through that point. Such a pair has no"
                " normal images; check the exterior orientations, or use parts of the"
                " photos without it"
            )
    axes = [attitude(photo.exterior)[2] for photo in (left, right)]
    if axes[0] @ axes[1] <= 0:
        raise ValueError(
            "the photos look in directions more than 90 degrees apart, and cannot show"
            " the same side of anything: check the exterior orientations (angles in"
            " radians)"
        )


def ground_of(
    photos: tuple[Photo, Photo], along: str, between: np.ndarray
) -> np.ndarray:
    """Object points (n, 3) around the ground that both photos show; there must be."""
    ground = _common(photos, along, between)
    if len(ground):
        return ground
    left, right = photos
    exchanged = (
        replace(left, exterior=right.exterior),
        replace(right, exterior=left.exterior),
    )
    hint = "; with their exterior orientations exchanged they would have some"
    raise ValueError(
        "the photos have no ground in common: check the exterior orientations, the"
        f" {along} {between.tolist()} and, if the photos are parts, their corners"
        + hint
        * bool(len(_common(exchanged, along, between)))
    )


def _common(photos: tuple[Photo, Photo], along: str, between: np.ndarray) -> np.ndarray:
    """Object points (n, 3) around the ground that both photos show.

    Its edge is part of the edges of both photos: of each the part that the other shows.
    """
    found = []
    for one, other in (photos, photos[::-1]):
        u = one.rays(one.outline(EDGE))
        X0 = one.exterior[:3]
        reach = np.linspace(between[0], between[1], 3)[:, None]
        down = u[:, 2] if along == "heights" else np.full(len(u), one.camera.c)
        if along == "heights":
            reach = reach - X0[2]
        t = reach / np.where(down == 0, np.nan, down)
        meets = t > 0
        points = (X0 + t[..., None] * u)[meets]
        pixels = other.seen_at(points - other.exterior[:3])
        size = np.array(other.grey.shape[::-1])
        found.append(points[((pixels >= -0.5) & (pixels <= size - 0.5)).all(-1)])
    return np.concatenate(found)


def scale(
    photos: tuple[Photo, Photo],
    ground: np.ndarray,
    places: tuple[np.ndarray, np.ndarray],
    R: np.ndarray,
    c: float,
) -> tuple[float, list[float]]:
    """Pixel size in mm, and pixels of each photo in one of them, in mid-ground."""
    middle = np.argmin(np.sum((ground - ground.mean(0)) ** 2, axis=1))
    fine = []
    for photo, xy in zip(photos, places):
        step = photo.pixel_size * np.array([(0.0, 0), (1, 0), (0, 1)])
        at = photo.seen_at(rays(xy[middle] + step, R, c))
        area = np.linalg.det(at[1:] - at[0])
        fine.append(np.sqrt(abs(area)) / photo.pixel_size)  # px per mm
    pixel = 1 / min(fine)
    if max(pixel / photos[0].pixel_size, photos[0].pixel_size / pixel) < ALIKE:
        pixel = photos[0].pixel_size
    return float(pixel), [float(pixel * one) for one in fine]
