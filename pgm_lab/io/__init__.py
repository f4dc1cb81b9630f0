"""Files in and out: photos, tables of numbers, GeoTIFF, and atomic writing.

It stands on the ground: all other packages may import it, and it imports none of them.
What users need of it has its public name there: `matching.read`, `registration.read`.
"""

__all__: list[str] = []
