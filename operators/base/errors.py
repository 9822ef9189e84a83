"""Why an operator cannot do its work; each text is written for the user."""

from ... import core


class ObjectError(core.UmbilicsError):
    """The object is not one that can be read, or not one that can be written to."""


class AttributeNameError(core.UmbilicsError):
    """A mesh attribute is missing, or its name is taken by something of another type."""


class ChangedMeshError(core.UmbilicsError):
    """The mesh is no longer the one that was analysed."""


class FileError(core.UmbilicsError):
    """A file cannot be read, holds no mesh, or cannot be written."""
