"""The result of a click: a point in both photos and in object space, or why not."""

from dataclasses import dataclass, field

import numpy as np

THRESHOLD = 0.7  # smallest correlation, as in 2010
ACCEPTED = "accepted"
NOT_A_NUMBER = np.full(2, np.nan)


@dataclass(frozen=True, eq=False)
class Measurement:
    """A point that was clicked in the left photo; NaN or empty what was not found.

    Attributes
    ----------
    name : int
        Its number on the list; 0 before it is kept.
    left : ndarray (2,)
        (column, row) in the left photo, in pixels.
    right : ndarray (2,)
        The match in the right photo, by least squares.
    correlated : ndarray (2,)
        The match by correlation, from which least squares began.
    r, r_fine : float
        Correlation at the highest peak, and after least squares matching.
    covariance : ndarray (2, 2)
        Of `right`, in square pixels: that of least squares, and what a window of twice
        the width says differently, which a curved surface does.
    shape : ndarray (2, 2)
        ((a1, a2), (b1, b2)) of (B 2.8), (B 2.9): how the left window lies in the right
        photo.
    template : ndarray (h, w)
        Grey values of the left window.
    window : ndarray (H, W)
        Grey values of the right photo that were searched.
    corner : ndarray (2,)
        (column, row) in the right photo of the first pixel of `window`.
    map : ndarray (H - h + 1, W - w + 1)
        Correlation at each place of the template in `window`.
    curve : ndarray (k, 2)
        Epipolar curve in the right photo, in pixels.
    start : ndarray (2,)
        Where the search in the right photo began.
    reason : str
        Why there.
    photo : ndarray (2, 2)
        (x, y) in mm in the left and in the right photo.
    photo_covariance : ndarray (2, 2, 2)
        Their covariances in mm^2: each photo has half the noise of the match.
    xyz : ndarray (3,)
        Object coordinates.
    xyz_covariance : ndarray (3, 3)
        Their covariance; the orientation is taken as free of errors.
    y_parallax : float
        Distance of `right` from the epipolar curve, in pixels.
    status : str
        "accepted"; a status of `ncc.Match`; "least squares: " and one of `lsm.Match`;
        "off the epipolar line"; "intersection: " and one of `orientation.Intersection`.
    """

    left: np.ndarray
    name: int = 0
    right: np.ndarray = field(default_factory=NOT_A_NUMBER.copy)
    correlated: np.ndarray = field(default_factory=NOT_A_NUMBER.copy)
    r: float = np.nan
    r_fine: float = np.nan
    covariance: np.ndarray = field(default_factory=lambda: np.full((2, 2), np.nan))
    shape: np.ndarray = field(default_factory=lambda: np.eye(2), repr=False)
    template: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)), repr=False)
    window: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)), repr=False)
    corner: np.ndarray = field(default_factory=NOT_A_NUMBER.copy)
    map: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)), repr=False)
    curve: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)), repr=False)
    start: np.ndarray = field(default_factory=NOT_A_NUMBER.copy)
    reason: str = ""
    photo: np.ndarray = field(default_factory=lambda: np.full((2, 2), np.nan))
    photo_covariance: np.ndarray = field(
        default_factory=lambda: np.full((2, 2, 2), np.nan), repr=False
    )
    xyz: np.ndarray = field(default_factory=lambda: np.full(3, np.nan))
    xyz_covariance: np.ndarray = field(
        default_factory=lambda: np.full((3, 3), np.nan), repr=False
    )
    y_parallax: float = np.nan
    status: str = "outside"

    @property
    def accepted(self) -> bool:
        """Whether the point was found."""
        return self.status == ACCEPTED

    @property
    def sd(self) -> np.ndarray:
        """Standard deviations (3,) of X, Y, Z."""
        return np.sqrt(np.diagonal(self.xyz_covariance))

    @property
    def photo_sd(self) -> np.ndarray:
        """Standard deviations (2, 2) of x and y in mm, left and right."""
        return np.sqrt(np.diagonal(self.photo_covariance, axis1=1, axis2=2))

    @property
    def why(self) -> str:
        """The status in a plain sentence."""
        return WORDS.get(self.status, f"{self.status[:1].upper()}{self.status[1:]}.")


WORDS = {
    ACCEPTED: "Found.",
    "outside": "The click is outside of the photo.",
    "template leaves the image": "Too near to the edge of the left photo: its window"
    " would leave the photo.",
    "window leaves the image": "The point is predicted outside of the right photo.",
    "flat template": "All grey values around the click are equal: nothing to match.",
    "flat window": "The right photo has no texture there.",
    "below threshold": "Nothing in the right photo looks enough like it (r below"
    f" {THRESHOLD}): it may be hidden there, or elsewhere. A click in the right photo"
    " says where to look.",
    "ambiguous": "Two places look nearly alike. A click in the right photo says where"
    " to look.",
    "left-right check failed": "The way back from the right photo ends elsewhere:"
    " one of the photos may not show the point.",
    "peak on the border of the search": "The best place lies on the border of the"
    " search. A click in the right photo says where to look.",
    "peak on the edge of the image": "The match lies on the edge of the right photo.",
    "position not determined": "The texture is a line: along it the match is not"
    " determined. Take a corner or a spot.",
    "off the epipolar line": "The match lies off the epipolar line: it is wrong, or the"
    " orientation is.",
}
