"""Three rotation matrices as they were printed, slips included."""

import numpy as np

from pgm_lab import rotation


def matrices(omega: float, phi: float, kappa: float) -> dict[str, np.ndarray]:
    """Evaluate three printed rotation matrices, element by element as printed."""
    angles = omega, phi, kappa
    (co, cp, ck), (so, sp, sk) = np.cos(angles), np.sin(angles)
    of_2013 = rotation.matrix(*angles)
    of_2010 = of_2013.copy()
    of_2010[0, 1] = so * ck + co * sk
    back = [
        [cp * ck, -cp * sk, co],
        [co * sk + so * sp * ck, co * sk - so * sp * sk, -so * cp],
        [so * sk - co * sp * ck, so * ck + co * sp * sk, co * cp],
    ]
    return {"(M 2.8)": of_2013, "(B 3)": of_2010, "(M 2.62)": np.array(back)}
