"""Which of several shapes an object is, in whatever pose and size."""

from __future__ import annotations

from collections.abc import Sequence

from ..base.blas import one_blas_thread
from ..base.errors import MatchError
from ..base.progress import Progress
from .align import Alignment, align
from .shape import Shape


@one_blas_thread()
def identify(
    shape: Shape, others: Sequence[Shape], progress: Progress | None = None, *, scaled: bool = True
) -> list[Alignment | None]:
    """How the shape lies on each of the others; None where it is another one.

    The one with the highest `Alignment.score` is the best answer. Sizes may differ unless
    `scaled` is False.

    Examples
    --------
    An ellipsoid of `vertices` and `triangles`, as in `detect`, is itself and no longer one:

    >>> one, other = (
    ...     core.Shape.of(place, triangles, core.detect(place, triangles))
    ...     for place in (vertices, vertices * (2.0, 1.0, 1.0))
    ... )
    >>> [found is not None for found in core.identify(one, [one, other])]
    [True, False]
    """
    progress = progress or Progress()
    found: list[Alignment | None] = []
    for number, other in enumerate(others):
        part = progress.part("Matching", number / len(others), (number + 1) / len(others))
        try:
            found.append(align(shape, other, part, scaled=scaled))
        except MatchError:
            found.append(None)
    return found
