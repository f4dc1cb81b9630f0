"""From pixel to photo and to the ground: image frames, scale and pixel size.

Pixel coordinates are (column, row): x right, y down, integers at pixel centres, the
origin at the centre of the top-left pixel. Photo coordinates are in millimetres: x
right, y up, the origin at the centre of the image.
"""

from pgm_lab.frames.pixel import (
    image_centre,
    interior_matrix,
    photo_to_pixel,
    pixel_size_from_sensor,
    pixel_to_photo,
)
from pgm_lab.frames.scale import flying_height, ground_sampling_distance, scale_number

__all__ = [
    "flying_height",
    "ground_sampling_distance",
    "image_centre",
    "interior_matrix",
    "photo_to_pixel",
    "pixel_size_from_sensor",
    "pixel_to_photo",
    "scale_number",
]
