"""Which of the printed figures of Harintaka 2020 follow from which."""

import matplotlib.pyplot as plt

from pgm_lab.plot import basic

# Of `follows`: name, place, printed, what became of it
BOXES = {
    "flight": (1.5, 4.2, "24 mm, 1000 m", "given"),
    "scale": (5.0, 5.0, "H/f about 40,000", "holds"),
    "gsd": (5.0, 4.0, "GSD 20 cm", "0.229 m"),
    "tie": (5.0, 2.7, "tie points\n15 mm, 40 mm", "holds: 0.07 px"),
    "table": (1.5, 1.0, "Table 1\nsix means", "given"),
    "text": (5.0, 1.4, "vertical 1.7 m", "no source:\nthe table gives 1.50, 1.53 m"),
    "ways": (
        5.0,
        0.1,
        "differ mainly at location 2",
        "no source:\nthe table does not show it",
    ),
    "horizontal": (8.6, 1.4, "horizontal 1.5 m", "no source"),
    "points": (8.6, 0.2, "35 points, 175 points", "no source"),
    "pixels": (8.6, 3.6, "1.4 to 1.7 m", "2.3 to 3 px"),
    "map": (8.6, 5.0, "1:5000, 2.5 m", "asks for 0.76 m"),
}
ARROWS = (
    ("flight", "scale"),
    ("flight", "gsd"),
    ("gsd", "tie"),
    ("gsd", "pixels"),
    ("table", "ways"),
    ("text", "pixels"),
    ("tie", "pixels"),
)
FATE = {
    "given": basic.GREY,
    "holds": basic.GREEN,
    "no source": basic.PURPLE,
    "2.3 to 3 px": basic.GREY,
    "asks for 0.76 m": basic.GREY,
}


def follows() -> None:
    """Draw which of the printed figures follow from which, and which do not."""
    fig, ax = plt.subplots(figsize=(10, 4.5))
    drawn = {}
    for name, (x, y, printed, fate) in BOXES.items():
        colour = FATE.get(fate.partition(":")[0], basic.RED)
        box: basic.Look = {"boxstyle": "round,pad=0.35", "facecolor": "white"}
        box |= {"edgecolor": colour, "linewidth": 2.4}
        text = printed if fate == "given" else f"{printed}\n→ {fate}"
        middle: basic.Look = {"ha": "center", "va": "center", "fontsize": 13.5}
        drawn[name] = ax.text(x, y, text, bbox=box, **middle).get_bbox_patch()
    for first, second in ARROWS:
        look: basic.Look = {"arrowstyle": "-|>", "color": basic.GREY, "lw": 1.8}
        look |= {"patchA": drawn[first], "patchB": drawn[second], "mutation_scale": 18}
        ends = BOXES[second][:2], BOXES[first][:2]
        ax.annotate("", *ends, arrowprops=look, zorder=0)
    ax.set(xlim=(0.2, 10.2), ylim=(-0.5, 5.6))
    ax.axis("off")
    basic.show(
        fig,
        "Printed figures in boxes, arrows from what they follow from. Green holds: H/f,"
        " and the tie points, 0.07 pixel. Red is corrected: GSD, 0.229 m. Purple has no"
        " source in what is printed: vertical 1.7 m, where the table gives 1.50 and"
        " 1.53 m; that the ways differ mainly at location 2, which the table does not"
        " show; horizontal 1.5 m; 35 and 175 points. Grey follows:"
        " 1.4 to 1.7 m are 2.3 to 3 pixels; contours of 2.5 m ask for 0.76 m.",
        colours=64,
    )
