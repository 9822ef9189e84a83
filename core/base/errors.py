"""The errors that the core raises on purpose; front ends catch these and nothing wider."""


class UmbilicsError(Exception):
    """Base of every error the core raises deliberately; its text is written for the user."""


class InvalidSettingsError(UmbilicsError):
    """A setting is out of range, of the wrong type or does not fit the others."""


class InvalidMeshError(UmbilicsError):
    """The mesh cannot be analysed at all: no faces, wrong shapes, nothing finite."""


class ChartError(UmbilicsError):
    """Method C cannot unfold a chart of the mesh: it is closed or not a disk."""


class GuidanceError(UmbilicsError):
    """The guidance that was asked for does not exist on this surface."""


class MatchError(UmbilicsError):
    """Two shapes, or a shape and itself, do not match."""


class RemeshError(UmbilicsError):
    """The surface cannot be covered with quads."""


class FormatError(UmbilicsError):
    """A file is not what its format says."""


class CancelledError(UmbilicsError):
    """The user asked to stop; nothing was written."""
