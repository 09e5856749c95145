"""The library behind an open study of a hydraulically actuated tunnelling robot.

Floors, each importing only from those below: `job`; `ream`, `milling`; `paths`, `motion`,
`removal`; `surfaces`, `envelopes`; `kernels`, `arguments`, `atomic_write`, `terminal`.
Metres, radians and seconds throughout; points are (..., 3), joint positions (..., 2).
"""

__version__ = "0.2.0"
