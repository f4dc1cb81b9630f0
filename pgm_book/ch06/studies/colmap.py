"""The same network for pycolmap, the bundle adjustment of COLMAP on Ceres, as a peer.

In its cameras y points down and z forward. Its pixel is the sigma of the network here,
so that all weights are 1, and its unit of length a thousandth of the object's.
"""

import numpy as np
import pycolmap

from pgm_lab import rotation

FLIP = np.diag([1.0, -1.0, -1.0])
UNIT = 1000.0


def parameters(camera, sigma):
    """The camera in COLMAP's terms; to first order in b1, which stretches x alone."""
    c = camera.c
    return np.array(
        [
            *(c * (1 + camera.b1) / sigma, c / sigma),
            *(camera.x0 / sigma, -camera.y0 / sigma),
            *(camera.K1 * c**2, camera.K2 * c**4, -camera.P2 * c, camera.P1 * c),
        ]
    )


def parameters_covariance(camera, covariance, sigma):
    """The covariance of c, x0, y0, K1, K2, P1, P2, b1 propagated to COLMAP's."""
    c = camera.c
    J = np.zeros((8, 8))
    J[:, 0] = [(1 + camera.b1) / sigma, 1 / sigma, 0, 0, 2 * camera.K1 * c] + [
        4 * camera.K2 * c**3,
        -camera.P2,
        camera.P1,
    ]
    J[0, 7] = c / sigma
    J[2, 1], J[3, 2] = 1 / sigma, -1 / sigma
    J[4, 3], J[5, 4], J[6, 6], J[7, 5] = c**2, c**4, -c, c
    return J @ covariance @ J.T


def reconstruction(network):
    """The start values and measurements of a `bundle.Network` with one camera."""
    sigma = network.sigma[0, 0]
    found = pycolmap.Reconstruction()
    found.add_camera_with_trivial_rig(
        pycolmap.Camera(
            camera_id=1,
            model="OPENCV",
            width=10**5,
            height=10**5,
            params=parameters(network.cameras[0], sigma),
        )
    )
    uv = network.xy / sigma * [1, -1]
    at = np.empty(len(uv), int)
    for j, exterior in enumerate(network.exteriors):
        own = np.flatnonzero(network.photo == j)
        at[own] = np.arange(len(own))
        image = pycolmap.Image(
            name=str(j), keypoints=uv[own], camera_id=1, image_id=j + 1
        )
        R = FLIP @ rotation.matrix(*exterior[3:])
        pose = pycolmap.Rigid3d(pycolmap.Rotation3d(R), -R @ exterior[:3] / UNIT)
        found.add_image_with_trivial_frame(image, pose)
    order = np.argsort(network.point, kind="stable")
    ends = np.cumsum(network.rays_of_points)[:-1]
    for X, rays in zip(network.points, np.split(order, ends)):
        track = pycolmap.Track()
        for ray in rays:
            track.add_element(int(network.photo[ray]) + 1, int(at[ray]))
        found.add_point3D(X / UNIT, track)
    return found


def adjust(found, gauss_newton):
    """Adjust in place, with all covariances that it offers, in one thread.

    gauss_newton: steps that the trust region does not shorten, until they are 1e-10 of
    the unknowns, which is less than 1e-5 of a standard deviation of the camera in the
    networks here; else its default settings. The datum is carried by two photos.

    Its covariance of a point holds camera and photos to be known ("conditioned on all
    other variables set constant"); those of camera and photos are complete.
    """
    config = pycolmap.BundleAdjustmentConfig()
    for image in found.images:
        config.add_image(image)
    config.fix_gauge(pycolmap.BundleAdjustmentGauge.TWO_CAMS_FROM_WORLD)
    options = pycolmap.BundleAdjustmentOptions()
    options.refine_principal_point = True
    options.print_summary = False
    solver = options.ceres.solver_options
    solver.num_threads = 1
    if gauss_newton:
        options.ceres.auto_select_solver_type = False  # dense is the fastest here
        solver.linear_solver_type = type(solver.linear_solver_type).DENSE_SCHUR
        solver.initial_trust_region_radius = 1e16
        solver.function_tolerance = solver.gradient_tolerance = 0.0
        solver.parameter_tolerance = 1e-10
    adjuster = pycolmap.create_default_ceres_bundle_adjuster(options, config, found)
    summary = adjuster.solve()
    options = pycolmap.BACovarianceOptions()
    covariance = pycolmap.estimate_ba_covariance(options, found, adjuster)
    return found, summary.ceres_summary, covariance
