"""Images and photos with exactly known truth, for tests and experiments."""

from pgm_lab.simulate import boards
from pgm_lab.simulate.aerial import AerialPair, aerial_block, aerial_pair
from pgm_lab.simulate.images import photograph, target
from pgm_lab.simulate.landscape import Landscape, landscape
from pgm_lab.simulate.pairs import OrthoPair, ortho_pair, shrunk_pair, texture_pair
from pgm_lab.simulate.photos import (
    KnownNetwork,
    control_photo,
    network,
    pair,
    rotations,
    rough,
)
from pgm_lab.simulate.texture import Texture, grey_gradients, grey_values, texture

__all__ = [
    "AerialPair",
    "KnownNetwork",
    "Landscape",
    "OrthoPair",
    "Texture",
    "aerial_block",
    "aerial_pair",
    "boards",
    "control_photo",
    "grey_gradients",
    "grey_values",
    "landscape",
    "network",
    "ortho_pair",
    "pair",
    "photograph",
    "rotations",
    "rough",
    "shrunk_pair",
    "target",
    "texture",
    "texture_pair",
]
