"""Decisions of the core that can be switched off: a test has to notice each of them.

Each of these changes once passed every test. `tools/mutate --decisions` makes them one by one.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Decision:
    """What is switched off, in words; the module, what stands there once, what is put in its place,
    and the file of tests that has to fail then."""

    change: str
    module: str
    before: str
    after: str
    tests: str


DECISIONS = (
    Decision(
        "given directions turned by 90 degrees",
        "core/curvature/estimate.py",
        "        d1,\n        np.cross(normal, d1),\n        normal,\n        np.full(len(k1)",
        "        np.cross(normal, d1),\n        -d1,\n        normal,\n        np.full(len(k1)",
        "umbilics/test_detect.py",
    ),
    Decision(
        "a plan ignores which candidates are kept",
        "core/retopology/field/simplified.py",
        "np.isin(candidate, _nearest(umbilics, candidates))",
        "True",
        "retopology/field/test_simplified_field.py",
    ),
    Decision(
        "places that are vague near a border count",
        "core/umbilics/judged.py",
        "found.uncertainty > VAGUE * radius.mean(axis=1)",
        "found.uncertainty < 0.0",
        "umbilics/test_judged.py",
    ),
    Decision(
        "of a close pair one that is seen suffices",
        "core/umbilics/judged.py",
        "either & ~close",
        "either",
        "umbilics/pairing/test_unseen_pairs.py",
    ),
    Decision(
        "an umbilic takes singularities 2 lengths and 2 edges away",
        "core/retopology/poles.py",
        "CLAIM_LENGTHS, CLAIM_EDGES = 8.0, 6.0",
        "CLAIM_LENGTHS, CLAIM_EDGES = 2.0, 2.0",
        "retopology/test_poles.py",
    ),
    Decision(
        "confidence of poles always halved",
        "core/retopology/poles.py",
        "np.where(umbilics.certain[row], 1.0, 0.5)",
        "0.5",
        "retopology/test_poles.py",
    ),
    Decision(
        "confidence of poles never halved",
        "core/retopology/poles.py",
        "np.where(umbilics.certain[row], 1.0, 0.5)",
        "1.0",
        "retopology/test_poles.py",
    ),
    Decision(
        "bundles do not tell the sides of a sheet",
        "core/retopology/lines/bundles.py",
        "2.0 * apart * normal,",
        "0.0 * apart * normal,",
        "retopology/test_thin_sheets.py",
    ),
    Decision(
        "umbilics stop lines on the other side of a sheet",
        "core/retopology/lines/separatrices.py",
        "normal[found] @ normal[rows[number]] > 0.0",
        "normal[found] @ normal[rows[number]] > -2.0",
        "retopology/test_thin_sheets.py",
    ),
    Decision(
        "lines come near themselves on the other side of a sheet",
        "core/retopology/lines/truncation.py",
        'beside &= np.einsum("pc,pc->p", normal[one], normal[two]) > 0.0',
        "beside &= True",
        "retopology/test_thin_sheets.py",
    ),
    Decision(
        "marks on nine tenths of the edges are creases",
        "core/mesh/creases.py",
        "MOST_MARKED, SMALL = 0.2,",
        "MOST_MARKED, SMALL = 0.9,",
        "mesh/test_creases.py",
    ),
    Decision(
        "stretched triangles are not told from others",
        "core/curvature/scale.py",
        "STRETCHED = 1.5",
        "STRETCHED = 1e9",
        "curvature/test_scale.py",
    ),
    Decision(
        "stumps of lines do not wait for another round",
        "core/retopology/lines/spacing.py",
        "PATIENCE = 0.8",
        "PATIENCE = 0.0",
        "retopology/lines/test_spacing.py",
    ),
    Decision(
        "more smoothing is never advised",
        "core/umbilics/filters.py",
        "if detection.trust_ratio > TRUSTED and len(dropped):",
        "if False:",
        "umbilics/test_filters.py",
    ),
    Decision(
        "slivers count in normals as other triangles do",
        "core/mesh/normals.py",
        "np.multiply(scale, across, out=weights[:, corner])",
        "weights[:, corner] = 1.0",
        "mesh/test_normals.py",
    ),
    Decision(
        "two triangles take a half turn across their edge in different ways",
        "core/fields/winding.py",
        "return np.angle(np.conj(rotation) ** symmetry)",
        "return np.angle(np.conj(rotation) ** symmetry + 0.0)",
        "fields/test_winding.py",
    ),
)
