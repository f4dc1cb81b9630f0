"""The words that say what became of a point that was to be matched.

One vocabulary for `ncc`, `lsm`, `matching`, `registration` and `stereo`.
"""

# Status: what it means, what helps
STATUSES = {
    "accepted": ("found", ""),
    "template leaves the image": (
        "the template reaches beyond the left photo",
        "take a point farther inside, or a smaller template",
    ),
    "window leaves the image": (
        "what is sought lies beyond the right photo, or too near to its edge",
        "improve the start; perhaps the right photo does not show the point",
    ),
    "no data in the template": (
        "the template touches pixels that are masked, NaN or infinite",
        "take another point, or a smaller template",
    ),
    "no data in the window": (
        "all that is searched in the right photo touches pixels without data",
        "take another point, or a smaller template",
    ),
    "flat template": ("all grey values are the same", "take a point with texture"),
    "flat window": (
        "all grey values of the right window are the same, as where it is saturated",
        "take another point, or a photo that is less exposed",
    ),
    "position not determined": (
        "all lines run one way: the position along them could be any",
        "take a corner, or a larger template",
    ),
    "peak on the edge of the image": (
        "the best place touches the edge of the right photo, or pixels without data",
        "take another point",
    ),
    "peak on the border of the search": (
        "the best place lies at the border of what was searched",
        "enlarge the search, or improve the start",
    ),
    "below threshold": (
        "nothing that was found is alike enough",
        "improve the start; perhaps the right photo does not show the point",
    ),
    "changed": (
        "textured in both photos, but matched by nothing that was searched: r is far"
        " below what the neighbours reach",
        "perhaps a field was ploughed, or a cloud hides it: leave it out",
    ),
    "ambiguous": (
        "a second place is almost as much alike",
        "take a larger template, or search less, along the epipolar line",
    ),
    "left-right check failed": (
        "sought from the right, another point of the left photo is the best",
        "perhaps only one of the photos sees the point",
    ),
    "parts disagree": (
        "small windows inside the template fit better elsewhere, as at a depth edge",
        "take a smaller template, or another point",
    ),
    "diverged": (
        "the window moved too far from its start, or took an impossible shape",
        "improve the start, or give its shape",
    ),
    "not precise enough": (
        "the predicted standard deviation is larger than was allowed",
        "take a point with more texture, or a larger template",
    ),
    "not converged": (
        "least squares matching had not converged after the last iteration",
        "take a larger template, or give its shape",
    ),
    "isolated": (
        "part of a small patch whose disparities differ from what is around it",
        "enlarge the window, or leave it out",
    ),
}
