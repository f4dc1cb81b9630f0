"""A bundle adjustment in words: what was done, how well it fits, what it means."""

from collections.abc import Sequence

import numpy as np

from pgm_lab._rounding import plain
from pgm_lab.adjustment.outliers import NAMES
from pgm_lab.bundle.network import Network
from pgm_lab.bundle.result import Bundle
from pgm_lab.bundle.snooping import Snooping
from pgm_lab.report._layout import NUMBERS, Finding, count, listed

UM = 1e3  # micrometres in a millimetre

LEAST = (
    " There are no more control coordinates than the datum needs: an error moves,"
    " turns or scales the whole network, and no residual shows it."
)


def summary(result: Bundle, wrong: Finding | None = None) -> str:
    """Say in short what was adjusted, and how well it fits.

    What is `wrong` with the input comes first: then a fit says nothing.
    """
    network = result.network
    photos = count(len(network.exteriors), "photo")
    points = count(len(network.points), "point")
    cameras = count(len(network.cameras), "camera")
    what = (
        f"{photos} of {points}, taken with {cameras}: {count(len(network.xy), 'ray')}."
        f" {_balance(result)}, redundancy {result.redundancy}."
    )
    how = f"converged after {count(result.iterations, 'iteration')}"
    if result.status != "converged":
        how = f"did not converge ({result.status})"
    what = f"{what[0].upper()}{what[1:]} The adjustment {how}"
    if wrong:
        first = wrong.words.partition(". ")[0].removesuffix(".")
        return (
            f"{first}. What follows cannot be used before this is put right. {what};"
            f" its sigma0 of {plain(result.sigma0, 3)} says nothing."
        )
    return f"{what}: {_fit(result)}."


def _balance(result: Bundle) -> str:
    """Say what stands against the unknowns, the sum of which is the redundancy."""
    network = result.network
    unknowns = len(result.names) + int(np.sum(~network.held))
    coordinates = 2 * len(network.xy)
    control = int(np.sum(network.known & ~network.held))
    bars = len(network.scale_bars)
    inner = result.redundancy + unknowns - coordinates - control - bars
    against = [f"{coordinates} image coordinates"]
    against += [count(control, "control coordinate")] if control else []
    against += [count(bars, "scale bar")] if bars else []
    against += [count(inner, "inner constraint")] if inner else []
    return f"{listed(against)} for {unknowns} unknowns"


def observations(network: Network) -> str:
    """Say whose standard deviations sigma0 judges."""
    weighted = len(network.scale_bars) > 0 or np.any(network.known & ~network.held)
    return "the observations" if weighted else "the image coordinates"


def _fit(result: Bundle) -> str:
    if not result.redundancy > 0:
        return "without redundancy nothing tells how good the observations are"
    if result.sigma0 == 0:
        return "sigma0 is 0, as only computed observations fit without any error"
    stated = result.sigma0_prior or 1.0
    times = _times(result.sigma0 / stated)
    judged = observations(result.network)
    words = f"sigma0 is {plain(result.sigma0, 3)}, so {judged} are {times}"
    sigma = UM * result.network.sigma
    if np.ptp(sigma) == 0:
        found, stated = sigma.flat[0] * result.sigma0, sigma.flat[0] * stated
        image = ", the image coordinates" if judged == "the observations" else ","
        words += f"{image} {plain(found)} µm in place of {plain(stated)} µm"
    return words


def _times(ratio: float) -> str:
    """Say how precise observations are whose sd is `ratio` times the stated one."""
    direction = "better" if ratio < 1 else "worse"
    factor = max(ratio, 1 / ratio)
    if factor < 1.1:
        return "as good as stated"
    if factor < 1.75:
        return f"about {100 * abs(ratio - 1):.0f} % {direction} than stated"
    if factor > len(NUMBERS):
        return f"about {plain(factor, 3)} times {direction} than stated"
    whole = round(factor)
    word = NUMBERS[whole] if abs(factor - whole) <= 0.25 else f"{factor:.1f}"
    return f"about {word} times {direction} than stated"


def snooping(found: Snooping) -> str:
    """Say what data snooping did, and why it stopped."""
    test = NAMES[found.result.residual_test]
    tested = f"Residuals were tested by {test}, its limit is {found.critical:.2f}."
    if not found.removed:
        why = found.stopped.rstrip(".")
        return f"Data snooping rejected no observation: {why}. {tested}"
    rays = count(len(found.removed), "ray")
    before, after = (plain(one.sigma0, 3) for one in (found.before, found.result))
    return (
        f"Data snooping took out {rays}, one at a time, and sigma0 went from"
        f" {before} to {after}. It stopped with: {found.stopped.rstrip('.')}."
        f" {tested} What was taken out is listed below: look there for the cause before"
        " you accept it."
    )


def datum(result: Bundle) -> str:
    """Say which datum was used, and what it means for the standard deviations."""
    if result.datum == "fixed":
        return (
            "The control points carry the datum: coordinates and standard deviations"
            " are in their system, and the latter grow away from them. An error of a"
            " control point that is held shows in no standard deviation."
            + (LEAST if _control_is_least(result.network) else "")
        )
    chosen = result.network.datum_points
    these = "all points" if chosen is None else count(len(chosen), "chosen point")
    if result.datum == "photos":
        these = "the projection centres"
    given, bars = "Origin, directions and scale", ""
    if len(result.network.scale_bars):
        given, bars = "Origin and directions", " The scale bars give the scale."
    return (
        f"A free network: inner constraints on {these}. {given} are those of"
        " good start values, on the average of these; rough ones let them drift, since"
        f" each iteration starts from the last.{bars} Standard deviations count from"
        " their middle: they tell how well the shape of the network is known, not"
        " where it lies in a national system, and no other datum makes them smaller"
        " there on the whole. Camera, sigma0, residuals, angles and ratios of distances"
        " are the same in every datum."
    )


def _control_is_least(network: Network) -> bool:
    """Whether there are as many control coordinates as motions to stop."""
    return np.sum(network.known) == (6 if len(network.scale_bars) else 7)


def conventions(result: Bundle) -> Sequence[str]:
    """List what the numbers mean."""
    test = {
        "w": "w (Baarda's, with the sigma0 stated before the adjustment)",
        "tau": "tau (Pope's, with the sigma0 estimated by the adjustment)",
    }[result.residual_test]
    P = "P = 1 / sigma^2"
    if result.network.covariance is not None:
        P = "the inverse covariances of the rays, 2 x 2, on the diagonal of P"
    lens = {
        "backward": "The lens is modelled backward: the displacement is a correction,"
        " added to measured coordinates to make them ideal.",
        "forward": "The lens is modelled forward: the displacement is added to ideal"
        " coordinates to give the measured ones.",
    }[result.cameras[0].lens]
    return (
        "The camera looks along its -z axis; x points right and y up, in mm from the"
        " middle of the photo: x - x0 = -c U / W, y - y0 = -c V / W with (U, V, W) ="
        " M_kappa M_phi M_omega (X - X0). X0, Y0, Z0 are the projection centre, XL, YL,"
        " ZL in the files. Object coordinates are in the unit of the input.",
        f"{lens} With x, y reduced to the principal point: dx = x (K1 rho^2 + K2 rho^4"
        " + K3 rho^6) + P1 (rho^2 + 2 x^2) + 2 P2 x y + b1 x + b2 y, dy = y (K1 rho^2"
        " + K2 rho^4 + K3 rho^6) + P2 (rho^2 + 2 y^2) + 2 P1 x y.",
        "Residuals v are computed - observed. sigma0^2 = v'Pv / redundancy, with"
        f" {P}. Standard deviations (sd) are a posteriori, multiplied by"
        f" sigma0. t is a value over its sd; {test} is a residual over its own sd, a"
        " redundancy number r the part of an error that its residual shows.",
    )
