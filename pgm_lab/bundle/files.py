"""The four text files of Muliawan's program: read into a network, written from one.

White space, commas or semicolons separate the numbers and % starts a comment, as for
MATLAB's load; ids are whole numbers in any order:

    interior   c x0 y0 K1 K2 K3 P1 P2 b1 b2, in a row or a column; mm and its powers
    exterior   photo, omega, phi, kappa, XL, YL, ZL; radians, unit of the points
    points     point, X, Y, Z
    image      point, photo, x, y, sx, sy; mm

A camera.json may stand for the interior file; it says the direction of the lens, too.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pgm_lab import _validate
from pgm_lab.bundle.network import RAY, Network
from pgm_lab.camera import LENSES, PARAMETERS, Camera
from pgm_lab.camera import files as camera_files
from pgm_lab.io import files, text
from pgm_lab.io.files import printable
from pgm_lab.io.text import Source, Table

NAMES = ("interior.txt", "exterior.txt", "points.txt", "image.txt")
EXTERIOR = ("photo", "omega", "phi", "kappa", "XL", "YL", "ZL")
POINT = ("point", "X", "Y", "Z")

# In principal distances: a ray 84 degrees off the axis is in no perspective photo
FARTHEST = 10.0
NEAREST = 0.3  # mm; no camera has so short a c, but many have one of 0.3 m

COARSEST = 1e3  # mm, of an image coordinate

NO_SIGMA = (
    "Without sx and sy give one standard deviation for all: --sigma 0.001 on the"
    " command line, sigma=0.001 in Python (mm)"
)


def read(
    interior: Source,
    exterior: Source,
    points: Source,
    image: Source,
    lens: str | None = None,
    *,
    sigma: float | None = None,
) -> Network:
    """Read the four text files of a network.

    Parameters
    ----------
    interior, exterior, points, image : str or path
        The files, as described at the head of this module. Ids become `photo_names` and
        `point_names`, in the order of the files. A camera.json may stand in place of
        interior.txt; then no image point may lie outside its image.
    lens : {"backward", "forward"}, optional
        Direction of the lens model, see `camera.Camera`, which interior.txt does not
        say: "backward" when missing. A camera.json has its own.
    sigma : float, optional
        Standard deviation of all image coordinates in mm, in place of sx and sy.

    Returns
    -------
    Network

    Raises
    ------
    FileNotFoundError
        If a file is missing.
    ValueError
        If a file is wrong: its name, the number of the line, and the reason.

    References
    ----------
    Muliawan 2013, Tables 4.1 to 4.12 and the listing of the program.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from pgm_lab.datasets import muliawan2013
    >>> data = muliawan2013()
    >>> measured = data.photo, data.point, data.xy, data.sigma
    >>> camera = Camera(*data.interior)
    >>> network = Network(camera, data.exteriors, data.object_points, *measured)
    >>> with TemporaryDirectory() as folder:
    ...     again = read(*write(network, folder))
    >>> bool(np.all(again.xy == data.xy)), again.photo_names[:3]
    (True, (1, 2, 3))
    """
    if lens is not None:
        _validate.choice(lens, "lens", LENSES)
    sigma = _validate.standard_deviation(sigma)
    if sigma is not None and sigma > COARSEST:
        raise ValueError(f"sigma = {sigma:g} mm is wider than any photo")
    calibrated = None  # a camera.json knows its image too
    if str(interior).lower().endswith(".json"):
        calibrated = camera_files.read(interior)
        camera = calibrated.camera
        if lens not in (None, camera.lens):
            raise ValueError(
                f"{printable(interior)} is a camera with lens {camera.lens}: leave out"
                f" lens {lens}"
            )
    else:
        camera = _read_interior(interior, lens or LENSES[0])
    photos = text.read_table(exterior, "exterior orientations", EXTERIOR)
    objects = text.read_table(points, "object points", POINT)
    without = NO_SIGMA if sigma is None else ""
    rays = text.read_table(image, "image coordinates", RAY, 2, without)

    photo_ids = _unique(photos, "photo")
    point_ids = _unique(objects, "point")
    for name, angle in zip(EXTERIOR[1:4], photos.values[:, 1:4].T):
        degrees = (
            f"{name} = {{}} is more than a turn: radians are expected, not degrees"
        )
        photos.refuse(np.abs(angle) > 2 * np.pi, degrees, angle)
    point = _find(rays, 0, "point", point_ids, objects.path)
    photo = _find(rays, 1, "photo", photo_ids, photos.path)
    rays.refuse_repeated(
        point * len(photo_ids) + photo,
        "point {} was measured in photo {} in",
        point_ids[point],
        photo_ids[photo],
    )
    xy = rays.values[:, 2:4]
    if camera.c < NEAREST:
        pixels = "is c in metres? Millimetres are expected"
    else:
        pixels = (
            "millimetres from the middle of the photo are expected, not pixels or"
            " micrometres"
        )
    pixels = f"x = {{}}, y = {{}} lies too far out for c = {camera.c:g} mm: {pixels}"
    reduced = xy - camera.interior[1:3]
    rays.refuse(np.hypot(*reduced.T) > FARTHEST * camera.c, pixels, *xy.T)
    if calibrated is not None:
        columns, rows = calibrated.image_size
        outside = (
            f"x = {{}}, y = {{}} lies outside the image of {columns} x {rows} pixels of"
            f" {calibrated.pixel_size:g} mm in {printable(Path(interior).name)}: was"
            " the photo turned by EXIF or reduced, or is the pixel size another?"
        )
        half = (np.array((columns, rows)) / 2 + 1) * calibrated.pixel_size
        rays.refuse(np.any(np.abs(xy) > half, axis=1), outside, *xy.T)
    return Network(
        camera,
        photos.values[:, [4, 5, 6, 1, 2, 3]],
        objects.values[:, 1:],
        photo,
        point,
        xy,
        read_sigma(rays) if sigma is None else sigma,
        photo_names=tuple(photo_ids.tolist()),
        point_names=tuple(point_ids.tolist()),
    )


def _read_interior(path: Source, lens: str) -> Camera:
    content = text.read_numbers(path)
    if content.columns.tolist() not in ([10], [1] * 10):
        reason = (
            f"{len(content.numbers)} number(s) in {len(content.line)} line(s), where an"
            f" interior orientation has ten in a row or a column:"
            f" {' '.join(PARAMETERS)}"
        )
        if np.any(content.comma):
            reason += ". A comma separates columns; decimals need a point"
        text.fail(content.path, content.line[-1], reason)
    found = content.table()
    c = found.values[:1, 0]
    found.refuse(c <= 0, "the principal distance c = {} must be above zero", c)
    return Camera(**dict(zip(PARAMETERS, found.values.ravel().tolist())), lens=lens)


def read_sigma(rays: Table) -> np.ndarray:
    """Standard deviations (k, 2) of a table of image coordinates."""
    sigma = rays.values[:, 4:]
    for name, column in zip(RAY[4:], sigma.T):
        reason = f"{name} = {{}}: a standard deviation must be above zero (mm)"
        rays.refuse(column <= 0, reason, column)
        reason = f"{name} = {{}} mm is wider than any photo"
        rays.refuse(column > COARSEST, reason, column)
    return sigma


def _unique(table: Table, name: str) -> np.ndarray:
    ids = table.ids(0, name)
    table.refuse_repeated(ids, f"{name} {{}} stands in", ids)
    return ids


def _find(
    rays: Table, column: int, name: str, ids: np.ndarray, path: Path
) -> np.ndarray:
    """Return the places in `ids` of a column of ids."""
    wanted = rays.ids(column, name)
    order = np.argsort(ids)
    place = np.searchsorted(ids, wanted, sorter=order)
    found = order[np.minimum(place, len(ids) - 1)]
    file = printable(path.name)
    reason = f"{name} {{}} is not in {file}; the columns are {' '.join(RAY)}"
    rays.refuse(ids[found] != wanted, reason, wanted)
    return found


def write(
    network: Network, folder: Source, *, overwrite: bool = False
) -> tuple[Path, Path, Path, Path]:
    """Write a network into four text files, which `read` gives back bit by bit.

    Parameters
    ----------
    network : Network
        With one camera; the direction of the lens goes into a comment.
    folder : str or path
        For interior.txt, exterior.txt, points.txt and image.txt; made if missing.
    overwrite : bool
        Whether files of these names may be replaced.

    Returns
    -------
    tuple of pathlib.Path
        The four files, in the order of `read`.

    Raises
    ------
    ValueError
        If the files have no place for something: several cameras, fixed, control, check
        or chosen datum points, scale bars, covariances, names that are not whole
        numbers.
    FileExistsError
        If a file is there already.
    OSError
        If a file cannot be written; then none is, and old ones stay.
    """
    _refuse_what_files_lack(_validate.instance(network, Network, "network"))
    folder = files.local(folder, "folder", "folder")
    camera = network.cameras[0]
    photo_ids = whole_numbers(network.photo_names, "photo_names")
    point_ids = whole_numbers(network.point_names, "point_names")
    rays = zip(
        [point_ids[i] for i in network.point],
        [photo_ids[i] for i in network.photo],
        *network.xy.T.tolist(),
        *network.sigma.T.tolist(),
    )
    reordered = network.exteriors[:, [3, 4, 5, 0, 1, 2]]
    contents = (
        (f"{' '.join(PARAMETERS)}; lens {camera.lens}", [camera.interior.tolist()]),
        (f"{' '.join(EXTERIOR)}; radians", zip(photo_ids, *reordered.T.tolist())),
        (" ".join(POINT), zip(point_ids, *network.points.T.tolist())),
        (f"{' '.join(RAY)}; mm", rays),
    )
    one, two, three, four = (folder / name for name in NAMES)
    paths = one, two, three, four
    # repr has the fewest digits that are read as the same number again
    texts = {
        path: "\n".join(
            [f"% {heading}", *(" ".join(map(repr, row)) for row in rows), ""]
        )
        for path, (heading, rows) in zip(paths, contents)
    }
    files.save(texts, overwrite=overwrite)
    return paths


def whole_numbers(names: Sequence, argument: str) -> list[int]:
    """Names as ids of a file."""
    try:
        ids = [int(str(name)) for name in names]
    except ValueError:
        raise ValueError(
            f"{argument} must be whole numbers to be written as ids; got {names[:5]}"
        ) from None
    if max(map(abs, ids), default=0) > text.LARGEST_ID:
        raise ValueError(
            f"{argument} must be below 2^53, about 9e15, to be written as ids: larger"
            " ones would change"
        )
    first: dict[int, object] = {}
    for name, one in zip(names, ids):
        if first.setdefault(one, name) != name:
            raise ValueError(
                f"{argument} {first[one]!r} and {name!r} are the same number, {one}:"
                " they cannot both be an id in a file"
            )
    return ids


def _refuse_what_files_lack(network: Network) -> None:
    lacking = {
        "several cameras": len(network.cameras) > 1,
        "fixed points": len(network.fixed) > 0,
        "control": network.control is not None,
        "check points": network.check is not None,
        "chosen datum points": network.datum_points is not None,
        "scale bars": len(network.scale_bars) > 0,
        "covariances": network.covariance is not None,
    }
    if found := [name for name, there in lacking.items() if there]:
        raise ValueError(
            f"network has {', '.join(found)}, for which the four files have no place"
        )
